"""What happens to files: bytes that are cut off, flipped, overwritten, reversed, put in or taken out."""

from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer

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
