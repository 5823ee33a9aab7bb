"""The page of a diagnosis: whole for every verdict, fetches nothing, believes no name, shows numbers only."""

import re
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from diagnoses import (
    CHANNELS,
    HOSTILE,
    NAMES,
    VERDICTS,
    diagnosis,
    predictor,
)

from boom_mj.diagnosis import document, nominal_predictor, steps
from boom_mj.diagnosis.sentences import sentence
from boom_mj.effects import behind, make_effect
from boom_mj.report import write_diagnosis
from boom_mj.report.diagnosis.page import SECTIONS, diagnosis_page
from boom_mj.report.diagnosis.verdict import _fall
from boom_mj.report.diagnosis.view import View
from boom_mj.report.words import digits_of, gap_size, number, percent, spoken
from boom_mj.systems.as_built import AsBuilt
from boom_mj.systems.predictor import Predictor


@cache
def page(case: str, training: int = 2) -> str:
    found = diagnosis(case, training)
    return diagnosis_page(found, document(found, NAMES, channels=CHANNELS))


class Reader(HTMLParser):
    """Walks a page and keeps what it needs to be judged by; every element must be closed where it was opened."""

    VOID = ("meta", "link", "img", "br", "hr", "input", "col")

    def __init__(self, text: str):
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str, str]] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()
        assert not self.open, f"never closed: {self.open}"

    def handle_startendtag(self, tag: str, attrs: list) -> None:
        self.tags.append(tag)
        self.attributes += [(tag, name, value or "") for name, value in attrs]

    def handle_starttag(self, tag: str, attrs: list) -> None:
        self.handle_startendtag(tag, attrs)
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-3:]}"
        self.open.pop()

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    def values(self, name: str) -> list[str]:
        return [value for _, found, value in self.attributes if found == name]


def links(reader: Reader) -> list[str]:
    return [value for name in ("href", "xlink:href", "src") for value in reader.values(name)]


@pytest.mark.parametrize("case", VERDICTS)
def test_the_page_is_whole(case: str) -> None:
    reader = Reader(page(case))
    ids = reader.values("id")
    assert len(ids) == len(set(ids))
    assert {module.__name__.rpartition(".")[2] for module in SECTIONS} <= set(ids)
    assert {value[1:] for value in links(reader) if value.startswith("#")} <= set(ids)
    assert reader.tags.count("svg") > 5
    pictures = [tag for tag, name, value in reader.attributes if (name, value) == ("role", "img")]
    assert len(pictures) <= len([value for value in reader.values("aria-label") if value])
    assert case.split()[0] in "".join(reader.words)


@pytest.mark.parametrize("case", VERDICTS)
def test_the_page_fetches_nothing(case: str) -> None:
    reader = Reader(page(case))
    assert not {"script", "link", "img", "iframe", "object", "base"} & set(reader.tags)
    assert all(value.startswith(("#", "data:image/png;base64,")) for value in links(reader))
    assert not [name for _, name, _ in reader.attributes if name.startswith("on")]
    assert re.findall(r"url\((?!#)|@import|https?:", page(case).replace("https://evil.example", "")) == []


def test_names_are_shown_and_not_believed() -> None:
    text = page("explained")
    assert "&lt;script src=" in text
    assert HOSTILE in "".join(Reader(text).words)


@pytest.mark.parametrize(("case", "training"), [*((case, 2) for case in VERDICTS), ("explained", 3)])
def test_all_numbers_are_numbers(case: str, training: int) -> None:
    reader = Reader(page(case, training))
    shown = [*reader.words, *(value for _, _, value in reader.attributes if not value.startswith("data:"))]
    assert [text for text in shown if re.search(r"\b(nan|inf)\b", text, re.IGNORECASE)] == []
    assert [text for text in reader.words if re.search(r"\bNone\b", text)] == []


def test_a_rival_of_implausible_size_is_said_to_be_one() -> None:
    found = diagnosis("ambiguous")
    (rival,) = found.ties
    assert "so would link_mass link 5;" in sentence(found)
    odd = replace(rival.fit, effects=(make_effect("link_length", {"link": 5, "error": 0.9}),))
    other = replace(found, ties=(replace(rival, fit=odd),))
    assert "so would link_mass link 5, of implausible size;" in sentence(other)


