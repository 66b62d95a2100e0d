"""A model as C of its own.  kalmanq.formulas makes graphs of what a model says; from there:

given      the request: numbers as the C has them, what is known of the steady state
algorithm  predict and update, as formulas and lines: UD in f32 and f64, a root and constant binary points in q31
templates  the C around these lines;  text: NAME.c and NAME.h of them
run        the C on this machine: records, the same in long double, NAME_test.c
report     NAME_report.txt, costs, offers
"""
