"""Reading and decoding a log: messages per second, against what rosbags alone takes, and memory for an hour.

Run: .venv/bin/python benchmarks/reading.py [--hour]

The log is the 300 s fold-in. rosbags alone: its reader with `deserialize_cdr` of every message, nothing kept. --hour
plays the fold-in twelve times into one log, 1.5 million messages, and reads it in a process of its own.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer
from rosbags.rosbag2 import Reader, StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore

from boom_mj.logs import read_log

ROOT = Path(__file__).parents[1]
LOG = ROOT / "logs" / "fold_in_300.mcap"
REPEATS = 3
HOUR = 3600  # s


def best(work) -> float:  # type: ignore[no-untyped-def]
    """Shortest of a few runs, s."""
    walls = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        work()
        walls.append(time.perf_counter() - began)
    return min(walls)


def rosbags_alone(path: Path) -> int:
    """Decode every message with rosbags; their number."""
    store, count = get_typestore(Stores.ROS2_HUMBLE), 0
    with Reader(path) as reader:
        for connection, _, data in reader.messages(reader.connections):
            store.deserialize_cdr(data, connection.msgtype)
            count += 1
    return count


def database(source: Path, target: Path) -> Path:
    """The same log as a ROS 2 bag in a database."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    with Reader(source) as reader, Ros2Writer(target, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        connections = {c.id: writer.add_connection(c.topic, c.msgtype, typestore=store) for c in reader.connections}
        for connection, log_time, data in reader.messages(reader.connections):
            writer.write(connections[connection.id], log_time, data)
    return target


def repeated(source: Path, target: Path, seconds: float) -> int:
    """A log that plays another one again and again, its stamps moved on; the number of messages."""
    with source.open("rb") as stream, target.open("wb") as out:
        rows = list(make_reader(stream).iter_messages())
        span = rows[-1][2].log_time - rows[0][2].log_time + 20_000_000
        writer, numbers, count = Writer(out), {}, 0
        writer.start("ros2", "benchmark")
        for schema, channel, _ in rows:
            if channel.id not in numbers:
                known = writer.register_schema(schema.name, schema.encoding, schema.data)
                numbers[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, known)
        for turn in range(int(seconds * 1e9 // span) + 1):
            for _, channel, message in rows:
                stamp = message.log_time + turn * span
                if stamp > seconds * 1e9:
                    break
                head = np.array(divmod(stamp, 10**9), "<u4").tobytes()
                data = message.data[:4] + head + message.data[12:]  # behind the encapsulation stands the stamp
                writer.add_message(numbers[channel.id], stamp, data, stamp)
                count += 1
        writer.finish()
    return count


def memory_of_reading(path: Path) -> tuple[float, float]:
    """Wall seconds and peak MB of reading a log in a process of its own."""
    done = subprocess.run([sys.executable, __file__, "--read", path], capture_output=True, text=True, check=True)
    wall, peak = map(float, done.stdout.split())
    return wall, peak


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hour", action="store_true")
    parser.add_argument("--read", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.read:
        began = time.perf_counter()
        read_log(options.read)
        print(time.perf_counter() - began, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
        return
    print("| log | messages | rosbags alone, messages/s | read_log, messages/s | ratio |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for path, name in ((LOG, "MCAP"), (database(LOG, Path(folder) / "bag"), "ROS 2 sqlite3 bag")):
            count = rosbags_alone(path)
            ours, theirs = best(partial(read_log, path)), best(partial(rosbags_alone, path))
            print(f"| {name} | {count} | {count / theirs:.0f} | {count / ours:.0f} | {theirs / ours:.1f} |")
        if options.hour:
            path = Path(folder) / "hour.mcap"
            count = repeated(LOG, path, HOUR)
            wall, peak = memory_of_reading(path)
            megabytes = path.stat().st_size / 1e6
            speed = f"{wall:.1f} s, {count / wall:.0f} messages/s"
            print(f"\n1 h, {count} messages, a file of {megabytes:.0f} MB: {speed}, peak memory {peak:.0f} MB")


if __name__ == "__main__":
    main()
