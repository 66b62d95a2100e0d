"""Studies of many runs, each with its page of findings: `kalmanq study NAME`."""
