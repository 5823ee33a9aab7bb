"""Processes that work for this one: they end with it, and leave its interruptions to it."""

import ctypes
import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress

from boom_mj.engine import keep_no_log
from boom_mj.errors import WorkerError

MMAP_THRESHOLD, LARGE = -3, 2**20  # glibc's M_MMAP_THRESHOLD; bytes of an array that is to be freed at once


def return_memory() -> None:
    """Have every large array back with the system once it is freed: by itself glibc keeps gigabytes of threads."""
    with suppress(OSError, AttributeError):  # of other C libraries
        ctypes.CDLL(None).mallopt(MMAP_THRESHOLD, LARGE)


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
    return_memory()
    threading.Thread(target=_leave_with_parent, daemon=True).start()


def _leave_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
