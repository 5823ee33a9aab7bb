"""What can go wrong, as one small tree.

Every message is one sentence that names the culprit and the valid choices. The command line maps the two
branches to its exit statuses: `InputError` (what was asked cannot be asked) to 2, every other `BoomError` to 1.
"""

import reprlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


class BoomError(Exception):
    """The work failed; the message says on what."""


class InputError(BoomError):
    """The call was wrong before any work began: a bad machine file, an unknown name, a value out of range."""


class MachineFileError(InputError):
    """A machine file that is not a machine: every bad value with its place, the value and what is allowed."""


class ExperimentError(InputError):
    """An experiment that does not exist or that the machine cannot perform."""


class ChannelMapError(InputError):
    """A channel map that is none: every bad entry with its place, the value and what is allowed."""


class TopicMapError(InputError):
    """A topic map that is none: every bad entry with its place, the value and what is allowed."""


class EffectError(InputError):
    """An effect, or a parameter of one, that does not exist or is out of bounds."""


class WorkerError(BoomError):
    """Processes that work was spread over are lost: which item none of them survived, or which scheduler is gone."""


class LogError(BoomError):
    """A log that cannot be read or lacks what was asked of it: file, topic, joint or time are named."""


class LogWarning(UserWarning):
    """What was done about a flaw of a log that does not stop its use; the command line shows it on stderr."""


class EffectWarning(UserWarning):
    """An effect of another package that cannot be loaded: which, and why."""


class EquilibriumError(BoomError):
    """No static equilibrium was found; the residual and the pose are named."""


class OutputError(BoomError):
    """A file or folder cannot be written: which, and why; an old file is untouched then."""


class SimulationError(BoomError):
    """A simulation diverged: when, and which coordinate.

    Attributes:
        states: the last states before it, a `simulation.LastStates`; None where there are none.
    """

    def __init__(self, message: str, states: Any = None) -> None:
        super().__init__(message)
        self.states = states


class RenderError(BoomError):
    """Pictures cannot be made: no OpenGL, no such kind of picture."""


class DatasetError(InputError):
    """A folder of pictures that is not what was asked for: what it holds, and what it must hold."""


class TrackError(BoomError):
    """Pictures from which no positions follow: which camera, and what was missing."""


def shown(value: Any) -> str:
    """A bad value as a message shows it: however long or deep it is, on less than a line."""
    short = reprlib.Repr()
    short.maxlevel, short.maxstring, short.maxother, short.maxlist, short.maxtuple = 3, 100, 100, 10, 10
    return short.repr(value)


NO_MEMORY = (  # what libraries say that find none; MuJoCo both of the first two
    "could not allocate memory", "caught an unknown exception", "cannot allocate memory", "can't start new thread",
    "failed to map segment",
)  # fmt: skip


def lacks_memory(error: BaseException) -> bool:
    """Whether memory had an end, whatever the library calls it that came upon it."""
    return isinstance(error, MemoryError) or any(words in str(error).lower() for words in NO_MEMORY)


@contextmanager
def numbers_of(subject: str, refuse: type[BoomError]) -> Iterator[None]:
    """What numerics make of numbers that pass one by one but not together is the fault of their owner.

    Raises:
        refuse: a matrix that is none, an overflow, a model that MuJoCo does not take; the owner is named.
    """
    try:
        yield
    except (ArithmeticError, ValueError) as error:
        raise refuse(f"the numbers of {subject} do not go together: {error}") from error
