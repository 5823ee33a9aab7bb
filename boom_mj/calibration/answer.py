"""The answer as one document, and as a machine file."""

import re
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np

from boom_mj.calibration.calibrate import Calibration
from boom_mj.calibration.evidence import COARSE, FINE, MIDDLE, model_error, predict
from boom_mj.calibration.parameters import JOINTS, Variant
from boom_mj.errors import MachineFileError
from boom_mj.estimation.intervals import Z95
from boom_mj.machine import parse_machine

DIGITS = 6  # of a value in the file


def document(found: Calibration, names: Sequence[str]) -> dict[str, Any]:
    """The answer in plain data: parameters with intervals, zero offsets, what is not identifiable, gaps, features."""
    refined, data = found.refined, found.predictor.data
    finer, _ = model_error(found.predictor, found.nominal)
    (nominal,) = predict(found.predictor, [found.nominal], MIDDLE)
    before = (data.measured - nominal - finer) * refined.weight
    groups = np.repeat([channel.group for channel in data.channels], np.diff(data.offsets))
    gaps = {
        str(group): {"before": _rms(before, groups == group), "after": _rms(refined.residual, groups == group)}
        for group in dict.fromkeys(groups[data.used])
    }
    used = data.used
    return {
        "machine": found.machine.name,
        "sentence": sentence(found),
        "parameters": parameters(found),
        "zero_offsets_deg": [_offset(found, k) for k in range(JOINTS)],
        "not_told": list(found.fixed),
        "at_bound": list(refined.at_bound),
        "identifiability": {
            "rank": found.identified.rank,
            "of": found.identified.size,
            "condition": _finite(found.identified.condition),
            "correlated": [list(pair) for pair in found.identified.correlated],
            "null_directions": [dict(combination) for combination in found.identified.null],
        },
        "gap": {"before": _rms(before, used), "after": _rms(refined.residual, used), "floor": 1.0, "groups": gaps},
        "provenance": {
            "recordings": list(names),
            "hinges": {
                "sensitivities": COARSE.hinges,
                "predictions": MIDDLE.hinges,
                "correction": FINE.hinges,
            },
            "simulated_s": found.predictor.simulated_s,
            "wall_s": found.duration,
            "status": refined.status,
            "boom_mj": version("boom_mj"),
            "mujoco": version("mujoco"),
        },
    }


def parameters(found: Calibration) -> list[dict[str, Any]]:
    """Every parameter that was asked for: value, 95 % interval, factor on the file's value."""
    owner = {p: group for group in found.refined.free.tied for p in group.parameters}
    listed = []
    for group, x, deviation in zip(found.whole.tied, found.scaled, found.deviation):
        (parameter,) = group.parameters
        value, held = parameter.value(found.machine), bool(np.isnan(deviation))
        low, high = (None if held else value * float(np.exp(x + side * Z95 * deviation)) for side in (-1, 1))
        listed.append(
            {
                "name": parameter.name,
                "unit": parameter.unit,
                "file": value,
                "value": value * float(np.exp(x)),
                "low": low,
                "high": high,
                "factor": float(np.exp(x)),
                "held": held,
                "with": [p.name for p in owner[parameter].parameters if p != parameter] if parameter in owner else [],
            }
        )
    return listed


def sentence(found: Calibration) -> str:
    """The result in words."""
    free, asked = len(found.refined.free.tied), len(found.whole.tied)
    widest = int(np.argmax(found.refined.deviation[:free]))
    every = "The parameter is" if asked == 1 else f"All {asked} parameters are"
    text = f"{free} of {asked} parameters calibrated" if free < asked else f"{every} calibrated"
    text += (
        f"; the least certain is {found.refined.free.names[widest]}, "
        f"to {Z95 * found.refined.deviation[widest]:.1%} (95 %)"
    )
    if found.fixed:
        text += f". Not told: {'; '.join(found.fixed)}"
    if found.refined.at_bound:
        text += f". At a bound: {', '.join(found.refined.at_bound)}"
    return f"{text}."


def calibrated_text(text: str, found: Calibration) -> str:
    """A machine file's text with the calibrated values in it, and the zero offsets as an effect at its end.

    Raises:
        MachineFileError: a value does not stand on a line of its own and cannot be replaced.
    """
    source, values = parse_machine(text), {}
    for group, x in zip(found.whole.tied, found.scaled):
        (parameter,) = group.parameters
        section = ("damping", 0) if parameter.link is None else ("link", parameter.link - 2)
        moved = {field: value * float(np.exp(x)) for field, value in parameter.values(source).items()}
        values.update({(*section, field): value for field, value in moved.items() if value and x})
    return replaced_text(text, values).rstrip("\n") + "\n\n" + _effect(found.variant)


def replaced_text(text: str, values: Mapping[tuple[str, int, str], float]) -> str:
    """A machine file's text with new values.

    Args:
        values: by section ("link" or "damping"), number within it and field.

    Raises:
        MachineFileError: a value does not stand on a line `field = value` of its own.
    """
    shown = {place: f"{value:.{DIGITS}g}" for place, value in values.items()}
    section, links, lines = "", -1, []
    for line in text.splitlines():
        if header := re.match(r"\s*\[+\s*([\w.]+)\s*\]+", line):
            section = header[1]
            links += section == "link"
        field = re.match(r"(\s*(\w+)\s*=\s*)([-+.\w]+)(\s*)(.*)", line)
        if field and (new := shown.get((section, links if section == "link" else 0, field[2]))):
            gap = max(1, len(field[4]) + len(field[3]) - len(new)) if field[5] else 0  # comments stay where they are
            line = f"{field[1]}{new}{' ' * gap}{field[5]}"
        lines.append(line)
    made = "\n".join(lines) + "\n"
    machine = parse_machine(made, "calibrated machine file")
    for (where, number, name), new in shown.items():
        if getattr(machine.damping if where == "damping" else machine.links[number], name) != float(new):
            place = where if where == "damping" else f"link{number + 2}"
            raise MachineFileError(
                f"{place}.{name} does not stand on a line `{name} = value` of its own: rewrite it so"
            )
    return made


def _effect(variant: Variant) -> str:
    entry = '\n[[effect]]\nid = "joint_zero_offset"\njoint = {}\noffset = {:.6g}\n'
    entries = "".join(entry.format(k + 1, value) for k, value in enumerate(variant.offsets))
    return f"# zero offsets of the joint sensors, rad, estimated along{entries}"


def _offset(found: Calibration, joint: int) -> dict[str, float]:
    value, deviation = (np.degrees(v[joint - JOINTS]) for v in (found.refined.scaled, found.refined.deviation))
    return {
        "value": float(value),
        "low": float(value - Z95 * deviation),
        "high": float(value + Z95 * deviation),
    }


def _rms(values: np.ndarray, rows: np.ndarray) -> float | None:
    return _finite(float(np.sqrt(np.nanmean(values[rows] ** 2)))) if np.isfinite(values[rows]).any() else None


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
