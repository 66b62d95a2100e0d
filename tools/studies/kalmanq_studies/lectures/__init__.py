"""The theory's examples: each computes its numbers in one arithmetic of the C core, and draws one figure.

A file an example.  Nothing here filters or smooths by itself: means and covariances are what the core says.
"""

from kalmanq_studies.lectures import numerics, smoothing, stationary
from kalmanq_studies.lectures.example import Example

EXAMPLES: dict[str, Example] = {"stationary": stationary.EXAMPLE, "smoothing": smoothing.EXAMPLE,
                                 "numerics": numerics.EXAMPLE}

__all__ = ["EXAMPLES", "Example"]
