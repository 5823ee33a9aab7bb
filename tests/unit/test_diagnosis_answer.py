"""The answer of a diagnosis: its keys, its sentence, what it says of parts of recordings, its tables and files."""

import re
import sys
from dataclasses import replace

import numpy as np
import pytest
from diagnoses import (
    BOOM,
    CHANNELS,
    HOSTILE,
    NAMES,
    PAYLOAD,
    ROOT,
    VERDICTS,
    diagnosis,
    model_of,
    residual,
    scored,
)
from matplotlib.figure import Figure

from boom_mj.api import Answer
from boom_mj.cli.documents import GapDiagnose
from boom_mj.diagnosis import built_with, causes, document, reasons
from boom_mj.diagnosis.decision import explains
from boom_mj.diagnosis.sentences import sentence
from boom_mj.errors import InputError
from boom_mj.estimation.bootstrap import Closure
from boom_mj.machine import parse_machine
from boom_mj.report.diagnosis.view import View
from boom_mj.systems.boom import BoomSystem

STAYING = "verdict sentence effects others rivals ties next_experiment gap where remainder data complete provenance"


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


@pytest.mark.parametrize("case", VERDICTS)
def test_an_answer_is_as_probable_as_what_it_says_and_what_its_recordings_show(case: str) -> None:
    found = diagnosis(case)
    answer = document(replace(found, odds=replace(found.odds, hidden=0.25, unwell=0.4)), NAMES)
    causes = [cause["probability"] for cause in answer["effects"]]
    others, verdict = answer["others"], case.split()[0]
    said = {
        "consistent": 0.6 * others["none"],
        "partial": min(causes, default=0),
        "unexplained": others["outside_library"],
    }.get(verdict, 0.75 * min(causes, default=0))
    assert answer["probability"] == pytest.approx(said) and 0 < said < 1
