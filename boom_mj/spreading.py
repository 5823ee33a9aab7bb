"""Work on many items, spread over processes of this machine or of a Dask cluster: the same call, the same results.

The work travels to every process once, items travel one by one, and results come back to the caller as they end: what
the caller writes is written once. A process that dies takes along what it had begun and nothing else; another begins
that again. An item that no process survives is given up by its name, and the rest goes on. A process has one item at a
time, and its linear algebra one thread, so that results do not depend on where the work was done.
"""

import logging
import multiprocessing
import pickle
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from itertools import islice
from queue import Queue
from typing import Any, Generic, TypeVar, cast
from uuid import uuid4

from threadpoolctl import threadpool_limits

from boom_mj.errors import InputError, WorkerError
from boom_mj.workers import begin_worker

Item = TypeVar("Item")
Result = TypeVar("Result")
TRIES = 3  # processes of this machine that an item may kill; on a cluster the scheduler's allowed-failures counts
AHEAD = 2  # items on their way to each process of a cluster
PATIENCE = 20  # s, for a cluster to answer
RECOUNT = 1.0  # s, after which the workers of a cluster are counted again


@dataclass(frozen=True)
class Done(Generic[Item, Result]):
    """An item whose work has ended, with its result or with what went wrong."""

    item: Item
    value: Result | None
    error: BaseException | None

    def result(self) -> Result:
        """The result; raises what went wrong."""
        if self.error is not None:
            raise self.error
        return cast(Result, self.value)


def spread(
    work: Callable[[Item], Result], items: Iterable[Item], jobs: int = 1, cluster: str | None = None
) -> Iterator[Done[Item, Result]]:
    """Work on items in processes; yields each as it ends, in any order.

    Args:
        work: a function, or a `partial` of one, that can be pickled; paths in it and in items should be absolute.
        items: taken as they are needed; `str` names them.
        jobs: processes on this machine.
        cluster: address of a Dask scheduler to use instead; its workers have one thread each and see the same files.

    Raises:
        InputError: no such cluster, or none that can be used.
        WorkerError: the scheduler was lost. An item that is given up has it as its error instead.
    """
    return _in_processes(work, items, jobs) if cluster is None else _on_cluster(work, items, cluster)


def results(
    work: Callable[[Item], Result], items: Iterable[Item], jobs: int = 1, cluster: str | None = None
) -> Iterator[tuple[Item, Result]]:
    """Like `spread`, for work that should not fail: its errors are raised at once.

    Raises:
        WorkerError: items that were given up, when all others are done.
    """
    lost = []
    for done in spread(work, items, jobs, cluster):
        if isinstance(done.error, WorkerError):
            lost.append(str(done.error))
        else:
            yield done.item, done.result()
    if lost:
        raise WorkerError(f"{'; '.join(lost)}; what is done stays, and the same call tries again what is not")


def _in_processes(work: Callable[[Item], Result], items: Iterable[Item], jobs: int) -> Iterator[Done[Item, Result]]:
    """A pool for every process, so that one that dies tells which item it had."""
    context, packed, queue = multiprocessing.get_context("spawn"), pickle.dumps(work), iter(items)
    running: dict[Future[Result], tuple[Item, int, ProcessPoolExecutor]] = {}

    def begin(item: Item, deaths: int = 0, pool: ProcessPoolExecutor | None = None) -> None:
        new = pool is None
        pool = pool or ProcessPoolExecutor(1, context, begin_worker)
        try:
            running[pool.submit(_do, item, packed if new else None)] = item, deaths, pool
        except BrokenProcessPool:  # it died between two items
            begin(item, deaths)

    try:
        for item in islice(queue, jobs):
            begin(item)
        while running:
            future = next(iter(wait(running, return_when=FIRST_COMPLETED).done))
            item, deaths, pool = running.pop(future)
            error = future.exception()
            if died := isinstance(error, BrokenProcessPool):
                pool.shutdown()
                if deaths + 1 < TRIES:
                    begin(item, deaths + 1)
                    continue
                error = _given_up(item, TRIES)
            done: Done[Item, Result] = Done(item, None if error else future.result(), error)
            if following := list(islice(queue, 1)):
                begin(following[0], pool=None if died else pool)
            else:
                pool.shutdown()
            yield done
    except BaseException:
        for child in multiprocessing.active_children():
            child.terminate()
        raise
    finally:
        for future, (_, _, pool) in running.items():
            future.cancel()
            pool.shutdown()


