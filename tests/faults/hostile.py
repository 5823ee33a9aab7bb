"""Files made to do harm: bombs, false lengths, names that lead out of the folder, pickles; each with a name."""

import gzip
import io
import json
import os
import pickle
import struct
import zlib
from collections.abc import Iterator

import lz4.frame
import numpy as np
import zstandard
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC
from scipy.io import savemat

CANARY = "unpickled"  # a file that appears if a pickle is loaded
ZEROS = 2**29  # bytes of what bombs inflate to, twice what a small log may


class Evil:
    """Unpickling it leaves a file."""

    def __reduce__(self) -> tuple:
        return os.system, (f"touch {CANARY}",)


def pickles() -> Iterator[tuple[str, bytes]]:
    yield "pickle", pickle.dumps(Evil())
    stream = io.BytesIO()
    np.save(stream, np.array([Evil()], object), allow_pickle=True)
    yield "npy of objects", stream.getvalue()
    stream = io.BytesIO()
    np.savez(stream, a=np.array([Evil()], object))
    yield "npz of objects", stream.getvalue()


def nothing() -> Iterator[tuple[str, bytes]]:
    """What is no file of any kind."""
    yield "empty", b""
    yield "zeros", bytes(4096)
    yield "newlines", b"\n" * 4096
    yield "random", np.random.default_rng(0).bytes(4096)
    yield "byte order mark", b"\xff\xfe\x00"
    yield from pickles()


def _record(opcode: int, content: bytes, length: int | None = None) -> bytes:
    return struct.pack("<BQ", opcode, len(content) if length is None else length) + content


def _chunk(content: bytes, compression: bytes, size: int) -> bytes:
    head = struct.pack("<QQQII", 0, 10**9, size, 0, len(compression)) + compression + struct.pack("<Q", len(content))
    return MCAP0_MAGIC + _record(Opcode.CHUNK, head + content) + _record(Opcode.DATA_END, bytes(4)) + MCAP0_MAGIC


def _text(text: bytes) -> bytes:
    return struct.pack("<I", len(text)) + text


def mcaps() -> Iterator[tuple[str, bytes]]:
    zeros = bytes(2**20)
    blocks = ZEROS // len(zeros)
    packer = zstandard.ZstdCompressor(19).compressobj()
    zstd = b"".join(packer.compress(zeros) for _ in range(blocks)) + packer.flush()
    maker = lz4.frame.LZ4FrameCompressor()
    lz = maker.begin() + b"".join(maker.compress(zeros) for _ in range(blocks)) + maker.flush()
    yield "zstd bomb", _chunk(zstd, b"zstd", ZEROS)
    yield "zstd bomb that says it is small", _chunk(zstd, b"zstd", 1000)
    yield "zstd bomb that says it is huge", _chunk(zstd, b"zstd", 2**62)
    yield "lz4 bomb", _chunk(lz, b"lz4", ZEROS)
    yield "unknown compression", _chunk(b"abc", b"\x1b[31mred", 3)
    yield "no end", MCAP0_MAGIC
    for length in (2**63, 2**64 - 1, 2**31):
        yield f"record of {length} bytes", MCAP0_MAGIC + _record(Opcode.MESSAGE, b"abc", length) + MCAP0_MAGIC
    schema = struct.pack("<H", 1) + _text(b"sensor_msgs/msg/JointState") + _text(b"ros2msg")
    channel = struct.pack("<HH", 1, 1) + _text(b"/joint_states") + _text(b"cdr") + struct.pack("<I", 0)
    ends = _record(Opcode.DATA_END, bytes(4)) + MCAP0_MAGIC
    for name, text in (
        ("schema of itself", b"sensor_msgs/JointState again\n"),
        ("schema of huge array", b"float64[4000000000] position\n"),
        ("schema of nonsense", b"\x00\xff" * 100),
        ("schema of a megabyte", b"float64 a\n" * 100_000),
    ):
        message = struct.pack("<HIQQ", 1, 0, 0, 0) + b"\x00\x01\x00\x00" + b"\xff" * 64
        head = _record(Opcode.SCHEMA, schema + _text(text)) + _record(Opcode.CHANNEL, channel)
        yield name, MCAP0_MAGIC + head + _record(Opcode.MESSAGE, message) + ends
    topic = _text(b"/\x1b]0;title\x07" + b"x" * 100_000)
    rude = struct.pack("<HH", 1, 0) + topic + _text(b"json") + struct.pack("<I", 0)
    deep = struct.pack("<HIQQ", 1, 0, 0, 0) + b'{"a":' + b"[" * 100_000
    yield "rude topic, deep JSON", MCAP0_MAGIC + _record(Opcode.CHANNEL, rude) + _record(Opcode.MESSAGE, deep) + ends
    named = struct.pack("<HH", 1, 0) + _text(b"/joint_states") + _text(b"json") + struct.pack("<I", 0)
    yield "deep JSON", MCAP0_MAGIC + _record(Opcode.CHANNEL, named) + _record(Opcode.MESSAGE, deep) + ends
    yield "metadata of false count", MCAP0_MAGIC + _record(Opcode.METADATA, _text(b"experiment") + b"\xff" * 8) + ends


