"""What a law is drawn through: what is missing over its variables and over time, and the front of laws."""

from dataclasses import dataclass

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure

from boom_mj.discovery import Discovery
from boom_mj.discovery.search import FoundLaw
from boom_mj.discovery.writing import law_type
from boom_mj.report.colours import CORRECTED, MEASURED, NOMINAL
from boom_mj.report.drawing import draw, gap_axis

Array = np.ndarray
WIDTH, HEIGHT, ROW = 1080, 260, 120  # px


@dataclass(frozen=True, eq=False)
class Missing:
    """What the nominal model lacks in one channel of one recording, and what the law adds to it.

    Attributes:
        time: (n,), s.
        lacking, law: in the unit of the channel, (n,).
    """

    recording: int
    held_out: bool
    label: str
    unit: str
    time: Array
    lacking: Array
    law: Array


def missing(found: Discovery, law: FoundLaw) -> list[Missing]:
    """By recording, in the channel that the law alters most."""
    model, data = law.scored.model, found.model.data
    without, with_law = model.predict([(), law.scored.fit.effects])
    estimate = model.posterior.estimate(model.residual(with_law))
    lacking = data.measured - without - model.mean_error - model.columns @ estimate
    change = with_law - without
    felt = np.bincount(data.channel_of, np.nan_to_num(change * model.noise.weight) ** 2, len(data.channels))
    groups = [(c.signal, c.column) for c in data.channels]
    signal, column = groups[int(np.argmax(felt))]
    rows = []
    for number, channel in enumerate(data.channels):
        if groups[number] == (signal, column):
            part = data.stretch(number)
            unit = data.recordings[channel.recording][signal].unit
            label = model.system.channel(signal, column).label
            held = bool(data.held_out[part].any())
            rows.append(Missing(channel.recording, held, label, unit, channel.time, lacking[part], change[part]))
    return rows


def over_variables(found: Discovery, law: FoundLaw, rows: list[Missing]) -> Markup | None:
    """What is missing over every variable of a law, all recordings, with the law."""
    if law.place.sense is None:
        return None
    values: dict[str, list[Array]] = {}
    for row in rows:
        sensed = law.place.sense(row.recording)
        for name in law_type(law).variables:
            values.setdefault(name, []).append(np.interp(row.time, sensed["time"], sensed[name]))
    values = {name: parts for name, parts in values.items() if np.ptp(np.concatenate(parts)) > 0}
    lacking, does = (np.concatenate([getattr(row, name) for row in rows]) for name in ("lacking", "law"))
    here = {"position": "{x}", "speed": "{x}/s", "load": "{F}", "reading": "{F}"} if law.place.words else {}
    given = law_type(law).variables
    units = {**given, **{name: law.place.text(unit) for name, unit in here.items() if not given.get(name)}}

    def paint(figure: Figure) -> None:
        for axes, (name, parts) in zip(np.ravel(figure.subplots(1, len(values), sharey=True)), values.items()):
            axes.plot(np.concatenate(parts), does, ".", ms=5, color=CORRECTED)
            axes.plot(np.concatenate(parts), lacking, ".", ms=1.5, color=MEASURED)
            axes.set_xlabel(f"{name}, {units[name]}")
            axes.locator_params(axis="x", nbins=4)
            axes.ticklabel_format(axis="x", scilimits=(-3, 4))
        figure.axes[0].set_ylabel(f"missing, {rows[0].unit}")

    return draw("variables", f"{rows[0].label}: what is missing over every variable", WIDTH, HEIGHT, paint)


def over_time(found: Discovery, rows: list[Missing]) -> Markup:
    """What is missing and what the law adds, recording by recording."""

    def paint(figure: Figure) -> None:
        for axes, row in zip(np.ravel(figure.subplots(len(rows), 1, squeeze=False)), rows):
            axes.plot(row.time, row.lacking, color=MEASURED, lw=0.8)
            axes.plot(row.time, row.law, color=CORRECTED, lw=1.2)
            name = found.model.data.recordings[row.recording].name
            axes.set_title(f"{name}{' (held out)' if row.held_out else ''}", loc="left")
            axes.set_ylabel(row.unit)
        figure.axes[-1].set_xlabel("time, s")

    return draw("time", f"{rows[0].label}: what is missing, and the law", WIDTH, ROW * len(rows) + 40, paint)


def force(found: Discovery) -> Markup:
    """The best force in time, by held-out recording and direction."""
    best = found.forces[0]

    def paint(figure: Figure) -> None:
        rows = figure.subplots(len(best.time), 1, squeeze=False)[:, 0]
        for axes, (index, time) in zip(rows, best.time.items()):
            for way, (mean, deviation), colour in zip(best.place.pushes, best.force[index], (CORRECTED, NOMINAL)):
                axes.fill_between(time, mean - 2 * deviation, mean + 2 * deviation, color=colour, alpha=0.25, lw=0)
                axes.plot(time, mean, color=colour, lw=1.2, label=way)
            axes.set_title(found.model.data.recordings[index].name, loc="left")
            axes.set_ylabel(best.place.unit)
        if len(best.place.pushes) > 1:
            rows[0].legend(frameon=False, ncols=2, loc="upper right")
        rows[-1].set_xlabel("time, s")

    words = f"The force in time on {best.place.acts_on}"
    return draw("force", words, WIDTH, ROW * len(best.time) + 40, paint)


def front(found: Discovery) -> Markup:
    """The held-out gap that laws of one, two, ... terms leave."""
    laws = list(found.front)
    before = float(np.sqrt(np.mean(found.as_built[found.model.data.held_out] ** 2)))
    left = np.array([before, *(law.held_out for law in laws)])

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        gap_axis(axes, left)
        rows = np.arange(len(left))
        axes.plot(left, rows, "o-", color=CORRECTED, lw=0.8)
        axes.plot(left[:1], rows[:1], "o", color=NOMINAL)
        names = ["no law", *("\N{PLUS SIGN}".join(term.name for term in law.terms) for law in laws)]
        axes.set_yticks(rows, names)
        axes.invert_yaxis()
        axes.set_xlabel("held-out gap")

    return draw("front", "Held-out gap by number of terms", WIDTH // 2, 60 + 40 * len(left), paint)
