"""A filter as firmware: ranges and formats, costs on each core, the design that fits, and its C file."""
