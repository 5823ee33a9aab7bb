"""What cameras cannot do is said in a sentence: bad calls, pictures from which nothing follows, full disks."""

import errno
import os
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from small_rig import RIG, ROOT, SHORT, TEXT, boom

from boom_mj.cameras.align import Pattern
from boom_mj.cameras.calibrate import calibrate_lens, place_camera
from boom_mj.cameras.chain import track
from boom_mj.cameras.dataset import (
    CameraEntry,
    Dataset,
    PictureEntry,
    PlateEntry,
    claim_folder,
    read_picture,
    write_json,
)
from boom_mj.cameras.intrinsics import Intrinsics
from boom_mj.cameras.recognise import catalogue_of
from boom_mj.cameras.targets import plate_picture
from boom_mj.cli import main
from boom_mj.errors import BoomError, DatasetError, MachineFileError, OutputError, TrackError
from boom_mj.machine import load_machine, parse_machine
from boom_mj.machine.rig import Chequerboard


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("machine") / "close.toml"
    path.write_text(TEXT + RIG)
    return path


@pytest.fixture
def refused(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture):
    """Exit status and stderr of a command that fails before it renders, without the start of a process."""

    def call(*arguments: object) -> tuple[int, str]:
        monkeypatch.setattr(sys, "argv", ["boom_mj", *map(str, arguments)])
        with pytest.raises(SystemExit) as left:
            main()
        return int(left.value.code or 0), capsys.readouterr().err

    return call


def test_bad_calls_are_told_in_a_sentence(machine: Path, tmp_path: Path, refused) -> None:
    full = tmp_path / "full"
    full.mkdir()
    (full / "holiday.jpg").write_bytes(b"beach")
    (tmp_path / "file").write_text("")
    rigs = {"plain": "", "away": RIG.replace("look_at = [3.4, 0.0, 3.2]", "look_at = [3.4, -40.0, 3.2]", 1)}
    rigs["sky"] = RIG.replace("look_at = [3.4, 0.0, 3.2]", "look_at = [3.4, 0.0, 60.0]", 1)
    for name, rig in rigs.items():
        (tmp_path / f"{name}.toml").write_text(TEXT + rig)
    new = tmp_path / "x"
    cases = [
        (["render", machine, "-o", full, *SHORT], "holiday.jpg"),
        (["render", machine, "-o", tmp_path / "file", *SHORT], "needs a folder"),
        (["render", machine, "-o", new, "--camera", "up"], "right, left"),
        (["render", machine, "-o", new, "--layout", "yolo"], "nerfstudio"),
        (["render", machine, "-o", new, "--stop", 99], "99"),
        (["render", tmp_path / "plain.toml", "-o", new], "[[camera]]"),
        (["render", tmp_path / "away.toml", "-o", new, *SHORT], "behind it"),
        (["render", tmp_path / "sky.toml", "-o", new, *SHORT], "outside its picture"),
        (["render", "nowhere.mcap", "-o", new], "nowhere.mcap"),
        (["track", full], "dataset.json"),
    ]
    for arguments, told in cases:
        status, message = refused(*arguments)
        assert (status, told in message) == (2, True), (arguments, message)
    assert [p.name for p in full.iterdir()] == ["holiday.jpg"] and not new.exists()


def test_without_opengl_it_is_told_what_to_install(machine: Path, tmp_path: Path) -> None:
    done = boom("render", machine, "-o", tmp_path / "x", *SHORT, gl="disabled")
    assert done.returncode == 1 and "libegl1" in done.stderr and "Traceback" not in done.stderr


def test_a_description_that_is_none(tmp_path: Path, refused) -> None:
    (tmp_path / "dataset.json").write_text('{"name": 3}')
    status, message = refused("track", tmp_path)
    assert status == 2 and re.search(r"name|machine|cameras", message)


def test_pictures_from_which_nothing_follows(tmp_path: Path) -> None:
    grey, plate = [np.full((288, 448), 128, np.uint8)] * 6, plate_picture("reference1", (0.8, 0.5))
    with pytest.raises(TrackError, match=r"left: the chequerboard .* in 0 of 6 pictures"):
        calibrate_lens("left", grey, Chequerboard())
    entry = PlateEntry(name="reference1", picture="", size=(0.8, 0.5), center=(0, 0, 1), right=(1, 0, 0), up=(0, 0, 1))
    catalogue, lens = (
        catalogue_of([Pattern(entry.name, plate, entry.size)]),
        Intrinsics(448, 288, (390,) * 2, (224, 144)),
    )
    with pytest.raises(TrackError, match=r"left: its place needs .* found none"):
        place_camera("left", grey[:1], lens, catalogue, {entry.name: entry})
    (tmp_path / "torn.png").write_bytes(b"torn")
    with pytest.raises(DatasetError, match=r"torn\.png is no picture"):
        read_picture(tmp_path / "torn.png")
    board, frame = PictureEntry(camera="left", file="b.png"), PictureEntry(camera="left", file="f.png")
    alone = Dataset(
        name="a", machine="m", cameras=(CameraEntry(name="left", width=448, height=288),), plates=(entry,), lateral=(),
        chequerboard=Chequerboard(), calibration=(board,), frames=(frame,),
    )  # fmt: skip
    for dataset, told in ((alone, "two cameras"), (alone.model_copy(update={"calibration": ()}), "chequerboard")):
        write_json(tmp_path / "dataset.json", dataset.model_dump(mode="json"))
        with pytest.raises(BoomError, match=told):
            track(tmp_path)


def test_a_full_disk_leaves_no_half_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(part: Path, target: Path) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    (tmp_path / "a.json").write_text("old")
    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OutputError, match=r"a\.json cannot be written: No space left on device"):
        write_json(tmp_path / "a.json", {"new": True})
    assert [p.name for p in tmp_path.iterdir()] == ["a.json"] and (tmp_path / "a.json").read_text() == "old"


def test_a_place_that_cannot_be_written_is_told(machine: Path, tmp_path: Path, refused) -> None:
    name = re.escape(str(tmp_path / "set" / "plates"))
    status, message = refused(
        "render", machine, "-o", tmp_path / "set", *SHORT, "--sheet", tmp_path / "no" / "sheet.png"
    )
    assert status == 2 and "there is no folder" in message
    patch = pytest.MonkeyPatch()
    with patch.context() as inside:
        inside.setattr("boom_mj.cameras.render.claim_folder", _blocked)
        status, message = refused("render", machine, "-o", tmp_path / "set", *SHORT)
    assert status == 1 and re.search(rf"{name}.* cannot be written: ", message)


def _blocked(folder: Path, dataset: Dataset) -> None:
    claim_folder(folder, dataset)
    (folder / "plates").write_text("in the way")


def test_machine_files_without_cameras_still_load_and_bad_cameras_are_named() -> None:
    assert parse_machine(TEXT).camera == ()
    assert len(load_machine(ROOT / "models" / "boom36.toml").camera) == 3
    for old, new, told in (
        ("exposure = 0.004", "exposure = 0.4", "longer than a frame"),
        ("focal_length = [390.0, 390.0]", "focal_length = [-1.0, 390.0]", "greater than 0"),
        ('name = "left"', 'name = "right"', "must differ"),
        ("readout = 0.01", "shutter = 0.01", "known here"),
    ):
        with pytest.raises(MachineFileError, match=told):
            parse_machine(TEXT + RIG.replace(old, new, 1))
