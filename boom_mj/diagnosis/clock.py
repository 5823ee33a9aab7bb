"""How much time a diagnosis has, what it says on its way, and what it leaves out for want of time."""

import time
from collections.abc import Callable


class Clock:
    """A time budget that stages look at; it only ever gets later, and remembers what was skipped.

    Args:
        seconds: after which nothing more is refined; None for as long as it takes.
        tell: hears one line per stage.
    """

    def __init__(self, seconds: float | None = None, tell: Callable[[str], None] = lambda line: None):
        self.tell = tell
        self._end = None if seconds is None else time.monotonic() + seconds
        self._skipped: dict[str, None] = {}

    @property
    def skipped(self) -> tuple[str, ...]:
        """What was not looked at, in the order in which it would have been."""
        return tuple(self._skipped)

    def over(self, what: str) -> bool:
        """Whether there is no time left for something, which is then remembered as skipped."""
        late = self._end is not None and time.monotonic() > self._end
        if late:
            self._skipped[what] = None
        return late
