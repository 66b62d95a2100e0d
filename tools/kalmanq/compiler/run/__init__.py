"""The emitted C on this machine.

host       builds and calls it;  record: rows that it is tried with, and long double beside it;  trial: NAME_test.c
simulation as a filter of kalmanq.run;  lint: what a float does to a model's own formulas
"""
