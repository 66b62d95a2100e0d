"""Textbook models, each with data, its parameters fitted, its states smoothed, and a picture."""

from kalmanq_studies.gallery.entries import ENTRIES, Entry

__all__ = ["ENTRIES", "Entry"]