def tables() -> Iterator[tuple[str, bytes]]:
    head = b"time_s,q1_rad,q2_rad,q3_rad,q4_rad,q5_rad,note\n"
    yield "field of 200 kB", head + b"0," + b"1" * 200_000 + b",0,0,0,0,a\n"
    yield "line of 3 MB", head + b"0" * 3_000_000
    yield "quote without end", head + b'0,"1,2,3\n' * 50_000
    yield "bytes of 0", head + b"0,\x00,0,0,0,0,a\n" * 3
    yield "not UTF-8", head + b"0,\xff\xfe,0,0,0,0,a\n" * 3
    yield "huge numbers", head + b"".join(b"%d,1e308,-1e308,1e999,0,0,a\n" % k for k in range(20))
    yield "not numbers", head + b"".join(b"%d,nan,nan,nan,nan,nan,a\n" % k for k in range(20))
    yield "times back and forth", head + b"".join(b"%d,0,0,0,0,0,a\n" % (k % 3) for k in range(20))
    yield "one sample a century", head + b"".join(b"%d,0,0,0,0,0,a\n" % (k * 10**9) for k in range(20))
    yield "20 000 columns", b",".join(b"c%d" % k for k in range(20_000)) + b"\n" + b",".join([b"0"] * 20_000) + b"\n"
    yield "lists of lists", head + b"0," + b"[" * 100_000 + b",0,0,0,0,a\n"


