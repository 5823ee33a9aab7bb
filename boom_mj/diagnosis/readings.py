"""What a sensor says that nothing explains, in terms of what explains all others: a gain and an offset."""

from collections.abc import Iterator

import numpy as np

from boom_mj.diagnosis.conclusion import Diagnosis
from boom_mj.diagnosis.outlying import Outlier
from boom_mj.diagnosis.predictions import explanation, nominal_predictor, simulated_recording
from boom_mj.effects import behind
from boom_mj.errors import BoomError
from boom_mj.replay.quality import Action, DataFinding

Array = np.ndarray


def outlier_findings(found: Diagnosis) -> list[DataFinding]:
    """Of everything that was left out: recording by recording, then of channels that a gain and an offset mend."""
    return [
        finding for part in found.outliers for finding in (*part.findings, *(_gains(found, part) if part.whole else ()))
    ]


def _gains(found: Diagnosis, part: Outlier) -> Iterator[DataFinding]:
    """Of channels that a gain and an offset, the same in all recordings, bring closer by `main_share`."""
    predictor, effects, system = nominal_predictor(found), explanation(found), found.model.system
    pairs: dict[tuple[str, int], list[Array]] = {}  # expected and read, (2, m), by signal and column
    for index in part.spans:
        try:
            logs = simulated_recording(predictor, effects, index), part.data.recordings[index]
        except BoomError:
            continue
        for channel in part.data.of(index):
            if system.channel(channel.signal, channel.column).device == part.device:
                both = np.array([log[channel.signal].values[:, channel.column] for log in logs])
                pairs.setdefault((channel.signal, channel.column), []).append(both)
    for (signal, column), parts in pairs.items():
        whole = np.concatenate(parts, axis=1)
        expected, read = whole[:, np.isfinite(whole).all(axis=0)]
        (gain, offset), *_ = np.linalg.lstsq(np.stack([expected, np.ones_like(expected)], axis=1), read)
        left = np.var(read - gain * expected) / np.mean((read - expected) ** 2)
        if left < 1 - found.criteria.main_share:
            index, (begin, end) = next(iter(part.spans.items()))
            log = part.data.recordings[index]
            unit, name = log[signal].unit, f"{signal}/{log[signal].channels[column]}"
            size = f"{gain:.3g} times what explains the rest {offset:+.2g}{behind(unit)}"
            text = f"reads, in all logs, {size}, but for {left:.1%} of its misfit"
            yield DataFinding(log.name, name, "gain", begin, end, text, Action.LEFT_OUT, used=False)
