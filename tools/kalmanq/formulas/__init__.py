"""Formulas: a user's Python functions as expressions, their derivatives, and their values."""
