"""What all documents are made of."""

from pydantic import BaseModel, ConfigDict

Number = float | None
"""null where it is unknown or not finite."""


class Part(BaseModel):
    """A part of a document, which may hold more."""

    model_config = ConfigDict(extra="allow", strict=True, use_attribute_docstrings=True)
