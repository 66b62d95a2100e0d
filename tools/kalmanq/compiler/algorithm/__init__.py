"""Predict and update as formulas and lines of C.

arithmetic what the text asks of an algorithm;  facts: entries that are constant, or equal to another
ud         the factor as an algorithm over formulas;  floats: f32 and f64;  loops: those for large models;  double_words: a float twice as long
cycle      sensors at different rates;  lag: the mean some samples ago;  coefficients: A, Q and R as numbers or fields
equations  of a nonlinear model;  back: its smoother;  equation_device: over the library
fixed      q31
"""