def packed_tables() -> Iterator[tuple[str, bytes]]:
    packer = zlib.compressobj(9, wbits=31)
    yield "gzip bomb", b"".join(packer.compress(bytes(2**20)) for _ in range(ZEROS // 2**20)) + packer.flush()
    packer, rows = zlib.compressobj(9, wbits=31), b"0,0,0,0,0,0,a\n" * 70_000
    head = packer.compress(b"time_s,q1_rad,q2_rad,q3_rad,q4_rad,q5_rad,note\n")
    yield (
        "gzip bomb of rows",
        head + b"".join(packer.compress(rows) for _ in range(ZEROS // len(rows))) + packer.flush(),
    )
    yield "gzip cut off", gzip.compress(rows)[:-20]


def bags() -> Iterator[tuple[str, bytes]]:
    yield "head without body", b"#ROSBAG V2.0\n"
    yield "false lengths", b"#ROSBAG V2.0\n" + b"\xff" * 100


def matlab() -> Iterator[tuple[str, bytes]]:
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x0100) + b"IM"
    packer = zlib.compressobj(9)
    bomb = packer.compress(struct.pack("<II", 14, 2**31 - 1))
    bomb += b"".join(packer.compress(bytes(2**20)) for _ in range(ZEROS // 2**20)) + packer.flush()
    yield "zlib bomb", head + struct.pack("<II", 15, len(bomb)) + bomb
    yield "false length", head + struct.pack("<II", 15, 2**32 - 1) + b"abc"
    size = struct.pack("<IIII", 6, 8, 6, 0) + struct.pack("<IIii", 5, 8, 2**31 - 1, 2**31 - 1)
    yield "huge matrix", head + struct.pack("<II", 14, len(size) + 32) + size + struct.pack("<II", 1, 1) + bytes(24)
    yield "version 4, huge", struct.pack("<IIIII", 0, 2**31 - 1, 2**31 - 1, 0, 2) + b"t\x00" + bytes(100)
    yield "HDF5", b"\x89HDF\r\n\x1a\n" + bytes(500)
    stream = io.BytesIO()
    savemat(stream, {"time": np.array(["a", "b"], object), "angle": np.zeros((3, 3, 3)), "torque": 1j * np.ones(3)})
    yield "texts, cubes, complex numbers", stream.getvalue()


def tomls(whole: str) -> Iterator[tuple[str, bytes]]:
    yield "deep lists", b"a = " + b"[" * 100_000
    yield "deep tables", b".".join([b"a"] * 20_000) + b" = 1\n"
    yield "huge number", b"a = " + b"9" * 100_000 + b"\n"
    yield "two megabytes", b"# " + b"x" * 2_000_000 + b"\n"
    yield "5000 unknown keys", b"".join(b"k%d = 1\n" % k for k in range(5000))
    yield "unknown key of a megabyte", b"k" * 900_000 + b' = "v"\n'
    yield "not UTF-8", whole.encode() + b"# \xff\n"
    yield "control characters", whole.encode() + b'"\\u001b[2J" = "\\u0007"\n'
    yield "twice the same", whole.encode() * 2
    yield "a list of it", b"[[x]]\n" * 1000


def xmls() -> Iterator[tuple[str, bytes]]:
    """MJCF files; `outside.xml` and `outside.png` lie beside the folder."""

    def model(*parts: str, world: str = '<body><joint name="swing"/><geom size="1"/></body>') -> bytes:
        return f"<mujoco>{''.join(parts)}<worldbody>{world}</worldbody></mujoco>".encode()

    laughs = "".join(f'<!ENTITY l{k} "{f"&l{k - 1};" * 10 if k else "lol"}">' for k in range(10))
    yield "billion laughs", f"<!DOCTYPE m [{laughs}]><mujoco>&l9;</mujoco>".encode()
    yield "entity of a file", b'<!DOCTYPE m [<!ENTITY x SYSTEM "file:///etc/passwd">]><mujoco>&x;</mujoco>'
    yield "include above", model('<include file="../outside.xml"/>')
    yield "include absolute", model('<include file="/etc/passwd"/>')
    yield "include itself", model('<include file="model.xml"/>')
    yield "include missing", model('<include file="nowhere.xml"/>')
    yield "mesh above", model('<asset><mesh file="../outside.stl"/></asset>')
    yield "mesh folder above", model('<compiler meshdir="../.."/><asset><mesh file="outside.stl"/></asset>')
    yield "texture absolute", model('<asset><texture type="2d" file="/etc/passwd"/></asset>')
    yield "height field above", model('<asset><hfield file="../../x.png" size="1 1 1 1"/></asset>')
    yield "model above", model('<asset><model file="../outside.xml"/></asset>')
    yield "link that leads out", model('<include file="link.xml"/>')
    yield "mesh that is none", model('<asset><mesh file="model.xml"/></asset>')
    many = '<replicate count="1000000000"><body><geom size="1"/></body></replicate>'
    yield "a billion copies", model(world=many)
    nested = '<replicate count="1000">' * 4 + '<geom size="1"/>' + "</replicate>" * 4
    yield "copies of copies", model(world=nested)
    yield "deep bodies", b"<mujoco><worldbody>" + b"<body>" * 50_000
    yield "deep closed bodies", model(world="<body>" * 3000 + "</body>" * 3000)
    huge = '<texture name="t" type="2d" builtin="flat" width="1000000" height="1000000"/>'
    yield "huge texture", model(f"<asset>{huge}</asset>")
    yield "png bomb", model('<asset><texture type="2d" file="bomb.png"/></asset>')
    yield "huge height field", model('<asset><hfield nrow="100000" ncol="100000" size="1 1 1 1"/></asset>')
    yield "memory", model('<size memory="4000G"/>')
    yield "user data", model('<size nuserdata="2000000000"/>')
    yield "negative mass", model(world='<body><joint name="swing"/><geom size="1" mass="-1"/></body>')
    yield "not numbers", model(world='<body><joint name="swing"/><geom size="nan" mass="inf"/></body>')
    yield "no step", model('<option timestep="0"/>')
    yield "tiny step", model('<option timestep="1e-12"/>')
    yield "plugin", model('<extension><plugin plugin="../../evil.so"/></extension>')
    yield "control characters", b"<mujoco>\x1b[2J</mujoco>"
    yield "nothing moves", model(world='<geom size="1"/>')
    yield "another kind", b"<html><body>hello</body></html>"


def png_bomb(side: int = 30_000) -> bytes:
    """A picture of almost a thousand million pixels in a megabyte."""

    def part(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    packer = zlib.compressobj(9)
    rows = b"".join(packer.compress(bytes(side + 1)) for _ in range(side)) + packer.flush()
    head = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + part(b"IHDR", head) + part(b"IDAT", rows) + part(b"IEND", b"")


def datasets(whole: dict) -> Iterator[tuple[str, bytes]]:
    """Descriptions of folders of pictures."""

    def changed(**changes: object) -> bytes:
        return json.dumps({**whole, **changes}).encode()

    frame = whole["frames"][0]
    for name, file in (
        ("picture above", "../outside.png"),
        ("picture absolute", "/etc/passwd"),
        ("picture by a link", "link/passwd"),
        ("picture missing", "nowhere.png"),
        ("picture that is none", "dataset.json"),
        ("picture that is a folder", "images"),
        ("png bomb", "bomb.png"),
        ("name of a megabyte", "x" * 1_000_000),
        ("name with a zero", "a\x00b"),
    ):
        yield name, changed(calibration=[{**frame, "file": file}, *whole["calibration"]])
    plate = {**whole["plates"][0], "picture": "../outside.png"}
    yield "plate above", changed(plates=[plate, *whole["plates"][1:]])
    yield "deep JSON", b'{"name":' + b"[" * 200_000
    yield "no cameras", changed(cameras=[])
    yield "no plates", changed(plates=[], lateral=[])
    yield "cameras twice", changed(cameras=[whole["cameras"][0]] * 2)
    yield "camera of other size", changed(cameras=[{**c, "width": 10**9} for c in whole["cameras"]])
    yield "board of a billion corners", changed(chequerboard={"corners": [10**9, 10**9], "square": 0.1})
    yield "stamps that are none", changed(frames=[{**f, "stamp": float("nan")} for f in whole["frames"]])
    yield "half", changed()[:-100]


def jsons(whole: object) -> Iterator[tuple[str, bytes]]:
    """Documents of the wrong kind."""
    for label, value in (("list", []), ("text", "x"), ("number", 1e400), ("nothing", None), ("no keys", {})):
        yield label, json.dumps(value).encode()
    yield "deep", b"[" * 200_000
    text = json.dumps(whole)
    for old, new in (
        ('"effects": [', '"effects": [7, '),
        ('"id"', '"di"'),
        ('"class"', '"ssalc"'),
        ('"low": 49.0', '"low": "x"'),
        ('"gap": {', '"gap": 3, "pag": {'),
        ('"without": [', '"without": 5, "x": ['),
        ('"cases": {', '"cases": [], "x": {'),
        ('"verdict": "explained"', '"verdict": []'),
        ("50.0", "NaN"),
        ("51.0", "Infinity"),
    ):
        if old in text:
            yield f"{old} -> {new}", text.replace(old, new).encode()
