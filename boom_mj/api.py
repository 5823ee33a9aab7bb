"""The diagnosis as Python asks for it: a machine and logs in, an answer out that can be asked on.

answer = diagnose("boom36", ["a.mcap"], ["b.mcap"])
print(answer.verdict, answer.sentence)
answer.to_html("gap.html")
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from boom_mj import diagnosis, discovery
from boom_mj.diagnosis.clock import Clock
from boom_mj.engine import no_log
from boom_mj.errors import InputError
from boom_mj.estimation.bootstrap import Closure
from boom_mj.files import write_text
from boom_mj.logs import read_log
from boom_mj.machine import Machine, load_machine
from boom_mj.recording import Recording
from boom_mj.replay.quality import DataFinding
from boom_mj.systems.boom.corrected import with_effects
from boom_mj.systems.boom.load import CheckedData, checked_data
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.predictor import Predictor

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Log = Recording | Path | str
NO_TABLES = ("ties", "skipped")  # lists whose entries are no rows


@dataclass(frozen=True)
class Estimate:
    """A parameter's size, with the ends of its 95 % interval, in `unit`; None where an end is open."""

    value: float
    low: float | None
    high: float | None
    unit: str


@dataclass(frozen=True)
class Cause:
    """An effect that the machine has and its file lacks.

    Attributes:
        id: of the effect in the library.
        location: where it acts, such as {"joint": 3}.
        parameters: its sizes, by name.
        closure_alone: share of the held-out gap that it closes by itself; None where that was not tried.
        share: of the held-out mean square of the machine as built that it takes; see `diagnosis.budget`.
        probability: that the machine has it.
    """

    id: str
    location: Mapping[str, int | str]
    parameters: Mapping[str, Estimate]
    closure_alone: float | None
    share: float
    probability: float


@dataclass(frozen=True)
class Answer:
    """What a diagnosis says.

    Attributes:
        machine: the nominal one.
        found: the diagnosis with all its candidates.
        names: of the logs, training first.
        findings: what is wrong with the logs themselves, and what was done about it.
    """

    machine: Machine
    found: diagnosis.Diagnosis
    names: tuple[str, ...]
    findings: tuple[DataFinding, ...] = ()

    @cached_property
    def document(self) -> dict[str, Any]:
        """All of it as plain data, as `gap diagnose --json` writes it."""
        channels = diagnosis.channel_steps(self.found, self.names)
        return diagnosis.document(self.found, self.names, self.findings, channels)

    @property
    def verdict(self) -> str:
        """consistent, explained, ambiguous, partial or unexplained."""
        return self.found.verdict

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        return str(self.document["sentence"])

    @property
    def effects(self) -> tuple[Cause, ...]:
        """What explains the gap; nothing where the verdict is consistent or unexplained."""
        return tuple(
            Cause(
                entry["id"],
                entry["location"],
                {name: Estimate(**estimate) for name, estimate in entry["parameters"].items()},
                entry["closure_alone"],
                entry["share"],
                entry["probability"],
            )
            for entry in self.document["effects"]
        )

    @property
    def closure(self) -> Closure:
        """Share of the held-out gap above the noise that the effects close, with its 95 % interval."""
        return self.found.closure

    @cached_property
    def corrected(self) -> Machine:
        """The machine with the effects of the best explanation."""
        return with_effects(self.machine, diagnosis.causes(self.found))

    @cached_property
    def as_built(self) -> Machine:
        """The corrected machine with its nuisances as they were estimated along, too: what was recorded."""
        return with_effects(self.machine, diagnosis.explanation(self.found))

    def to_html(self, path: Path | str) -> None:
        """Write the page of `gap diagnose --html`: one file, which fetches nothing."""
        from boom_mj.report import write_diagnosis

        write_diagnosis(self.found, self.document, Path(path))

    def draw_gaps(self, axes: "Axes") -> None:
        """Draw the held-out gaps of all channel groups, as built and with causes, into matplotlib axes."""
        from boom_mj.report import draw_gaps

        draw_gaps(axes, self.found, self.document)

    def to_frame(self, key: str = "effects") -> Any:
        """A table of the document as a pandas data frame, a row per entry; nested keys have dots between.

        Args:
            key: of a list of entries, such as "effects", "channels", "nuisances", "where" or "rivals".

        Raises:
            InputError: no such table, or no pandas.
        """
        tables = [name for name, rows in self.document.items() if isinstance(rows, list) and name not in NO_TABLES]
        if key not in tables:
            raise InputError(f"the answer has no table {key!r}; it has {', '.join(tables)}")
        try:
            import pandas
        except ImportError as error:
            raise InputError("data frames need pandas: pip install pandas") from error
        return pandas.json_normalize(self.document[key])


