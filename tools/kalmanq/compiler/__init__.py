"""A constant linear model as C of its own: straight lines for exactly this filter.

request    what is to be compiled: the model's numbers as its C has them, and the options
exact      numbers to 50 digits and more;  enclosure: after how many full samples the gain is constant, by a bound
graph      formulas that fold;  printing: C of them;  facts: entries that are constant, or equal to another
ud         the factor as an algorithm over formulas;  floats: f32 and f64;  loops: those for large models
growth     what grows without end while nothing is measured;  slow: entries that move by less than a float resolves
words      q31, with the modules word_...;  coefficients: A, Q and R as numbers or fields
cycle      sensors at different rates;  lag: the mean some samples ago
emit       NAME.c;  head: NAME.h;  trial: NAME_test.c;  report: NAME_report.txt
product    all of it;  host: the emitted C on this machine;  record: what it is tried with, and long double beside it
fixed_...  a nonlinear model's formulas in q31: values that give formats, lines, functions, the device, what it was tried with
"""
