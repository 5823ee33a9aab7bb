"""What commands about a gap are given: a machine and its recordings, of a boom or through a channel map."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from boom_mj.cli.arguments import check_machine, find_machine, machine_text
from boom_mj.errors import InputError, LogError

if TYPE_CHECKING:
    from boom_mj.systems.recorded import RecordedMachine
    from boom_mj.systems.system import System


def load_gap_data(
    logs: Sequence[Path],
    holdout: Sequence[Path],
    machine: str | None = None,
    channels: Path | None = None,
    model: Path | None = None,
    healthy: Sequence[Path] = (),
    strict: bool = False,
    tell: Callable[[str], None] = lambda line: None,
) -> "RecordedMachine":
    """Read and check what is given.

    Args:
        channels: map of any machine's logs; a boom's if left out.
        healthy: logs on which the machine as built is trained.
        strict: refuse logs with which anything is wrong.
        tell: hears what healthy logs say.

    Raises:
        InputError: options that do not go together, logs that do not name their machine.
    """
    from boom_mj.diagnosis.clock import Clock
    from boom_mj.diagnosis.healthy import as_built

    check_machine(machine, channels, model)
    if channels is not None:
        return _any_machine(logs, holdout, channels, model, healthy, strict, tell)
    from boom_mj.logs import read_log
    from boom_mj.systems.boom import BoomSystem
    from boom_mj.systems.boom.load import checked_data
    from boom_mj.systems.recorded import RecordedMachine

    paths = [*logs, *holdout]
    recordings = [read_log(path) for path in paths]
    name = machine or recordings[0].machine
    if not name:
        raise InputError(f"{paths[0]}: the log does not name its machine; say which with --machine")
    system: System = (boom := BoomSystem(find_machine(name), machine_text(name)))
    if healthy:
        system = as_built(boom, [read_log(path) for path in healthy], Clock(tell=tell))
    checked = checked_data(boom, recordings, len(logs), list(map(str, paths)), built=system, strict=strict)
    return RecordedMachine(system, checked.data, tuple(checked.names), tuple(checked.findings))


def _any_machine(
    logs: Sequence[Path],
    holdout: Sequence[Path],
    channels: Path,
    model: Path | None,
    healthy: Sequence[Path],
    strict: bool,
    tell: Callable[[str], None],
) -> "RecordedMachine":
    from boom_mj.diagnosis.clock import Clock
    from boom_mj.diagnosis.healthy import as_built
    from boom_mj.systems.mjcf import load_mjcf
    from boom_mj.systems.predictor import dataset_of
    from boom_mj.systems.recorded import RecordedMachine

    given: RecordedMachine = load_mjcf(logs, holdout, channels, model)
    if healthy:
        well = load_mjcf(healthy, healthy, channels, model)
        system = as_built(well.system, well.data.recordings[: well.data.training], Clock(tell=tell))
        data = dataset_of(system, given.data.recordings, given.data.training)
        given = RecordedMachine(system, data, given.names, (*well.findings, *given.findings))
    if strict and given.findings:
        raise LogError("\n".join(finding.sentence for finding in given.findings))
    return given
