"""How long work is going: a bar with an estimate on a terminal, lines elsewhere; all on stderr."""

import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

Report = Callable[[str, int, int], None]  # (stage, done, total)
PAUSE = 60.0  # s between estimates of a stage


@contextmanager
def progress(resumed: str = "") -> Iterator[Report]:
    """Something to tell the stage, and how much of how much of it is done.

    Args:
        resumed: stage of which it is said, when it is first told, whether it goes on or begins afresh.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _lines(resumed)
        return
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=console) as bar:
        tasks: dict[str, TaskID] = {}

        def report(stage: str, done: int, total: int) -> None:
            if stage not in tasks:
                if stage == resumed:
                    bar.console.print(_resumption(stage, done, total), highlight=False)
                tasks[stage] = bar.add_task(stage, total=total)
            bar.update(tasks[stage], completed=done)

        yield report


def _resumption(stage: str, done: int, total: int) -> str:
    return f"{stage}: goes on, {done} of {total} are done" if done else f"{stage}: begins afresh"


def _lines(resumed: str) -> Report:
    """One line when a stage is done, and with an estimate when a twentieth of it is and once a minute from then on."""
    began: dict[str, tuple[float, int]] = {}
    told: dict[str, float] = {}

    def report(stage: str, done: int, total: int) -> None:
        now = time.monotonic()
        if stage == resumed and stage not in began:
            print(_resumption(stage, done, total), file=sys.stderr, flush=True)
        start, first = began.setdefault(stage, (now, done))
        if done == total:
            print(f"{stage}: {done} in {now - start:.0f} s", file=sys.stderr, flush=True)
        elif done > first and 20 * (done - first) >= total - first and now - told.get(stage, -math.inf) >= PAUSE:
            told[stage] = now
            left = (now - start) * (total - done) / (done - first)
            print(f"{stage}: {done} of {total}, about {left:.0f} s left", file=sys.stderr, flush=True)

    return report
