"""What a model is: its matrices and names, its file, the builders of textbook models."""

from kalmanq.model.model import SIZE_MAX, Gaps, Model, Quantities, Quantity, Reading, Sensor, root_of

__all__ = ["SIZE_MAX", "Gaps", "Model", "Quantities", "Quantity", "Reading", "Sensor", "root_of"]
