"""Numbers and names for people: 52.4, 1.83·10⁷, 3 %, tip payload, accelerometer of link 5."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from boom_mj.effects import Effect, effect_library

MINUS, DASH, SPACE = "\N{MINUS SIGN}", "\N{EN DASH}", "\N{NO-BREAK SPACE}"
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float | None, digits: int = 3) -> str:
    """A number with so many significant digits; "no bound" where there is none."""
    if value is None or not np.isfinite(value):
        return "no bound"
    text = f"{value:z#.{digits}g}".rstrip(".")
    if "e" in text:
        mantissa, _, power = text.partition("e")
        if 0 < int(power) < 5:
            return f"{value:.0f}"
        text = f"{mantissa}·10{str(int(power)).translate(RAISED)}"
    return text.replace("-", MINUS)


def gap_size(value: float | None) -> str:
    """A gap: 0.99, 13.8, 140; a dash where nothing was measured."""
    if value is None or not np.isfinite(value):
        return DASH
    return f"{value:.{2 if value < 9.995 else 1 if value < 99.95 else 0}f}"


def digits_of(low: float | None, high: float | None) -> int:
    """Significant digits that an interval deserves: one more than its width has."""
    if low is None or high is None or not low < high:
        return 3
    size = max(abs(low), abs(high))
    return int(np.clip(np.ceil(np.log10(size / (high - low))) + 1, 3, 6))


def percent(share: float) -> str:
    """A share: 3 %, 0.4 %."""
    text = f"{100 * share:.1f}" if 0.0005 <= abs(share) < 0.0095 else f"{100 * round(share, 2) + 0.0:.0f}"
    return text.replace("-", MINUS) + SPACE + "%"


def effect_name(effect: Mapping[str, Any]) -> str:
    """An effect {id, location} in words: link stiffness (link 5, axis w)."""
    place = ", ".join(f"{key} {value}" for key, value in effect["location"].items())
    return effect["id"].replace("_", " ") + (f" ({place})" if place else "")


def explanation_name(explanation: Mapping[str, Any]) -> str:
    """An explanation of one effect, or of several: {id, location, with}."""
    return " and ".join(map(effect_name, (explanation, *explanation.get("with", ()))))


def capital(text: str) -> str:
    """With a capital letter."""
    return text[:1].upper() + text[1:]


def physics(effect: Effect) -> str:
    """The first paragraph of an effect's docstring."""
    return " ".join((type(effect).__doc__ or "").split("\n\n")[0].split())


def spoken(sentence: str) -> str:
    """A sentence of the answer with ids, links and percentages as people write them."""
    for name in effect_library():
        for written in (name, name.capitalize()):
            sentence = sentence.replace(written, written.replace("_", " "))
    return re.sub(r"(\d)%", rf"\1{SPACE}%", re.sub(r"\blink(\d)", r"link \1", sentence))


def spaced(link: str) -> str:
    """link5 -> link 5."""
    return link.replace("link", "link ")
