"""A constant model as C of its own: straight lines for exactly this filter, and what is proven of them.

exact       the model's numbers to 50 digits, what it settles to
classes     covariances and ranges over a declared class of missing samples
sums        expressions that fold while an algorithm runs over them
lines       straight-line code: a name and a formula a line
floats      words and means of f32;  fixed: of q31
forms       the filter's algorithms, once for both
structure   which entries of the covariance are constants, or equal to another
text        NAME.c and NAME.h;  trial_file: NAME_test.c;  proof_file: NAME_proof.txt
costs       what it costs on a core, about, from the operations of its C
search      every covariance that the C can come to, by running it
product     all of it, and which form is taken
"""
