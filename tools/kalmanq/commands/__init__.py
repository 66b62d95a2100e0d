"""One module a command: what `kalmanq NAME` does."""
