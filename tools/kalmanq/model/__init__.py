"""What a model is: its matrices and names, its file, the builders of textbook models."""

from kalmanq.model.column_model import ColumnModel
from kalmanq.model.model import SIZE_MAX, Gaps, Model, Quantities, Quantity, Reading, Sensor, root_of

__all__ = ["SIZE_MAX", "ColumnModel", "Gaps", "Model", "Quantities", "Quantity", "Reading", "Sensor", "root_of"]
