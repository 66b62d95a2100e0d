"""The emitted C on this machine.

building   a library of C;  host: builds and calls the filter's;  record: rows that it is tried with, and long double beside it;  trial: NAME_test.c
simulation as a filter of kalmanq.run;  lint: what a float does to a model's own formulas
"""