def test_the_verdict_is_told() -> None:
    words = {case: "".join(Reader(page(case)).words) for case in VERDICTS}
    assert "Simulator and machine agree" in words["consistent"]
    assert "Tip payload explains the gap" in words["explained"]
    assert "release_bow_vertical" in words["ambiguous"]
    assert "link mass (link 5)" in words["ambiguous"]
    assert "does not explain enough" in words["unexplained"]
    for case in ("partial", "partial beside a suspect"):
        assert "Tip payload, and something else" in words[case]
        assert "Causes that are sure, though something is left" in words[case]
        assert "does not explain enough" not in words[case]
        assert ("Suspects: what else helps" in words[case]) == (case != "partial")
    assert "raises the gap" in words["explained"]
    assert "with causes" not in words["consistent"]


def test_the_way_from_the_data_sheet_is_shown() -> None:
    for case in ("explained", "consistent"):
        words = " ".join(" ".join(Reader(page(case)).words).split())
        assert "8.25 7.50" + " 1.12" * (case == "explained") in words
        assert "link mass (link 5), factor 1.0000 ± 0.0030 1.0000" in words
    gaps = document(diagnosis("explained"), NAMES)["gap"]["holdout"]
    assert list(gaps) == ["nominal", "before", "after", "floor"] and gaps["before"] > gaps["after"]


def test_gaps_before_and_after_are_those_of_the_residuals() -> None:
    found = diagnosis("explained")
    view, data = View(found, NAMES, {}), found.model.data
    for residuals, side in ((found.as_built, "before"), (found.best.fit.residual, "after")):
        rows = [c for c in data.channels if c.recording == 2]
        counts: dict[str, int] = {}
        for channel in rows:
            counts[channel.group] = counts.get(channel.group, 0) + int(np.isfinite(channel.measured).sum())
        total = sum(counts[name] * getattr(change, side) ** 2 for name, change in view.by_group.items())
        assert total == pytest.approx(float(residuals[data.held_out] @ residuals[data.held_out]), rel=1e-12)
    shown = (view.data.measured - view.built) * found.model.noise.weight
    assert np.nanmax(np.abs(shown - found.as_built)) < 1e-6


def test_a_machine_that_healthy_recordings_inform_has_a_page() -> None:
    found, softer = diagnosis("explained"), make_effect("link_stiffness", {"link": 3, "axis": "v", "factor": 0.97})
    built = Predictor(AsBuilt(found.model.system, (softer,)), found.model.data, threads=1)
    found = replace(found, model=replace(found.model, predictor=built))
    assert nominal_predictor(found).system is predictor(2).system
    assert (
        steps(found)["data_sheet"] == () and [steps(found)[s][0] for s in ("as_built", "with_causes")] == [softer] * 2
    )
    assert "On the machine" in diagnosis_page(found, document(found, NAMES))


def test_the_file_is_written(tmp_path: Path) -> None:
    found = diagnosis("explained")
    write_diagnosis(found, document(found, NAMES), tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text()
    assert text.startswith("<!DOCTYPE html>")
    assert text.rstrip().endswith("</html>")


@pytest.mark.parametrize(
    ("said", "text"),
    [
        (number(52.3549, 4), "52.35"),
        (number(1.8318e7), "1.83·10⁷"),
        (number(2.5e-6, 2), "2.5·10⁻⁶"),
        (number(-0.0), "0.00"),
        (behind("kg") + behind("1") + behind(""), " kg"),
        (number(None), "no bound"),
        (number(12345.0), "12345"),
        (gap_size(0.993), "0.99"),
        (gap_size(13.808), "13.8"),
        (gap_size(float("nan")), "\N{EN DASH}"),
        (percent(0.98743), "99\N{NO-BREAK SPACE}%"),
        (percent(0.002), "0.2\N{NO-BREAK SPACE}%"),
        (percent(-0.0003), "0\N{NO-BREAK SPACE}%"),
        (digits_of(52.207, 52.503), 4),
        (
            spoken("Tip_payload closes 9% on link5; slew_t tells"),
            "Tip payload closes 9\N{NO-BREAK SPACE}% on link 5; slew_t tells",
        ),
    ],
)
def test_words(said: object, text: object) -> None:
    assert said == text


def test_what_shows_within_noise_has_the_digits_that_tell() -> None:
    gaps = {"nominal": 7.654, "before": 0.9932, "after": 0.9891}
    assert (
        _fall(gaps, True) == "7.65 → 0.993 → 0.989" and _fall({**gaps, "nominal": None}, True)[1:] == " → 0.993 → 0.989"
    )
    assert _fall({**gaps, "before": None, "after": None}, True).startswith("7.65 → ")
    assert _fall({**gaps, "before": 2.0}, True) == "7.65 → 2.00 → 0.99"
