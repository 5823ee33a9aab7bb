"""Work spread over processes of this machine and of a Dask cluster: the same results, whoever dies on the way."""

import os
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest

from boom_mj.errors import InputError, WorkerError
from boom_mj.spreading import TRIES, results, spread

WAYS = ("processes", "cluster")


@pytest.fixture(params=WAYS)
def way(request: pytest.FixtureRequest) -> dict:
    """The flags of either way."""
    if request.param == "processes":
        return {"jobs": 2}
    address = request.getfixturevalue("cluster")
    import cloudpickle

    cloudpickle.register_pickle_by_value(sys.modules[__name__])
    return {"cluster": address}


def note(item: int, folder: Path, seconds: float = 0.0, deadly: int = -1, wrong: int = -1) -> int:
    """Leaves a file that says who began it; the deadly one kills whoever does."""
    (folder / f"{item}-{os.getpid()}-{time.time_ns()}").touch()
    if item == deadly:
        os.kill(os.getpid(), signal.SIGKILL)
    if item == wrong:
        raise ValueError(f"item {item} is wrong")
    time.sleep(seconds)
    return item * item


def begun(folder: Path) -> list[tuple[int, int]]:
    """Items and processes of everything that was begun, the latest last."""
    notes = [tuple(map(int, path.name.split("-"))) for path in folder.iterdir()]
    return [(item, process) for item, process, _ in sorted(notes, key=lambda note: note[2])]


def test_a_killed_process_loses_nothing_and_nothing_comes_twice(way: dict, tmp_path: Path) -> None:
    taken, found = [], []
    items = (taken.append(k) or k for k in range(10))
    for done in spread(partial(note, folder=tmp_path, seconds=0.5), items, **way):
        found.append((done.item, done.result()))
        assert len(taken) <= len(found) + 4  # items are taken as they are needed
        if len(found) == 2:
            while len(begun(tmp_path)) < 4:
                time.sleep(0.01)
            victim = begun(tmp_path)[-1]
            os.kill(victim[1], signal.SIGKILL)
    assert sorted(found) == [(k, k * k) for k in range(10)]
    notes = begun(tmp_path)
    again = {item for item, _ in notes if [n for n, _ in notes].count(item) > 1}
    assert again <= {item for item, process in notes if process == victim[1]}  # of the dead one, and of no other
    assert len(notes) == 10 + len(again)


def test_an_item_that_no_process_survives_is_given_up_by_name_and_the_rest_is_done(way: dict, tmp_path: Path) -> None:
    found = []
    with pytest.raises(WorkerError, match=r"^3: \d processes .* died.* the same call tries again"):
        for item, value in results(partial(note, folder=tmp_path, deadly=3), range(6), **way):
            found.append((item, value))
    assert sorted(found) == [(k, k * k) for k in range(6) if k != 3]
    if "jobs" in way:
        assert [item for item, _ in begun(tmp_path)].count(3) == TRIES


def test_processes_that_die_as_they_start_are_not_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As they do for want of memory; with more to tell them than a pipe holds, which nobody reads then."""
    (tmp_path / "sitecustomize.py").write_text(
        "import os, sys\nif 'spawn_main' in ' '.join(sys.orig_argv):\n    os._exit(1)\n"
    )
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}")
    work = partial(len_of, bytes(2**20))
    (done,) = spread(work, [1], jobs=1)
    assert isinstance(done.error, WorkerError) and f"{TRIES} processes that had begun it died" in str(done.error)


def len_of(much: bytes, item: int) -> int:
    return item + len(much)


def test_an_error_of_the_work_is_the_items_own(way: dict, tmp_path: Path) -> None:
    ended = {done.item: done for done in spread(partial(note, folder=tmp_path, wrong=1), range(3), **way)}
    assert [ended[k].value for k in (0, 2)] == [0, 4]
    with pytest.raises(ValueError, match="item 1 is wrong"):
        ended[1].result()


def test_clusters_that_cannot_be_used_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr("boom_mj.spreading.PATIENCE", 0.5)
    options = {"processes": False, "protocol": "tcp://", "dashboard_address": ":0", "host": "127.0.0.1"}
    with pytest.raises(InputError, match="no Dask scheduler answers"):
        list(spread(abs, [1], cluster="tcp://127.0.0.1:9"))
    with (
        distributed.LocalCluster(**options, n_workers=0) as empty,
        pytest.raises(InputError, match="no workers; start some with `dask worker tcp"),
    ):
        list(spread(abs, [1], cluster=empty.scheduler_address))
    with (
        distributed.LocalCluster(**options, n_workers=1, threads_per_worker=3) as wide,
        pytest.raises(InputError, match=r"3 threads .* --nthreads 1"),
    ):
        list(spread(abs, [1], cluster=wide.scheduler_address))
    monkeypatch.setattr("boom_mj.spreading.find_spec", {}.get)
    with (
        distributed.LocalCluster(**options, n_workers=1, threads_per_worker=1) as bare,
        pytest.raises(InputError, match=r"worker tcp://.* has no boom_mj"),
    ):
        list(spread(abs, [1], cluster=bare.scheduler_address))


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_processes_leave_with_their_parent(tmp_path: Path) -> None:
    code = f"""
import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})
from functools import partial; from pathlib import Path; from boom_mj.spreading import spread; import test_spreading
if __name__ == "__main__":
    list(spread(partial(test_spreading.note, folder=Path({str(tmp_path)!r}), seconds=60), [1, 2], jobs=2))
"""
    script = tmp_path.with_suffix(".py")
    script.write_text(code)
    parent = subprocess.Popen([sys.executable, script])
    while len(list(tmp_path.iterdir())) < 2:
        assert parent.poll() is None
        time.sleep(0.05)
    parent.kill()
    parent.wait()
    deadline = time.monotonic() + 20
    while alive := [pid for _, pid in begun(tmp_path) if Path(f"/proc/{pid}").exists()]:
        assert time.monotonic() < deadline, alive
        time.sleep(0.05)
