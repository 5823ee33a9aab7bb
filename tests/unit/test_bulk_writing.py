"""Logs written in bulk are byte for byte those of the mcap library's own writer, fed with one message at a time."""

from pathlib import Path

import numpy as np
import pytest
import zstandard
from mcap.writer import CompressionType, Writer

from boom_mj.logs import write_mcap
from boom_mj.logs.container import LEVEL
from boom_mj.logs.messages import make, typestore
from boom_mj.logs.scene import TYPES, frames, shapes
from boom_mj.logs.serialising import serialise, stamp_of
from boom_mj.logs.topics import METADATA, TOPICS
from boom_mj.recording import QUANTITIES, Recording, Scene, named_signal

RATES = {"imu/": 200.0, "joint_command": 20.0, "cylinder": 25.0}  # Hz; of signals that share messages


def recording(seed: int) -> Recording:
    """All signals, with hidden markers, negative zeros and numbers that look like stamps."""
    rng, signals = np.random.default_rng(seed), {}
    for name, quantity in QUANTITIES.items():
        time = np.arange(1, 700) / next((hz for start, hz in RATES.items() if name.startswith(start)), 40.0)
        values = rng.normal(size=(time.size, len(quantity.channels) or 9)) * 10.0 ** rng.integers(-300, 300)
        values[::7] = -0.0
        if quantity.points:
            values[rng.random(time.size) < 0.2] = np.nan
        signals[name] = named_signal(name, time, values)
    return Recording("mixed", "boom36", "a description", signals)


def scene() -> Scene:
    rng, time = np.random.default_rng(5), np.arange(40) / 20
    shape = tuple(rng.normal(size=(3 * k, 3)) for k in range(3))
    position, quaternion = rng.normal(size=(40, 3, 3)), rng.normal(size=(40, 3, 4))
    return Scene(time, ("a", "longer", "c"), position, quaternion, shape, (1.0, 0.5, 0.0))


def one_by_one(log: Recording, moving: Scene, extra: list, path: Path, variance: dict[str, float]) -> None:
    """The same log by the library's writer and a message at a time."""
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library="boom_mj")
        labels = {"name": log.name, "machine": log.machine, "description": log.description}
        writer.add_metadata(METADATA, labels)
        types = {topic.name: topic.kind.ros_type for topic in TOPICS} | TYPES
        schemas, channels = {}, {}

        def register(wanted: dict[str, str]) -> None:
            for kind in dict.fromkeys(wanted.values()):
                definition = typestore().generate_msgdef(kind, ros_version=2)[0].encode()
                schemas[kind] = writer.register_schema(kind, "ros2msg", definition)
            for name, kind in wanted.items():
                channels[name] = writer.register_channel(name, "cdr", schemas[kind])

        register(types)
        entries = []
        for order, topic in enumerate(TOPICS):
            rows = {field: log[name] for field, name in topic.signals.items()}
            noise = {field: variance[name] for field, name in topic.signals.items() if name in variance}
            time = next(iter(rows.values())).time
            for i, stamp in enumerate(np.round(time * 1e9).astype(np.int64).tolist()):
                header = make("std_msgs/msg/Header", stamp=stamp_of(stamp), frame_id=topic.frame_id)
                row = {field: signal.values[i] + 0.0 for field, signal in rows.items()}
                entries.append(
                    (stamp, order, i, topic.name, topic.kind.pack(header, topic.channels, row, noise)),
                )
        pack, stamps, numbers = frames(moving)
        for i, (stamp, row) in enumerate(zip(stamps.tolist(), numbers)):
            entries.append((stamp, len(TOPICS), i, "/tf", pack(stamp_of(stamp), row)))
        stamp, name, message = shapes(moving)
        writer.add_message(channels[name], stamp, serialise(message), stamp, 0)
        for stamp, _, i, name, message in sorted(entries, key=lambda entry: entry[:3]):
            writer.add_message(channels[name], stamp, serialise(message), stamp, i)
        register({extra[0][1]: extra[0][2].__msgtype__})
        for i, (stamp, name, message) in enumerate(extra):
            writer.add_message(channels[name], stamp, serialise(message), stamp, i)
        writer.finish()


@pytest.mark.parametrize("seed", range(3))
def test_bulk_and_one_by_one_agree_to_the_byte(seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log, moving = recording(seed), scene()
    variance = {"imu/link3/angular_rate": 1e-6, "imu/link2/specific_force": 0.25}
    image = np.random.default_rng(seed).integers(0, 256, 400_000).astype(np.uint8)
    header = make("std_msgs/msg/Header", stamp=stamp_of(7), frame_id="camera")
    picture = make("sensor_msgs/msg/CompressedImage", header=header, format="png", data=image)
    extra = [(stamp, "/camera", picture) for stamp in (7, 8, 10**9, 10**9 + 1, 3, 4)]
    monkeypatch.setattr("mcap.writer.zstandard", zstandard.ZstdCompressor(LEVEL))
    one_by_one(log, moving, extra, tmp_path / "slow.mcap", variance)
    for block in (97, 1_000_000):
        monkeypatch.setattr("boom_mj.logs.writing.BLOCK", block)
        write_mcap(log, tmp_path / "bulk.mcap", variance=variance, scene=moving, also=iter(extra))
        assert (tmp_path / "bulk.mcap").read_bytes() == (tmp_path / "slow.mcap").read_bytes()
