"""q31: binary points that are constants, and lines of C that keep them.

words      a constant model: factor, mean, formats, readings;  first: the P0 that formats bear;  rescaled: words that become finer;  loops: those for large models
formulas   of a nonlinear model, in words whose points come from records;  device: over the library
expressions, lines: of C;  routines, functions: that they call;  python: these for Python
"""
