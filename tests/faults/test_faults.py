"""The bad day in small: what `scripts/faults.py` tries by the thousand, tried by the dozen on every change."""

import ast
import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import campaign as faults
import hostile
import numpy as np
import pytest
from campaign import Campaign
from count import Count
from inputs import ROOT, TARGETS, Target

from boom_mj import load_experiment, load_machine, make_plant, run_experiment
from boom_mj.cameras.dataset import read_dataset, read_picture
from boom_mj.cli.arguments import last_states_beside
from boom_mj.errors import BoomError, DatasetError, OutputError, SimulationError
from boom_mj.files import inside, locked, whole_file, write_text
from boom_mj.logs import inflating

HOSTILE = {
    ("simulate", "experiment.toml"),
    ("logs inspect", "log.mcap"),
    ("gap diagnose", "model.xml"),
    ("gap blind score", "answers/ca5e.json"),
}
TINY = 2**20


@pytest.fixture
def trying(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Campaign]:
    """A campaign with bombs of 64 MiB, which logs may not inflate to."""
    monkeypatch.setattr(inflating, "FREE", TINY)
    monkeypatch.setattr(hostile, "ZEROS", 64 * TINY)
    monkeypatch.setattr(hostile, "png_bomb", lambda: b"\x89PNG")

    def make(chosen: Callable[[Target], bool]) -> Campaign:
        return Campaign(tmp_path, chosen=chosen)

    return make


def clean(campaign: Campaign, tried: int) -> None:
    """At least so many inputs were tried, and all ended as they should."""
    counts = campaign.count.by_kind.values()
    assert not campaign.count.stories, "\n".join(campaign.count.stories)
    assert sum(count["tried"] for count in counts) >= tried
    assert sum(count["clear error"] for count in counts) > 0


def test_cut_and_corrupted_files_are_refused_in_a_sentence_by_every_command(trying) -> None:
    campaign = trying(lambda target: target.command not in faults.SLOW)
    campaign.run_broken(2)
    clean(campaign, 70)
    assert set(campaign.count.by_command) == {target.command for target in TARGETS} - {*faults.SLOW}


def test_hostile_files_do_no_harm(trying) -> None:
    campaign = trying(lambda target: (target.command, target.file) in HOSTILE)
    campaign.run_hostile()
    clean(campaign, 100)
    assert campaign.count.by_kind["hostile"]["clear error"] > 60


def test_values_that_are_no_numbers(trying) -> None:
    campaign = trying(lambda target: target.command in ("generate", "simulate"))
    campaign.run_not_a_number()
    clean(campaign, 60)


def test_places_that_cannot_be_written(trying) -> None:
    campaign = trying(lambda target: target.command in ("generate", "gap diagnose", "gap blind score"))
    campaign.run_places()
    clean(campaign, 30)


def test_full_disks_lose_no_old_file(trying) -> None:
    campaign = trying(lambda target: target.command in ("simulate", "generate"))
    campaign.run_full_disk()
    clean(campaign, 8)


def test_killed_at_any_moment(trying) -> None:
    campaign = trying(lambda target: (target.command, target.file) == ("simulate", "machine.toml"))
    campaign.run_killed(9)
    clean(campaign, 9)


def test_a_campaign_counts_what_should_not_be() -> None:
    count = Count()
    count.take("c", "cut", "l", "crash", ["x.part"], "story")
    count.take("c", "cut", "l", "clear error", [], "story")
    assert count.bad == 2 and len(count.stories) == 1
    assert "| cut | 2 | 1 | 0 | 1 | 0 | 1 |" in count.table()


def _killed_while_writing(path: Path) -> None:
    """Let a process be killed that holds the lock of a folder, if none has it, and has begun a file of it."""
    other = os.fork()
    if other == 0:
        try:
            with suppress(OutputError), locked(path.parent), whole_file(path):
                os.kill(os.getpid(), 9)
            with whole_file(path):
                os.kill(os.getpid(), 9)
        finally:
            os._exit(1)
    os.waitpid(other, 0)


def test_a_folder_has_one_writer_and_a_killed_one_leaves_it_and_nothing_in_it(tmp_path: Path) -> None:
    _killed_while_writing(tmp_path / "a" / "before")
    assert len(list((tmp_path / "a").iterdir())) == 1
    with locked(tmp_path / "a"):
        with pytest.raises(OutputError, match=r"a is being written by another process"), locked(tmp_path / "a"):
            pass
        with locked(tmp_path / "b"):
            pass
        assert not list((tmp_path / "a").iterdir())
        _killed_while_writing(tmp_path / "a" / "meanwhile")  # a worker of the one that has the lock
        with whole_file(tmp_path / "a" / "living"):
            assert len(list((tmp_path / "a").iterdir())) == 2
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["living"]
    with locked(tmp_path / "a"):
        pass


