"""A section of the page: a name, a title, and the facts that its template shows."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Section:
    """What one template shows.

    Attributes:
        name: of the template `<name>.html` and of the anchor.
        title: in the page and in its list of contents.
        facts: what the template knows as `facts`.
    """

    name: str
    title: str
    facts: Mapping[str, Any]