def _on_cluster(work: Callable[[Item], Result], items: Iterable[Item], address: str) -> Iterator[Done[Item, Result]]:
    """What killed its workers comes again in the end, alone: a dying worker blames all that waited for it."""
    try:
        from dask import distributed
    except ImportError as error:
        raise InputError("--cluster needs the optional packages: pip install 'boom_mj[cluster]'") from error
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # what it logs is told as an error
    try:
        client = distributed.Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise InputError(f"--cluster {address}: no Dask scheduler answers there") from error
    with client:
        _refuse_unfit(client, address)
        name = f"boom_mj-{uuid4()}"
        plugin: Any = distributed.WorkerPlugin()
        plugin.work = work
        client.register_plugin(plugin, name)  # workers that come later have it, too; as a task it would be done again
        suspects: list[Item] = []
        try:
            for done in _ended(client, name, iter(items), alone=False):
                if isinstance(done.error, distributed.scheduler.KilledWorker):
                    suspects.append(done.item)
                else:
                    yield done
            for done in _ended(client, name, iter(suspects), alone=True):
                if isinstance(done.error, distributed.scheduler.KilledWorker):
                    done = Done(done.item, None, _given_up(done.item, done.error.allowed_failures + 1))
                yield done
        finally:
            with suppress(OSError, TimeoutError):
                client.unregister_worker_plugin(name)


def _ended(client: Any, plugin: str, queue: Iterator[Item], alone: bool) -> Iterator[Done[Item, Any]]:
    """Items as they end on a cluster; only as many are there at once as keep it busy.

    A result is taken off its worker as soon as it is there, lest the worker's death have it made again.
    """
    ended: Queue[tuple[Any, Done[Item, Any] | None]] = Queue()
    waiting: set[Any] = set()
    room, recount = 1, 0.0

    def take(future: Any, item: Item) -> None:
        done: Done[Item, Any] | None
        try:
            done = Done(item, future.result(), None)  # whatever becomes of the worker that has it
        except BaseException as error:
            done = Done(item, None, error) if future.status == "error" else None
        ended.put((future, done))
        future.release()

    while True:
        if not alone and time.monotonic() > recount:
            try:
                room, recount = AHEAD * max(1, len(client.nthreads())), time.monotonic() + RECOUNT
            except OSError as error:
                raise _without_scheduler(client) from error
        for item in islice(queue, max(0, room - len(waiting))):
            future = client.submit(_call_of, plugin, item, pure=False)
            waiting.add(future)
            future.add_done_callback(partial(take, item=item))
        if not waiting:
            return
        future, done = ended.get()
        waiting.remove(future)
        if done is None:
            raise _without_scheduler(client)
        yield done


def _without_scheduler(client: Any) -> WorkerError:
    address = client.scheduler.address
    return WorkerError(f"the Dask scheduler at {address} was lost; what is done stays, and the same call does the rest")


def _refuse_unfit(client: Any, address: str) -> None:
    with suppress(TimeoutError):
        client.wait_for_workers(1, timeout=PATIENCE)
    workers = client.nthreads()
    if not workers:
        raise InputError(f"--cluster {address} has no workers; start some with `dask worker {address} --nthreads 1`")
    for worker, found in client.run(find_spec, "boom_mj", on_error="ignore").items():
        if found is None:
            raise InputError(f"--cluster {address}: worker {worker} has no boom_mj; install this version where it runs")
    for worker, threads in workers.items():
        if threads > 1:
            raise InputError(
                f"--cluster {address}: worker {worker} has {threads} threads and would work on as many items in one "
                "process; start workers with --nthreads 1, and as many as there are cores with --nworkers"
            )


def _given_up(item: object, deaths: int) -> WorkerError:
    return WorkerError(f"{item}: {deaths} processes that had begun it died, perhaps for want of memory; given up")


def _call(work: Callable[[Item], Result], item: Item) -> Result:
    with threadpool_limits(1):
        return work(item)


def _call_of(plugin: str, item: Any) -> Any:
    """An item on a worker of a cluster."""
    from dask.distributed import get_worker

    worker: Any = get_worker()
    return _call(worker.plugins[plugin].work, item)


_work: list[Any] = []  # of this process


def _do(item: Any, packed: bytes | None) -> Any:
    """An item in a process, whose first one brings the work: what starts it would wait for one that died for ever."""
    if packed is not None:
        _work[:] = [pickle.loads(packed)]
    return _call(_work[0], item)
