"""Compressed parts of logs, inflated within bounds: a few bytes can claim to be terabytes."""

import bz2
import zlib

import lz4.frame
import zstandard

FREE, RATIO = 2**27, 100  # bytes, and times its own size, to which a log may inflate


class InflationError(ValueError):
    """What inflates to more than a log of this size can hold."""


class Inflater:
    """Counts what the parts of one log inflate to.

    Args:
        size: of the log, bytes.
        ratio: times its size, to which it may inflate beyond `FREE` bytes.
    """

    def __init__(self, size: int, ratio: int = RATIO) -> None:
        self.ratio = ratio
        self.left = self.allowed = FREE + ratio * size

    def inflate(self, data: bytes, compression: str, size: int | None = None) -> bytes:
        """Content of a part; of a broken one what is there.

        Args:
            size: that it says it has; no more than one byte beyond it is inflated.

        Raises:
            InflationError: all parts together are larger than `FREE` bytes and so many times the log.
        """
        most = min(self.left, size if size is not None else self.left) + 1
        if compression == "":
            content = data
        elif compression == "zstd":
            content = zstandard.ZstdDecompressor().stream_reader(data, read_across_frames=True).read(most)
        elif compression == "lz4":
            content = bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, most))
        elif compression == "bz2":
            content = bz2.BZ2Decompressor().decompress(data, most)
        elif compression == "zlib":
            content = zlib.decompressobj().decompress(data, most)
        else:
            raise ValueError(f"compression {compression} is not supported; zstd, lz4, bz2 and none are")
        self.count(len(content))
        return content

    def count(self, size: int) -> None:
        """Count bytes that were inflated elsewhere."""
        self.left -= size
        if self.left < 0:
            raise InflationError(f"it inflates to more than {self.allowed} bytes, {self.ratio} times its size")
