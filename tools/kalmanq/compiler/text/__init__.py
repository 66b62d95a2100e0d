"""NAME.c and NAME.h from the templates.

product    all of a constant model;  equation_product: of a nonlinear one;  equation_device_text: over the library
emit       what the template of NAME.c is given;  head: NAME.h;  delayed: measurements that come late
over_library  a constant model over the library
"""
