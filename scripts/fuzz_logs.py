"""Breaks logs of every format in 10 000 ways and counts how reading ends; prints the table of docs/logs.md.

    python scripts/fuzz_logs.py [--files 10000] [--seed 1]

Every broken file is read by `read_log` and looked into by `inspect_log`; anything but a recording or a LogError that
names the file is a crash, printed with what made it, and the exit status is 1.
"""

import argparse
import contextlib
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests" / "unit"))

import foreign  # noqa: E402

from boom_mj.errors import LogError  # noqa: E402
from boom_mj.logs import load_topic_map, read_log  # noqa: E402
from boom_mj.logs.inspection import inspect_log  # noqa: E402
from boom_mj.logs.proposal import propose_map  # noqa: E402

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


def outcome(path: Path, topic_map: object) -> str:
    """How reading a file ends: read, read with a warning, a clear error, or a crash."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            read_log(path, topic_map)
            result = "read with a warning" if told else "read"
        except LogError as error:
            result = "clear error" if path.name in str(error) else "crash"
        with contextlib.suppress(LogError):
            propose_map(inspect_log(path))
    return result


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


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--files", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    counts: dict[str, Counter] = {}
    with tempfile.TemporaryDirectory() as folder:
        wholes = []
        for i, writer in enumerate(w for w in foreign.WRITERS if w is not foreign.from_ros2_bag):
            (place := Path(folder) / str(i)).mkdir()
            path = writer(place)
            (place / "map.toml").write_text(propose_map(inspect_log(path)).replace('?"', '"'))
            for log in (path, unprotected(path)) if path.suffix == ".mcap" else (path,):
                wholes.append((log, log.read_bytes(), load_topic_map(place / "map.toml")))
        for number in range(options.files):
            path, content, topic_map = wholes[number % len(wholes)]
            harm = HARMS[(number // len(wholes)) % len(HARMS)]
            path.write_bytes(broken(content, harm, rng))
            try:
                result = outcome(path, topic_map)
            except Exception:
                result = "crash"
                print(f"file {number}, {path.name}, {harm}:\n{traceback.format_exc()}", file=sys.stderr)
            counts.setdefault(path.name, Counter())[result] += 1
    columns = ("clear error", "read with a warning", "read", "crash")
    print("| log | files | " + " | ".join(columns) + " |\n|" + "---|" * (len(columns) + 2))
    for name, count in [*counts.items(), ("all", sum(counts.values(), Counter()))]:
        print(f"| {name} | {count.total()} | " + " | ".join(str(count[column]) for column in columns) + " |")
    return 1 if any(count["crash"] for count in counts.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