def test_links_and_devices_are_written_as_what_they_are(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "file")
    write_text(tmp_path / "link", "new")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "file").read_text() == "new"
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    write_text(tmp_path / "pipe", "through")
    assert os.read(reader, 100) == b"through" and (tmp_path / "pipe").is_fifo()
    os.close(reader)
    with pytest.raises(OutputError, match=r"/dev/full cannot be written: No space left"):
        write_text("/dev/full", "x")
    assert Path("/dev/full").is_char_device()
    with pytest.raises(ValueError, match="half"), whole_file(tmp_path / "file") as stream:
        stream.write(b"half")
        raise ValueError("half")
    assert (tmp_path / "file").read_text() == "new" and not list(tmp_path.glob(".*"))


def test_names_do_not_lead_out_of_a_folder(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "link").symlink_to("/etc")
    assert inside(tmp_path / "in", "a/../b.png", BoomError, tmp_path) == tmp_path / "in" / "a/../b.png"
    for name in ("../b", "/etc/passwd", "a/../../b", "link/passwd", "a\x00b"):
        with pytest.raises(BoomError, match=r"outside|no name"):
            inside(tmp_path / "in", name, BoomError, tmp_path)


def test_descriptions_of_pictures_that_do_harm(trying, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    campaign, refused = trying(lambda target: False), 0
    folder = campaign.whole / "film"
    whole = (folder / "dataset.json").read_bytes()
    (folder / "link").symlink_to("/etc")
    for _, data in hostile.datasets(faults.json.loads(whole)):
        (folder / "dataset.json").write_bytes(data)
        try:
            read_dataset(folder)
        except DatasetError:
            refused += 1
    assert refused >= 8
    monkeypatch.undo()
    (tmp_path / "bomb.png").write_bytes(hostile.png_bomb(20_000))
    with pytest.raises(DatasetError, match=r"bomb\.png has 400000000 pixels"):
        read_picture(tmp_path / "bomb.png")


def test_nothing_is_unpickled_or_evaluated() -> None:
    banned = {"pickle", "marshal", "shelve", "joblib", "yaml"}
    package = ROOT / "boom_mj"
    # work on its way to our own processes, and effects there and back at once: never a file
    ours = {package / name for name in ("spreading.py", "effects/registry.py", "testing.py")}
    for path in {*package.rglob("*.py")} - ours:
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [str(node.module)] if isinstance(node, ast.ImportFrom) else []
            assert not banned & {name.partition(".")[0] for name in names}, path
            if isinstance(node, ast.Call):
                called = ast.unparse(node.func)
                safe = any(k.arg == "allow_pickle" and ast.unparse(k.value) == "False" for k in node.keywords)
                assert called not in ("eval", "exec") and (safe or called not in ("np.load", "numpy.load")), path
    for path in ours:  # what is unpickled there has been pickled there
        text = path.read_text()
        assert "pickle.dumps(" in text and "pickle.load(" not in text and "Unpickler" not in text, path


def test_a_simulation_that_diverges_says_when_and_where_and_keeps_its_last_states(tmp_path: Path) -> None:
    plant = make_plant(load_machine(ROOT / "models" / "boom36.toml"))
    plant.model.dof_damping[plant.model.joint("link5_v_1").dofadr[0]] = -1e5
    with (
        pytest.raises(SimulationError, match=r"at about t = 0\.\d{3} s: link5_v_1 of link5_2") as caught,
        last_states_beside(tmp_path / "out.mcap"),
    ):
        run_experiment(plant, load_experiment("release_stretched_vertical"))
    states = caught.value.states
    assert len(states.time) > 1 and np.isfinite(states.qpos).all() and np.isfinite(states.qvel).all()
    assert "out.diverged.csv holds the last" in str(caught.value)
    head, *rows = (tmp_path / "out.diverged.csv").read_text().splitlines()
    assert head.startswith("time_s,joint1,") and "link5_v_1_speed" in head and len(rows) == len(states.time)


@pytest.mark.parametrize("way", ["nonsense", "osmesa"])
def test_commands_that_draw_nothing_need_no_opengl(way: str) -> None:
    environment = {**os.environ, "MUJOCO_GL": way, "PYTHONPATH": str(ROOT)}
    call = [sys.executable, "-m", "boom_mj", "generate", str(ROOT / "models" / "boom36.toml")]
    done = subprocess.run(call, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0 and done.stdout.startswith("<mujoco"), done.stderr
