"""What happens to files: bytes cut off, flipped, overwritten, put in or taken out; other sizes, kinds and values."""

import os
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer

from boom_mj.logs import read_mcap, write_mcap
from boom_mj.recording import Recording, Signal

SPARSE = 2**34  # bytes of a file that is huge but takes no room
HARMS = ("cut", "flip", "fill", "reverse", "insert", "delete")


def broken(content: bytes, harm: str, rng: np.random.Generator) -> bytes:
    """The content with one to four places harmed."""
    data = bytearray(content)
    for _ in range(1 if harm == "cut" else rng.integers(1, 5)):
        place, length = int(rng.integers(len(data))), int(rng.integers(1, 33))
        end = min(place + length, len(data))
        if harm == "cut":
            del data[place:]
        elif harm == "flip":
            data[place] ^= int(rng.integers(1, 256))
        elif harm == "fill":
            data[place:end] = bytes([int(rng.choice([0, 1, 127, 255]))]) * (end - place)
        elif harm == "reverse":
            data[place:end] = data[place:end][::-1]
        elif harm == "insert":
            data[place:place] = rng.bytes(length)
        else:
            del data[place:end]
        if not data:
            break
    return bytes(data)


def unprotected(path: Path) -> Path:
    """The same MCAP without chunks and checksums, so that what is broken reaches the decoders."""
    bare = path.with_name(f"bare_{path.name}")
    with path.open("rb") as stream, bare.open("wb") as target:
        writer, numbers = Writer(target, use_chunking=False, enable_crcs=False), {}
        writer.start("", "foreign")
        for schema, channel, message in make_reader(stream).iter_messages():
            if channel.id not in numbers:
                known = writer.register_schema(schema.name, schema.encoding, schema.data)
                numbers[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, known)
            writer.add_message(numbers[channel.id], message.log_time, message.data, message.publish_time)
        writer.finish()
    return bare


def enlarge(path: Path) -> None:
    path.write_bytes(b"")
    os.truncate(path, SPARSE)


def extend(path: Path) -> None:
    os.truncate(path, SPARSE)


def make_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def make_loop(path: Path) -> None:
    path.unlink()
    path.symlink_to(path.name)


def with_value(line: str, value: str) -> str:
    """A line of TOML with its first number replaced."""
    key, _, rest = line.partition("=")
    head = rest[: len(rest) - len(rest.lstrip(" ["))]
    body = rest[len(head) :]
    end = next((k for k, c in enumerate(body) if c in ",] #"), len(body))
    return f"{key}={head}{value}{body[end:]}"


def write_nan(path: Path, which: str) -> None:
    log = read_mcap(path)
    signals = {}
    for name, s in log.signals.items():
        values = np.full_like(s.values, np.nan) if which in (name, "all") else s.values
        signals[name] = Signal(s.time, values, s.channels, s.unit, s.frame)
    try:
        write_mcap(Recording(log.name, log.machine, log.description, signals), path)
    except Exception:  # NaN are refused when written: put them into the bytes
        data = path.read_bytes()
        path.write_bytes(data[: len(data) // 2] + np.full(64, np.nan).tobytes() + data[len(data) // 2 :])
