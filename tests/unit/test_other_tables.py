"""JSON and C3D logs as tables of numbers by field; C3D files are written here as its user guide lays them out."""

import json
import struct
from pathlib import Path

import numpy as np
import pytest

from boom_mj.errors import LogError, LogWarning
from boom_mj.logs.columns import read_columns


def test_json_of_lists_and_of_records(tmp_path: Path) -> None:
    lists, records = tmp_path / "a.json", tmp_path / "b.json"
    lists.write_text(json.dumps({"t": [0, 1], "arm": {"q": [[1, 2], [3, 4]]}}))
    records.write_text(json.dumps([{"t": 0, "arm": {"q": [1, 2]}}, {"t": 1, "arm": {"q": [3, 4]}, "late": 5}]))
    for path in (lists, records):
        found = read_columns(path, ["t", "arm.q[1]"])
        assert [list(column) for column in found.values()] == [[0, 1], [2, 4]]
    assert np.isnan(read_columns(records, ["late"])["late"][0])


@pytest.mark.parametrize("text", ["", "[1, 2]", "{", "3"])
def test_what_is_no_table_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(LogError):
        read_columns(path, ["t"])


def test_parquet_says_what_it_needs_or_reads(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        path.write_bytes(b"PAR1")
        with pytest.raises(LogError, match="boom_mj\\[parquet\\]"):
            read_columns(path, ["t"])
    else:
        parquet.write_table(pyarrow.table({"t": [0.0, 1.0], "q": [[1.0, 2.0], [3.0, 4.0]]}), path)
        assert list(read_columns(path, ["q[1]"])["q[1]"]) == [2, 4]


ROWS = [(0.0, 0.5, "1"), (0.01, -0.25, "0"), (0.02, 1.0, "1")]


def text(between: str = ",", head: str = "t,q,u", comma: bool = False) -> str:
    rows = [between.join(map(str, row)) for row in ROWS]
    return "\n".join([head.replace(",", between), *(row.replace(".", ",") if comma else row for row in rows)]) + "\n"


@pytest.mark.parametrize(
    "content",
    [
        text(),
        text(";"),
        text(";", comma=True),
        text("\t", comma=True),
        text("   "),
        "sep=;\n" + text(";"),
        "# a logger's\n% name\n" + text().replace("0.01", "# on the way\n0.01"),
        "# nothing\n" + text(head="# t,q,u"),
        text(head="# t,q,u").replace(",", " "),
        text(head="t,q,u\ns,rad,V"),
        text().replace(",", " , ").replace("\n", "\r\n\r\n"),
        text(head='"t","q","u"').replace("1\n", "True\n").replace("0\n", "False\n"),
        "\ufeff" + text(head="t,q,u,").replace("1\n", "1,\n").replace("0\n", "0,\n"),
        text(head="t,q,u,note").replace("1\n", "1,up\n").replace("0\n", "0,down\n"),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "latin-1"])
def test_tables_as_others_write_them(tmp_path: Path, content: str, encoding: str) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes(content.replace("\ufeff", "\ufeff" if encoding == "utf-8" else "").encode(encoding))
    found = read_columns(path, ["t", "q", "u"])
    assert [list(column) for column in found.values()] == [[0.0, 0.01, 0.02], [0.5, -0.25, 1.0], [1.0, 0.0, 1.0]]


def test_names_in_other_alphabets_and_names_like_paths(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(text(head="t.s,winkel [°],pos[0]").encode("latin-1"))
    found = read_columns(path, ["t.s", "winkel [°]", "pos[0]"])
    assert [column[2] for column in found.values()] == [0.02, 1.0, 1.0]


def test_a_table_without_names_has_numbers(tmp_path: Path) -> None:
    path = tmp_path / "a.dat"
    path.write_text(text(" ").partition("\n")[2])
    assert list(read_columns(path, ["[1]"])["[1]"]) == [0.5, -0.25, 1.0]
    with pytest.raises(LogError, match=r"no field 't'.*\[0\] to \[2\], as it does not name its columns"):
        read_columns(path, ["t"])


def test_dates_are_seconds(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(
        "t\n2026-01-02T00:00:00.5Z\n2026-01-02 01:00:01+01:00\n2026-01-02T00:00:01.25\n2026-99-02T00:00:01\n"
    )
    found = read_columns(path, ["t"])["t"]
    assert list(np.diff(found[:3])) == [0.5, 0.25] and found[0] % 86400 == 0.5 and np.isnan(found[3])


def test_a_table_that_was_cut_has_all_whole_rows(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text() + "0.03,1")
    with pytest.warns(LogWarning, match="ends within row 4"):
        assert len(read_columns(path, ["t"])["t"]) == 3
    path.write_text(text().replace("0.01,", ""))
    with pytest.raises(LogError, match="row 2: 2 cells for the 3 columns"):
        read_columns(path, ["t"])


def test_arrays_of_numpy(tmp_path: Path) -> None:
    values = np.arange(6.0).reshape(3, 2)
    np.savez_compressed(tmp_path / "a.npz", t=values[:, 0], q=values)
    np.save(tmp_path / "b.npy", values)
    np.save(tmp_path / "c.npy", np.array([{}], dtype=object), allow_pickle=True)
    assert list(read_columns(tmp_path / "a.npz", ["q[1]"])["q[1]"]) == [1, 3, 5]
    assert list(read_columns(tmp_path / "b.npy", ["[0]"])["[0]"]) == [0, 2, 4]
    with pytest.raises(LogError, match="no NumPy file of numbers"):
        read_columns(tmp_path / "c.npy", ["[0]"])
    with pytest.raises(LogError, match="'p' is none of q, t"):
        read_columns(tmp_path / "a.npz", ["p"])


def test_hdf5_and_what_matlab_writes_as_it(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    values = np.arange(6.0).reshape(3, 2)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["run/q"] = values
    assert list(read_columns(tmp_path / "a.h5", ["run.q[1]"])["run.q[1]"]) == [1, 3, 5]
    with h5py.File(tmp_path / "b.mat", "w", userblock_size=512) as file:
        file["run/q"], file["t"] = values.T, values[None, :, 0]
    content = (tmp_path / "b.mat").read_bytes()
    (tmp_path / "b.mat").write_bytes(b"MATLAB 7.3 MAT-file, of a test".ljust(512) + content[512:])
    found = read_columns(tmp_path / "b.mat", ["t", "run.q[1]"])
    assert [list(column) for column in found.values()] == [[0, 2, 4], [1, 3, 5]]
    (tmp_path / "c.h5").write_bytes(content[512:600])
    with pytest.raises(LogError, match="no HDF5 file"):
        read_columns(tmp_path / "c.h5", ["t"])


def parameter(name: str, group: int, kind: int, shape: tuple[int, ...], data: bytes) -> bytes:
    body = struct.pack("bB", kind, len(shape)) + bytes(shape) + data + b"\0"  # no description
    return struct.pack("bb", len(name), group) + name.encode() + struct.pack("<H", len(body) + 2) + body


def group(name: str, number: int) -> bytes:
    return struct.pack("bb", len(name), -number) + name.encode() + struct.pack("<H", 3) + b"\0"


def c3d(frames: np.ndarray, scale: float) -> bytes:
    """Frames (n, 2, 4) of two points, with two analog samples of one channel per frame that count up."""
    tree = b"\1\x50\2\x54" + group("POINT", 1) + group("ANALOG", 2)
    tree += parameter("SCALE", 1, 4, (), struct.pack("<f", scale)) + parameter(
        "RATE", 1, 4, (), struct.pack("<f", 50.0)
    )
    tree += parameter("LABELS", 1, -1, (4, 2), b"tip root")
    tree += parameter("USED", 2, 2, (), struct.pack("<h", 1)) + parameter("SCALE", 2, 4, (1,), struct.pack("<f", 0.5))
    tree += parameter("OFFSET", 2, 2, (1,), struct.pack("<h", 1)) + parameter(
        "GEN_SCALE", 2, 4, (), struct.pack("<f", 2)
    )
    tree = (tree + b"\0\0").ljust(1024, b"\0")
    head = struct.pack("<BBHHHHHfH", 2, 0x50, 2, 2, 1, len(frames), 0, scale, 4).ljust(512, b"\0")
    kind = "<f4" if scale < 0 else "<i2"
    count = np.arange(2 * len(frames)).reshape(-1, 2)
    rows = np.concatenate([frames.reshape(len(frames), 8), count], axis=1).astype(kind)
    return head + tree + rows.tobytes()


@pytest.mark.parametrize("scale", [-1.0, 0.1])
def test_c3d_points_and_analog(tmp_path: Path, scale: float) -> None:
    frames = np.arange(24.0).reshape(3, 2, 4)
    frames[1, 0, 3] = -1  # not seen
    path = tmp_path / "a.c3d"
    path.write_bytes(c3d(frames, scale))
    found = read_columns(path, ["time", "points.tip[2]", "points.root[0]", "analog.1"])
    unit = 1.0 if scale < 0 else scale
    assert found["time"] == pytest.approx([0, 0.02, 0.04])
    assert found["points.root[0]"] == pytest.approx(unit * frames[:, 1, 0])
    assert found["points.tip[2]"] == pytest.approx([2 * unit, np.nan, 18 * unit], nan_ok=True)
    assert found["analog.1"] == pytest.approx([-0.5, 1.5, 3.5])  # (mean - 1) 0.5 2


@pytest.mark.parametrize("cut", [0, 1, 600, 1500])
def test_a_torn_c3d_file_is_an_error(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "a.c3d"
    path.write_bytes(c3d(np.zeros((3, 2, 4)), -1.0)[:cut])
    with pytest.raises(LogError, match="no C3D"):
        read_columns(path, ["time"])
