"""What a sensor says that nothing explains, in terms of what explains all others: a gain and an offset."""

from collections import defaultdict

import numpy as np

from boom_mj.diagnosis.diagnose import Diagnosis
from boom_mj.diagnosis.outlying import Outlier
from boom_mj.diagnosis.predictions import explanation, nominal_predictor, simulated_recording
from boom_mj.errors import BoomError
from boom_mj.replay.quality import DataFinding

Array = np.ndarray


def outlier_findings(found: Diagnosis) -> list[DataFinding]:
    """Of everything that was left out, recording by recording."""
    findings = []
    for part in found.outliers:
        reads = "".join(f"; {text}" for text in _readings(found, part)) if part.whole else ""
        findings += part.findings(reads)
    return findings


def _readings(found: Diagnosis, part: Outlier) -> list[str]:
    """Of its channels that a gain and an offset, the same in all recordings, bring closer by `main_share`."""
    predictor, effects, system = nominal_predictor(found), explanation(found), found.model.system
    pairs: dict[tuple[str, str], list[Array]] = defaultdict(list)  # expected and read, (2, m), by name and unit
    for index in part.spans:
        measured = part.data.recordings[index]
        try:
            said = simulated_recording(predictor, effects, index)
        except BoomError:
            continue
        for channel in part.data.of(index):
            if system.channel(channel.signal, channel.column).device == part.device:
                signal = measured[channel.signal]
                both = [log[channel.signal].values[:, channel.column] for log in (said, measured)]
                pairs[f"{channel.signal}/{signal.channels[channel.column]}", signal.unit].append(np.array(both))
    lines = []
    for (name, unit), parts in pairs.items():
        whole = np.concatenate(parts, axis=1)
        expected, read = whole[:, np.isfinite(whole).all(axis=0)]
        (gain, offset), *_ = np.linalg.lstsq(np.stack([expected, np.ones_like(expected)], axis=1), read)
        left = np.var(read - gain * expected) / np.mean((read - expected) ** 2)
        if left < 1 - found.criteria.main_share:
            size = f"{gain:.3g} times what that says {offset:+.2g} {unit}".removesuffix(" 1")
            lines.append(f"{name} reads {size}, which leaves {left:.1%} of its mean square")
    return lines
