"""The page of a diagnosis: whole for every verdict, fetches nothing, believes no name, shows numbers only."""

import re
import sys
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from boom_mj.api import Answer
from boom_mj.cli.documents import GapDiagnose
from boom_mj.diagnosis import Diagnosis, built_with, causes, document, nominal_predictor, reasons, steps
from boom_mj.diagnosis.budget import odds
from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.criteria import BOOM as CRITERIA
from boom_mj.diagnosis.decision import explains
from boom_mj.diagnosis.diagnose import held_out_closure
from boom_mj.diagnosis.fitting import Fit
from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.diagnosis.scoring import Scored
from boom_mj.diagnosis.screening import Screened
from boom_mj.diagnosis.sentences import sentence
from boom_mj.diagnosis.steps import ChannelSteps
from boom_mj.effects import make_effect
from boom_mj.errors import InputError
from boom_mj.estimation.bootstrap import Closure, gap
from boom_mj.estimation.linear import LinearPosterior
from boom_mj.estimation.noise import NoiseModel
from boom_mj.logs import read_log
from boom_mj.machine import load_machine, parse_machine
from boom_mj.recording import Recording, window
from boom_mj.report import write_diagnosis
from boom_mj.report.diagnosis.page import SECTIONS, diagnosis_page
from boom_mj.report.diagnosis.view import View
from boom_mj.report.words import digits_of, gap_size, number, percent, spoken
from boom_mj.systems.as_built import AsBuilt
from boom_mj.systems.boom import BoomSystem
from boom_mj.systems.predictor import Predictor, dataset_of

ROOT = Path(__file__).parents[2]
BOOM = load_machine(ROOT / "models" / "boom36.toml")
HOSTILE = '<script src="https://evil.example/x.js"></script>'
NAMES = ("one.mcap", f"{HOSTILE}.mcap", "\"'><img src=//evil.example onerror=alert(1)>.mcap")
CHANNELS = [ChannelSteps(name, f"{HOSTILE}/x", 8.25, 7.5, 1.125, 0.1) for name in NAMES]
STAYING = "verdict sentence effects others rivals ties next_experiment gap where remainder data complete provenance"
PAYLOAD = (make_effect("tip_payload", {"mass": 40.0}),)
HEAVIER = (make_effect("link_mass", {"link": 5, "factor": 1.1}),)
SOFT = (make_effect("hydraulic_compliance", {"joint": 3, "stiffness": 2e7}),)
VERDICTS = (
    "consistent",
    "explained",
    "ambiguous",
    "unexplained",
    "partial",
    "partial beside a suspect",
    "unexplained without a suspect",
)


def short_log() -> Recording:
    log = read_log(ROOT / "logs" / "independent_release_stretched_vertical.mcap")
    cut = {name: window(signal, 7.0, 11.0) for name, signal in log.signals.items()}
    return replace(log, name=HOSTILE, signals=cut)


@cache
def predictor(training: int) -> Predictor:
    system = BoomSystem(BOOM)
    return Predictor(system, dataset_of(system, [short_log()] * 3, training), threads=1)


def model_of(training: int) -> Linearisation:
    """Noise alone, nuisances that do nothing."""
    found, data = predictor(training), predictor(training).data
    nuisances, none = found.system.nuisances(), np.zeros(len(data.time))
    noise = NoiseModel(data, np.where(data.used, 1 / data.noise, 0.0), none)
    return Linearisation(
        found,
        effects=(),
        individual=(),
        level=found.system.facts.fidelity.coarse,
        base=np.nan_to_num(data.measured),
        mean_error=none,
        posterior=LinearPosterior.of(noise, np.zeros((len(none), len(nuisances)))),
        nuisances=nuisances,
        all_nuisances=nuisances,
        criteria=CRITERIA,
    )


def residual(model: Linearisation, size: float) -> np.ndarray:
    """White, of a given gap."""
    used = model.data.used
    return np.where(used, size * np.random.default_rng(1).standard_normal(len(used)), 0.0)


