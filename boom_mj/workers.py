"""Processes that work for this one: they end with it, and leave its interruptions to it."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

from boom_mj.engine import keep_no_log
from boom_mj.errors import WorkerError


@contextmanager
def worker_pool(count: int) -> Iterator[ProcessPoolExecutor]:
    """Fresh processes; whatever ends the block early ends them at once.

    Raises:
        WorkerError: one of them was killed.
    """
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(count, context, begin_worker)
    try:
        yield pool
    except BaseException as error:
        pool.shutdown(wait=False, cancel_futures=True)
        for child in multiprocessing.active_children():
            child.terminate()
        if isinstance(error, BrokenProcessPool):
            raise WorkerError(
                "a worker died, perhaps for want of memory; what is done stays, and the same call finishes it "
                "(fewer processes need less)"
            ) from error
        raise
    pool.shutdown()


def begin_worker() -> None:
    """Make this process a worker: it leaves interruptions to its parent, and ends with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all processes of a terminal
    keep_no_log()
    threading.Thread(target=_leave_with_parent, daemon=True).start()


def _leave_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