@dataclass(frozen=True)
class LawAnswer:
    """What a discovery says.

    Attributes:
        found: the discovery with all its laws.
        names: of the logs, training first.
        findings: what is wrong with the logs themselves.
    """

    found: discovery.Discovery
    names: tuple[str, ...]
    findings: tuple[DataFinding, ...] = ()

    @cached_property
    def document(self) -> dict[str, Any]:
        """All of it as plain data, as `gap discover --json` writes it."""
        return discovery.document(self.found, self.names, self.findings)

    @property
    def verdict(self) -> str:
        """law or none."""
        return self.found.verdict

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        return str(self.document["sentence"])

    @property
    def formula(self) -> str | None:
        """The law; None where there is none."""
        return self.document["law"]["formula"] if self.document["law"] else None

    @property
    def parameters(self) -> dict[str, Estimate]:
        """Sizes of the law by name; nothing where there is none."""
        law = self.document["law"] or {"parameters": {}}
        return {name: Estimate(**size) for name, size in law["parameters"].items()}

    def to_html(self, path: Path | str) -> None:
        """Write the page of `gap discover --html`."""
        from boom_mj.report import write_discovery

        write_discovery(self.found, self.names, Path(path), self.findings)

    def to_effect(self, path: Path | str) -> None:
        """Write the law as an effect called as the file is, which `load_effects` and `--effects` take.

        Raises:
            InputError: there is no law.
        """
        if self.formula is None:
            raise InputError(f"{path}: there is no law to be written")
        write_text(Path(path), discovery.law_file(self.found, Path(path).stem))


def diagnose(
    machine: Machine | Path | str,
    train: Sequence[Log],
    holdout: Sequence[Log] = (),
    *,
    without: Sequence[str] = (),
    most: int | None = None,
    seconds: float | None = None,
    tell: Callable[[str], None] = lambda line: None,
) -> Answer:
    """Find what a machine has that its file lacks; `diagnosis.diagnose` asks the same of any system.

    Args:
        machine: nominal; a file, or a name such as "boom36".
        train: recordings, or files of them, for training.
        holdout: the same, held out; the first part of one trains if no other recording shows its gap.
            Without any, the recordings are split in time.
        without: ids of effects that are withheld from the library.
        most: causes that an explanation may have; 2 if left out.
        seconds: after which nothing more is refined.
        tell: hears one line per stage, such as `print`.

    Raises:
        MachineFileError: no such machine.
        LogError: a log that cannot be read, or that lacks the joint angles.
    """
    system, checked = _checked(machine, train, holdout, tell)
    with no_log():  # of candidates that no machine could be
        found = diagnosis.diagnose(Predictor(system, checked.data), without, Clock(seconds, tell), most)
    return Answer(system.machine, found, checked.names, checked.findings)


def discover(
    machine: Machine | Path | str,
    train: Sequence[Log],
    holdout: Sequence[Log] = (),
    *,
    without: Sequence[str] = (),
    forces: bool = False,
    seconds: float | None = None,
    tell: Callable[[str], None] = lambda line: None,
) -> LawAnswer:
    """Find the law behind a gap that no effect of the library closes; arguments and errors as of `diagnose`.

    Args:
        without: ids of effects of the library that a law may stand for.
        forces: whether to estimate forces in time, without a formula, even where the gap is explained.
    """
    system, checked = _checked(machine, train, holdout, tell)
    with no_log():
        found = discovery.discover(Predictor(system, checked.data), without, Clock(seconds, tell), forces)
    return LawAnswer(found, checked.names, checked.findings)


def _checked(
    machine: Machine | Path | str, train: Sequence[Log], holdout: Sequence[Log], tell: Callable[[str], None]
) -> tuple[BoomSystem, CheckedData]:
    """The nominal boom, and what is sound of its recordings."""
    boom = machine if isinstance(machine, Machine) else load_machine(machine)
    logs = (*train, *holdout)
    recordings = [log if isinstance(log, Recording) else read_log(log) for log in logs]
    names = tuple(log.name if isinstance(log, Recording) else str(log) for log in logs)
    system = BoomSystem(boom)
    checked = checked_data(system, recordings, len(train), names)
    for finding in checked.findings:
        tell(finding.sentence)
    return system, checked
