"""Commands as a user calls them, each in a process of its own whose end can be told: done, refused, crashed, killed.

The process is a fork of this one, so that it starts at once; its memory, time and file sizes are limited.
"""

import os
import re
import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import boom_mj.blind
import boom_mj.calibration
import boom_mj.cameras.chain
import boom_mj.cameras.render
import boom_mj.diagnosis
import boom_mj.logs.inspection
import boom_mj.logs.proposal
import boom_mj.replay.quality
import boom_mj.report.calibration
import boom_mj.report.diagnosis
import boom_mj.report.overlay
import boom_mj.simulation.agreement
import boom_mj.sweeping
import boom_mj.systems.mjcf  # noqa: F401  # what commands import when they are called, so that a fork has it
from boom_mj.cli import run

MEMORY, SECONDS = 4 * 2**30, 60  # bytes of address space beyond what the process has that it forks from, s of CPU
CRASHED = 70
STOPS = {signal.SIGINT, signal.SIGTERM}
OUTCOMES = ("clear error", "accepted", "crash", "blow-up", "killed")


@dataclass(frozen=True)
class Attempt:
    """How a call ended.

    Attributes:
        status: exit status; the negative of a signal that ended it.
        told: its stderr.
        said: its stdout.
        wall: s.
    """

    status: int
    told: str
    said: str
    wall: float

    @property
    def story(self) -> str:
        """Its status and the end of what it told."""
        return f"{self.status} {self.told[-1500:]}"

    def outcome(self, *culprits: str) -> str:
        """One of OUTCOMES; an error is clear if it is short, ends with a sentence, and names one of the culprits."""
        if self.status == 0:
            return "accepted"
        if self.status in (-signal.SIGXCPU, -signal.SIGKILL) or "not enough memory" in self.told:
            return "blow-up"
        lines = self.told.strip().splitlines()
        short = lines and len(self.told) < 30_000 and "Traceback" not in self.told
        flat = re.sub(r"[\s│]+", "", self.told)  # typer wraps lines in a box
        named = not culprits or any(re.sub(r"\s+", "", word) in flat for word in culprits)
        return "clear error" if self.status in (1, 2) and short and named else "crash"


def attempt(
    arguments: Sequence[object],
    folder: Path,
    memory: int = MEMORY,
    seconds: int = SECONDS,
    file_size: int | None = None,
    kill: tuple[int, float] | None = None,
    before: Callable[[], None] | None = None,
) -> Attempt:
    """Call a command within a folder.

    Args:
        file_size: beyond which no file can grow, bytes.
        kill: signal, and after how many seconds it is sent.
        before: called in the process first.
    """
    said, told = folder / ".said", folder / ".told"
    said.touch()  # a child may be killed before it says anything
    told.touch()
    sys.stdout.flush()
    sys.stderr.flush()
    began = time.monotonic()
    listening, begun = os.pipe()
    child = os.fork()
    if child == 0:
        _be_the_command([str(a) for a in arguments], folder, said, told, memory, seconds, file_size, before, begun)
    os.close(begun)
    os.read(listening, 1)  # until the command begins, or its process has ended
    os.close(listening)
    if kill is not None:
        time.sleep(kill[1])
        with suppress(ProcessLookupError):
            os.kill(child, kill[0])
    _, end = os.waitpid(child, 0)
    found = Attempt(
        os.waitstatus_to_exitcode(end),
        told.read_text(errors="replace"),
        said.read_text(errors="replace"),
        time.monotonic() - began,
    )
    said.unlink()
    told.unlink()
    return found


def _address_space() -> int:
    """Of this process, bytes: what tests before left there is no command's."""
    return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()


def _be_the_command(
    arguments: list[str],
    folder: Path,
    said: Path,
    told: Path,
    memory: int,
    seconds: int,
    file_size: int | None,
    before: Callable[[], None] | None,
    begun: int,
) -> None:
    """The rest of a forked process; no signal lets it out."""
    status = CRASHED
    try:
        for number, path in ((1, said), (2, told)):
            os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
        sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115
        sys.stderr = open(2, "w", closefd=False, buffering=1)  # noqa: SIM115
        os.chdir(folder)
        for kind, most in (
            (resource.RLIMIT_CORE, 0),
            (resource.RLIMIT_CPU, seconds),
            (resource.RLIMIT_AS, _address_space() + memory),
            (resource.RLIMIT_FSIZE, file_size),
        ):
            if most is not None:
                resource.setrlimit(kind, (most, most))
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # as `main` has it
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        if before is not None:
            before()
        os.write(begun, b".")
        status = run(arguments)
        signal.pthread_sigmask(signal.SIG_BLOCK, STOPS)
    except BaseException:
        signal.pthread_sigmask(signal.SIG_BLOCK, STOPS)
        traceback.print_exc()
    finally:
        with suppress(BaseException):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(status)
