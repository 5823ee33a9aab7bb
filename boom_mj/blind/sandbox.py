"""A diagnosis reads its case and what is nominal: Python's audit hook refuses to open any other file.

Allowed besides the case are Python's own files, this package's, and what the operating system shows of itself. The
hook holds for the thread that asked for it, so that a worker's own housekeeping goes on.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from pathlib import Path
from typing import Any

OWN = (sys.prefix, sys.base_prefix, str(Path(__file__).parents[1]), "/proc", "/sys", "/dev", "/etc")
_allowed: ContextVar[tuple[str, ...]] = ContextVar("allowed", default=())


@contextmanager
def confined_to(*paths: Path) -> Iterator[None]:
    """Within the block, opening a file that is none of these, nor within one, raises PermissionError."""
    _install()
    token = _allowed.set(tuple(os.path.realpath(root) for root in (*map(str, paths), *OWN)))
    try:
        yield
    finally:
        _allowed.reset(token)


@cache
def _install() -> None:
    sys.addaudithook(_guard)


def _guard(event: str, arguments: tuple[Any, ...]) -> None:
    allowed = _allowed.get()
    if event != "open" or not allowed or not isinstance(arguments[0], str | bytes | os.PathLike):
        return
    path = os.path.realpath(os.fsdecode(arguments[0]))
    if not any(path == root or path.startswith(root + os.sep) for root in allowed):
        raise PermissionError(f"a blind diagnosis must not open {path}")
