"""What is to be compiled, and what is known of it before any C is made.

request    the model's numbers as its C has them, and the options;  names: of states and measurements in C
exact      numbers to 50 digits and more;  enclosure: after how many full samples the gain is constant, by a bound
growth     what grows without end while nothing is measured;  slow: entries that move by less than a float resolves
far        rows that a float rounds by more than their share of a sigma
rates      of sensors, as data show them
stepping   steps of a model in continuous time
"""
