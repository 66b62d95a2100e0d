"""The theory's examples: each computes its numbers in one arithmetic of the C core, and draws one figure.

A file an example.  Nothing here filters or smooths by itself: means and covariances are what the core says.
"""

from kalmanq_studies.lectures import concentration, densities, prediction_error, rocket, smoothing, stationary
from kalmanq_studies.lectures.example import Example

EXAMPLES: dict[str, Example] = {
    "rocket": rocket.EXAMPLE, "densities": densities.EXAMPLE, "concentration": concentration.EXAMPLE,
    "prediction-error": prediction_error.EXAMPLE, "stationary": stationary.EXAMPLE, "smoothing": smoothing.EXAMPLE,
}

__all__ = ["EXAMPLES", "Example"]
