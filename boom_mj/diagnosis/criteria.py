"""Every number that decides, once, with its unit and its reason; `gap criteria` shows them.

A gap is the root mean square of a whitened residual: 1 is the floor of noise and model error.
"""

from dataclasses import Field, dataclass, field, fields
from typing import Any


def number(value: Any, unit: str, reason: str) -> Any:
    """A field with its unit and why it is what it is."""
    return field(default=value, metadata={"unit": unit, "reason": reason})


@dataclass(frozen=True)
class Criteria:
    """What decides about a verdict."""

    floor: float = number(1.0, "gap", "noise alone: below it, a named effect's inaccuracy explains nothing away")
    explained_gap: float = number(
        1.01,
        "gap",
        "what an explanation may leave besides `error_share`: 80 healthy booms show 0.987 +- 0.004, at most 1.000, and "
        "of 530 right answers of opened seeds all but 5 leave less, half of the 50 wrong ones more; of MJCF machines "
        "the truth itself mostly leaves 1.0 to 1.9 on benches, whatever the gap",
    )
    healthy_gap: float = number(1.05, "gap", "up to which nothing needs explaining, unless a cause is sure")
    near_noise_gap: float = number(1.15, "gap", "up to which a cause must be sure, and above which a recording trains")
    sure_z: float = number(4.0, "standard errors", "by which a cause of a gap near noise must beat chance, of 50 tried")
    tie_z: float = number(2.0, "standard errors", "within which rivals tie: a 95 % interval")
    least_gain: float = number(
        0.05**2, "mean square", "fall of a mean square that counts, of what shows by a twentieth of the noise"
    )
    law_gain: float = number(0.10, "mean square", "by which another law must do better")
    parameter_cost: float = number(1e-3, "share of gap", "what a parameter must be worth, so that equals stay simple")
    tie_closure: float = number(0.03, "closure", "within which rivals tie")
    whole_closure: float = number(0.95, "closure", "that the interval of an explanation must reach")
    named_closure: float = number(0.5, "closure", "lower end from which causes are named although they leave a gap")
    shown_share: float = number(0.002, "share", "of the gap, from which a part of it is listed by itself")
    seen_share: float = number(0.2, "share", "of a residual that a look must take to be told")
    error_share: float = number(
        0.0,
        "share of gap",
        "that a model's own error may leave besides noise: right answers of opened seeds leave the same of gaps of 1 "
        "and of 50; of MJCF machines truths mostly leave up to 0.001 of gaps of 600 to 1300",
    )
    rough_share: float = number(
        0.005, "share of gap", "that a size as good as the best may leave more, where jolts make the cost rough"
    )
    required_gain: float = number(0.5, "share of gap", "of what is left above noise, that another effect must close")
    gain_z: float = number(
        0.0, "standard errors", "by which one more cause must lower what is held out; 0: by its share"
    )
    unlikely_gap: float = number(
        0.5, "share of gap", "that an unlikely size may leave, of what likely ones leave: doubt"
    )
    outside: float = number(0.2, "share", "of causes, before any data, that no library holds: a decree")
    further: float = number(
        0.16, "causes", "besides those found: 4 of 115 answers of opened seeds lack one; 0.22 of effects do not show"
    )
    unwell: float = number(
        0.8, "causes", "of what seems healthy: 9 of 49 of opened seeds have one, where 0.26 of effects do not show"
    )
    fooled: float = number(0.12, "share", "of causes outside the library that it explained, 14 of 118 of opened seeds")
    missed: float = number(0.05, "share", "of causes in the library left unexplained, 12 of 245 of opened seeds")
    shadow: float = number(
        0.65,
        "share",
        "of causes that leave a gap and surely close half, that stand for others: 15 of 20 of opened seeds, weighed by "
        "`outside`; of MJCF machines, whose floor is never reached, by judgement",
    )
    main_share: float = number(
        0.5,
        "share of gap",
        "that a law must surely close: what closes less is not its cause; or a like elsewhere, of what a cause closes",
    )
    named_probability: float = number(0.5, "probability", "from which a cause is named although it leaves a gap")
    unnamed: float = number(
        0.0,
        "sizes worth finding",
        "of every effect that is not named, by which sizes are unsure: with 0.1 196 of 206 sizes of opened benches are "
        "inside, half of the small effects left out or none; 0: what is named is all there is, as on booms",
    )
    leakage: float = number(0.01, "share", "of the mean square closed, that an effect's own inaccuracy may leave")

    def enough(self, before: Any) -> Any:
        """The gap that an explanation may leave of one: of noise and of the model's own error."""
        return self.explained_gap + self.error_share * (before - 1)


