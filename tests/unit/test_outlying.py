"""What no explanation fits where one fits all the rest is left out, said, and not explained."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from algebra import (
    HUM,
    RAMP,
    SQUARE,
    TIME,
    Common,
    Likeness,
    Ramp,
    Square,
    causes,
    found,
    model,
    off,
    sweep,
    swing,
    term,
)
from pytest import approx, mark

from boom_mj.cli.gap import _summary
from boom_mj.diagnosis import document
from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.clock import Clock
from boom_mj.diagnosis.outlying import outlying
from boom_mj.diagnosis.stages import fit_all
from boom_mj.effects import Effect
from boom_mj.recording import Recording

Spoil = Callable[[Recording], Recording]
KNOCK = (TIME > 71.0) & (TIME < 74.5)
NAMES = ("first", "second", "third")


def knocked(log: Recording, sensors: tuple[str, ...] = NAMES, name: str = "log 1", size: float = 1.0) -> Recording:
    """With a few seconds of one log in which sensors are shaken."""
    shaken = {s: log[s].values + np.where(KNOCK, size * np.sin(9 * TIME), 0.0)[:, None] for s in sensors if s in log}
    return log.with_signals({s: replace(log[s], values=v) for s, v in shaken.items()}) if log.name == name else log


def loose(log: Recording) -> Recording:
    """With a third sensor that wanders."""
    signal = log["third"]
    return log.with_signals({"third": replace(signal, values=signal.values + 0.3 * np.sin(0.05 * TIME**1.3)[:, None])})


@mark.usefixtures("library")
@mark.parametrize("oscillatory", [True, False])
@mark.parametrize("true", [(SQUARE,), (SQUARE, HUM)], ids=["one", "two"])
@mark.parametrize("where", ["log 0", "log 1"], ids=["training", "held out"])
def test_a_knock_does_not_outvote_the_rest(true: tuple[Effect, ...], where: str, oscillatory: bool) -> None:
    answer = found(*true, spoilt=lambda log: knocked(log, name=where), oscillatory=oscillatory)
    assert answer.verdict == "partial" and all(answer.sure)
    assert causes(answer) == {effect.cause for effect in true}
    assert all(abs(off(answer, one)) < 3 for one in true)
    (part,) = answer.outliers
    assert part.name == f"all sensors of {where} from 71 to 75 s" and part.gap > 10
    assert answer.with_outliers is not None and answer.with_outliers.verdict in ("partial", "unexplained")


@mark.usefixtures("library")
def test_a_sensor_is_outvoted_by_the_others() -> None:
    answer = found(SQUARE, spoilt=loose, third=True)
    assert answer.verdict == "partial" and causes(answer) == {SQUARE.cause}
    (part,) = answer.outliers
    assert part.name == "third" and part.whole and part.gap > 5
    said = document(answer, ["a", "b"])
    assert [(row["log"], row["channel"], row["kind"], row["used"]) for row in said["data"]] == [
        (log, "third", "outlying", False) for log in ("log 0", "log 1")
    ]
    assert "Nothing in the library explains third, at least" in said["sentence"]
    assert said["with_outliers"]["verdict"] != "explained"
    assert sum(row["share"] for row in said["budget"]) + said["remainder"]["share"] + said["floor_share"] == approx(1)


@mark.usefixtures("library")
def test_without_a_cause_an_outlier_is_named_and_nothing_else() -> None:
    answer = found(spoilt=loose, third=True)
    assert (answer.verdict, answer.best, [part.name for part in answer.outliers]) == ("unexplained", None, ["third"])
    assert answer.odds.outside_library > 0.9 and answer.odds.none == 0.0
    assert document(answer, ["a", "b"])["probability"] > 0.9


@mark.usefixtures("library")
def test_of_two_sensors_neither_is_outvoted() -> None:
    def wanders(log: Recording) -> Recording:
        values = log["second"].values + 0.3 * np.sin(0.05 * TIME**1.3)[:, None]
        return log.with_signals({"second": replace(log["second"], values=values)})

    answer = found(spoilt=wanders)
    assert answer.verdict == "unexplained" and not answer.outliers


@mark.usefixtures("library")
def test_a_cause_that_is_withheld_is_no_outlier() -> None:
    """What shows all the time, or in several sensors, is the machine."""
    answer = found(RAMP, SQUARE, without=("ramp", "square"), third=True)
    assert answer.verdict in ("partial", "unexplained") and not answer.outliers


@mark.usefixtures("library")
@mark.parametrize(("rest", "out"), [(2.0, True), (5.0, False)])
def test_a_sensor_is_left_out_where_the_rest_is_nearly_explained(rest: float, out: bool) -> None:
    """A gap of sqrt((20^2 + 2 rest^2) / 3) = 11.7 or 12.2, a quarter of which above noise is 2.7 or 2.8."""
    about = model((), third=True)
    third = about.data.spread([channel.signal == "third" for channel in about.data.channels]).astype(bool)
    part = outlying(about, np.where(third, 20.0, rest), [])
    assert (part.name if part else None) == ("third" if out else None)


@mark.usefixtures("library")
@mark.parametrize(("kind", "left", "out"), [("mjcf", 5.0, False), ("mjcf", 6.5, True), ("boom", 5.0, True)])
def test_where_the_floor_is_never_reached_what_is_mostly_explained_is_no_outlier(
    kind: str, left: float, out: bool
) -> None:
    """Most of a gap of 20 is gone at 1 + 19 / 4 = 5.75."""
    about = model((), third=True, kind=kind)
    third = about.data.spread([channel.signal == "third" for channel in about.data.channels]).astype(bool)
    (tried,) = fit_all(about, [Candidate((SQUARE,))], Clock())
    tried = replace(tried, fit=replace(tried.fit, residual=np.where(third, left, 1.0)))
    part = outlying(about, np.where(third, 20.0, 2.0), [tried])
    assert (part.name if part else None) == ("third" if out else None)


@mark.usefixtures("library")
@mark.parametrize(("shaken", "name"), [(("third",), "third"), (NAMES, "all sensors")], ids=["one", "all"])
def test_no_more_is_left_out_than_is_off(shaken: tuple[str, ...], name: str) -> None:
    answer = found(SQUARE, spoilt=lambda log: knocked(log, shaken), third=True)
    (part,) = answer.outliers
    assert part.name == f"{name} of log 1 from 71 to 75 s" and not part.whole


@mark.usefixtures("library")
def test_a_gain_and_an_offset_of_a_sensor_are_said() -> None:
    def weak(log: Recording) -> Recording:
        values = 0.7 * log["third"].values + 0.02
        return log.with_signals({"third": replace(log["third"], values=values)})

    said = document(found(SQUARE, spoilt=weak, third=True), ["a", "b"])
    first, second, gain = said["data"]
    assert first["evidence"] == second["evidence"] and first["kind"] == "outlying"
    assert (gain["kind"], gain["channel"]) == ("gain", "third/third")
    assert gain["evidence"].startswith("reads, in all logs, 0.7 times what explains the rest +0.02, but for 0.")
    summary = _summary(said).splitlines()
    assert sum("third/third reads, in all logs, 0.7 times" in line for line in summary) == 1
    assert not any("gap discover" in line for line in summary)


@mark.usefixtures("library")
def test_what_is_no_gain_is_not_said() -> None:
    rows = document(found(SQUARE, spoilt=loose, third=True), ["a", "b"])["data"]
    assert [row["kind"] for row in rows] == ["outlying", "outlying"]


def test_a_sensor_that_pulls_at_the_sizes_is_outvoted(library: Callable[..., None]) -> None:
    """Three times what the others say is two thirds too much for all of them, and then all are off."""
    library(Common, Ramp)
    true = term(Common, 1, 0.5)

    def thrice(log: Recording) -> Recording:
        more = 2 * true.adds(TIME, log["angle"].values[:, 0])
        return log.with_signals({"third": replace(log["third"], values=log["third"].values + more[:, None])})

    answer = found(true, spoilt=thrice, third=True)
    assert answer.verdict == "partial" and [part.name for part in answer.outliers] == ["third"]
    assert causes(answer) == {true.cause} and abs(off(answer, true)) < 3


def test_what_ties_without_an_outlier_is_no_cause_for_sure(library: Callable[..., None]) -> None:
    library(Square, Likeness, Ramp)
    answer = found(SQUARE, spoilt=loose, third=True)
    assert answer.verdict == "unexplained" and [part.name for part in answer.outliers] == ["third"]
    said = document(answer, ["a", "b"])
    assert not said["effects"] and len(said["ties"][0]) == 2
    assert " or ".join(one.label for one in (answer.best, *answer.ties)) + " would explain; no" in said["sentence"]


@mark.usefixtures("library")
def test_what_is_not_likely_is_not_named_beside_an_outlier() -> None:
    answer = found(SQUARE, HUM, spoilt=loose, third=True)
    with_square = [SQUARE.cause in one.fit.candidate.places for one in answer.scored]
    with_hum = [HUM.cause in one.fit.candidate.places for one in answer.scored]
    without_hum = [float(a and not b) for a, b in zip(with_square, with_hum)]
    odds = replace(answer.odds, explanations=tuple(0.9 * p / sum(without_hum) for p in without_hum))
    said = document(replace(answer, odds=odds), ["a", "b"])
    assert [cause["id"] for cause in said["effects"]] == ["square"]
    assert [cause["id"] for cause in said["suspect"]] == ["hum"]
    assert said["sentence"].startswith("Square") and ", with what acts beside, closes" in said["sentence"]


@mark.usefixtures("library")
@mark.parametrize(("count", "verdict"), [(2, "partial"), (3, "unexplained")])
def test_few_parts_are_left_out(count: int, verdict: str) -> None:
    sizes = {f"log {k}": 0.4**k for k in range(1, 1 + count)}

    def knocked_often(log: Recording) -> Recording:
        return knocked(log, name=log.name, size=sizes.get(log.name, 0.0))

    answer = found(SQUARE, spoilt=knocked_often, motions=(swing, sweep, swing, sweep))
    assert (answer.verdict, len(answer.outliers)) == (verdict, count if verdict == "partial" else 0)
