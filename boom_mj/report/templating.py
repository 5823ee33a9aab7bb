"""Pages are one file each, with everything in it: `templates/page.html` is the frame, each page fills its blocks."""

from collections.abc import Callable
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined


def page_environment(package: str, **filters: Callable[..., Any]) -> Environment:
    """Templates of a package and those that all pages share; names that are missing are errors."""
    loader = ChoiceLoader([PackageLoader(package), PackageLoader("boom_mj.report")])
    found = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    found.filters.update(filters)
    return found
