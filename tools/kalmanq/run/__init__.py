"""Linear filters and smoothers of the C core, row by row, as sequences and as campaigns of many runs."""