def scored(model: Linearisation, effects: tuple, size: float) -> Scored:
    candidate, left = Candidate(effects), residual(model, size)
    count = len(candidate.parameters)
    fit = Fit(candidate, candidate.start, effects, left, np.zeros((len(left), count)), 0.0)
    train, held_out = (gap(left, rows) for rows in (model.data.train, model.data.held_out))
    return Scored(fit, model, train, held_out, np.full(count, 0.02))


def diagnosis(case: str, training: int = 2) -> Diagnosis:
    model, verdict = model_of(training), case.split()[0]
    before = 1.0 if verdict == "consistent" else 8.0
    after = {"partial": 2.0, "unexplained": 6.0}.get(verdict, 1.05)
    pair = case.endswith("beside a suspect")
    found = (
        *((scored(model, (*PAYLOAD, *HEAVIER), 0.95 * after),) if pair else ()),
        scored(model, PAYLOAD, min(before, after)),
        scored(model, HEAVIER, 1.1 if verdict == "ambiguous" else 1.2 * before),
        scored(model, SOFT, 1e6),
    )
    best = None if case in ("consistent", VERDICTS[-1]) else found[0]
    ties = found[1:2] if verdict == "ambiguous" else ()
    nominal = residual(model, before)
    share = held_out_closure(model, nominal, best.fit.residual if best else nominal)
    following = "release_bow_vertical" if ties else None
    screened = tuple(Screened(Candidate(effects), 0.3) for effects in (PAYLOAD, (make_effect("end_hose", {}),)))
    return Diagnosis(
        verdict, best, found, ties, screened, nominal, share, 0.1, following, model, odds(nominal, found, model)
    )


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
    assert "raises the gap" in words["explained"]
    assert "with causes" not in words["consistent"]


def test_the_way_from_the_data_sheet_is_shown() -> None:
    for case in ("explained", "consistent"):
        words = " ".join(" ".join(Reader(page(case)).words).split())
        assert "8.25 7.50" + " 1.12" * (case == "explained") in words
        assert "link mass (link 5), factor 1.0000 ± 0.0030 1.0000" in words
    gaps = document(diagnosis("explained"), NAMES)["gap"]["holdout"]
    assert list(gaps) == ["nominal", "before", "after", "floor"] and gaps["before"] > gaps["after"]


@pytest.mark.parametrize("case", VERDICTS)
def test_the_answer_has_the_keys_that_stay_and_those_of_version_0_1(case: str) -> None:
    answer = document(diagnosis(case), NAMES, channels=CHANNELS)
    GapDiagnose.model_validate(answer)
    assert set(STAYING.split()) <= set(answer)
    assert set(["train", "holdout", "closure", "closure_interval", "fidelity_alone"]) <= set(answer["gap"])
    made, left = answer["provenance"], answer["remainder"]
    assert answer["pushes"] == answer["residual_forces"]
    assert answer["unexplained"] == (left and {**left, "learn_from": left["train_with"]})
    assert made["recordings"]["learnt_in_part"] == made["recordings"]["trained_in_part"] == []
    assert [made["hinges"][key] for key in ("contest", "predictions", "fidelity", "check")] == [3, 3, 4, 4]


def test_of_a_part_that_is_explained_the_causes_that_are_sure_are_named() -> None:
    for case, suspects in (("partial", []), ("partial beside a suspect", ["link_mass"])):
        found = diagnosis(case)
        answer = document(found, NAMES)
        assert [effect["id"] for effect in answer["effects"]] == ["tip_payload"]
        assert [effect["id"] for effect in answer["suspect"]] == suspects
        assert f"{found.best.held_out:.2f} is left" in sentence(found)
        shares = [row["share"] for row in answer["budget"]] + [answer["remainder"]["share"], answer["floor_share"]]
        assert sum(shares) == pytest.approx(1) and min(shares[-2:]) > 0


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