@dataclass(frozen=True)
class SearchBudget:
    """What is tried before a verdict: more costs time, less may miss a cause."""

    finalists: int = number(6, "candidates", "that are fitted alone")
    always: int = number(
        3, "candidates", "that are fitted whatever they promise: what else was tried is part of an answer"
    )
    kinds_beyond: int = number(3, "candidates", "fitted besides, each the best of a kind that is not among them")
    kind_share: float = number(0.3, "share", "of the best promise, that such a one must have")
    beside: int = number(
        40,
        "candidates",
        "screened about a leader: the machine as built puts the best three no later than place 22",
    )
    every: int = number(
        4, "candidates", "of which one is simulated to see whether a glance tells of them beside a leader"
    )
    surprise: float = number(0.1, "share", "of the largest promise, that one may promise more than at a glance")
    partners: int = number(3, "candidates", "screened beside a leader, that are fitted together with it")
    singles_beside: int = number(2, "candidates", "fitted alone before, that are tried together with a leader")
    leaders: int = number(2, "candidates", "of a stage that are refined")
    trunks: int = number(3, "candidates", "of a stage beside which others are sought, where fits are short")
    leap: float = number(
        0.5, "share of gap", "of what is left above noise, that one more cause closes without a rival to its leader"
    )
    rounds: int = number(3, "refinements", "of a leader, each about the machine that the last has found")
    lines: int = number(3, "spectral lines", "offered to periodic effects")
    line_chance: float = number(0.05, "probability", "of noise showing such a line anywhere in the spectrum")
    line_low_hz: float = number(0.1, "Hz", "lowest spectral line: a pump's slowest stroke")
    line_high_hz: float = number(3.0, "Hz", "highest spectral line: below half the rate of block means")
    weight_prior: float = number(10.0, "sizes worth finding", "prior deviation of a screened size")
    alike_share: float = number(0.9, "share", "of the largest promise, from which other sizes are starts, too")
    apart: float = number(0.5, "sizes worth finding", "by which such starts must differ")
    latent_left: float = number(0.25, "share of gap", "that a latent input must leave less than, to count in screening")
    revealed: int = number(6, "causes", "of an explanation that suffices, beside which one more shows")
    still: float = number(0.1, "sizes worth finding", "within which nuisances and model error stay what they are")
    helped: float = number(
        0.98, "share of gap", "that a refinement, if much of the gap is left, or a like of a cause must leave to go on"
    )
    far: float = number(0.25, "share of gap", "above noise, that counts as much of it")
    worse: float = number(1.2, "times the gap", "at which a refinement is given up")
    hope: float = number(0.9, "share of gap", "of what there was to explain: what leaves more is not refined")
    close: float = number(1.5, "times the best gap", "up to which a rival is refined, or fitted if it promises it")
    law_terms: int = number(4, "terms", "of a law at most: more are no short formula")
    law_beam: int = number(6, "sums of terms", "that are extended by one more")
    law_places: int = number(4, "places", "at which laws are fitted")
    law_forms: int = number(3, "laws", "of as many terms at a place, that are fitted")
    rival: float = number(0.1, "share of gap", "of what there was, up to which it is even where the best suffices")


BOOM = Criteria()
MJCF = Criteria(
    explained_gap=1.5,
    least_gain=0.10,
    error_share=0.001,
    rough_share=0.001,
    required_gain=0.0,
    gain_z=1.0,
    leakage=0.0,
    shadow=0.2,
    unnamed=0.1,
)
OF_KIND = {"boom": BOOM, "mjcf": MJCF}


def described() -> list[tuple[str, Field[Any], dict[str, Any]]]:
    """Name of the family, field, and value by kind of machine, of every criterion."""
    rows: list[tuple[str, Field[Any], dict[str, Any]]] = []
    for one in fields(Criteria):
        rows.append(("criteria", one, {kind: getattr(found, one.name) for kind, found in OF_KIND.items()}))
    rows += [("search", one, dict.fromkeys(OF_KIND, one.default)) for one in fields(SearchBudget)]
    return rows