def test_what_only_recordings_held_out_show_is_to_train_with() -> None:
    found = diagnosis(VERDICTS[-1])
    assert not found.not_trained
    data = found.model.data
    hidden = replace(found, as_built=np.where(data.train, residual(found.model, 1.0), found.as_built))
    (index,) = hidden.not_trained
    name = data.recordings[index].name
    assert index == 2 and f"train with {name} as well" in sentence(hidden)
    best = found.scored[0]
    left = np.where(data.train, residual(found.model, 1.0), best.fit.residual)
    trained = replace(best, fit=replace(best.fit, residual=left), train=1.0)  # it explains all of training
    assert replace(found, scored=(trained,)).not_trained.keys() == {2}


def test_a_part_of_a_recording_held_out_that_trained_as_well_is_told() -> None:
    found = diagnosis("explained", 1)
    assert "trained as well" not in sentence(found)
    extended = found.model.predictor.extending(2)
    noise = replace(found.model.noise, data=extended.data)
    found = replace(found, model=replace(found.model.with_noise(noise), predictor=extended))
    answer = document(found, NAMES)
    assert answer["provenance"]["recordings"]["trained_in_part"] == [HOSTILE]
    assert f"the first 60% of {HOSTILE} trained as well" in sentence(found)
    parts = [View(found, NAMES, answer).part(k) for k in range(3)]
    assert parts == ["training", "held out", "training: the first 60\N{NO-BREAK SPACE}%; the rest held out"]


def test_recordings_of_one_hinge_are_told_to_be_simulated() -> None:
    for case, size, shown in (("unexplained", 0.99, True), ("unexplained", 1.5, False), ("partial", 0.99, True)):
        found = replace(diagnosis(case), simplest=size)
        assert ("one hinge per elastic coordinate" in sentence(found)) == shown
        assert document(found, NAMES)["gap"]["simplest_model"] == size
    assert "one hinge" not in sentence(diagnosis("unexplained"))


def test_an_answer_draws_into_axes_and_makes_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    answer = Answer(BOOM, diagnosis("explained"), NAMES)
    answer.__dict__["document"] = document(answer.found, NAMES, channels=CHANNELS)  # without simulating it
    axes = Figure().subplots()
    answer.draw_gaps(axes)
    assert len(axes.get_yticks()) == len(View(answer.found, NAMES, answer.document).groups)
    with pytest.raises(InputError, match=r"no table 'effect'; it has effects, .*channels"):
        answer.to_frame("effect")
    assert list(answer.to_frame("channels").with_causes) == [1.125] * 3
    assert answer.to_frame().loc[0, "parameters.mass.unit"] == "kg"
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(InputError, match="pandas"):
        answer.to_frame()


def test_what_surely_leaves_some_of_a_small_gap_is_no_explanation() -> None:
    near_noise, loud = (scored(model_of(2), PAYLOAD, size) for size in (1.0, 2.0))
    whole, most = Closure(1.0, 0.9, 1.1), Closure(0.73, 0.55, 0.90)
    assert explains((1.11, 1.11), near_noise, whole)
    assert not explains((1.11, 1.11), near_noise, most) and not explains((8.0, 8.0), loud, whole)


def test_every_line_of_a_corrected_file_says_why_it_is_there() -> None:
    for case, kind in (("explained", "cause: probability"), ("unexplained", "suspect, not sure: probability")):
        found = diagnosis(case)
        built, text = built_with(found), (ROOT / "models" / "boom36.toml").read_text()
        why = reasons(found)
        written = BoomSystem(BOOM, text).corrected(causes(found), built, why)
        lines = [line for line in written.removeprefix(text.rstrip()).splitlines() if line and not line.startswith("#")]
        assert all(re.search(r"  # \w+", line) for line in lines)
        assert sum(line.startswith(f"[[effect]]  # {kind}") for line in lines) == 1
        (mass,) = (line for line in lines if line.startswith("mass = "))
        assert re.fullmatch(r"mass = 40\.0  # how much: estimate; 95 % [\d.]+ \.\. [\d.]+ kg; without it 0", mass)
        assert all(why[effect, name].startswith("estimate; prior ") for effect in built for name in effect.values)
        assert len(parse_machine(written).effect) == len(built) + 1
