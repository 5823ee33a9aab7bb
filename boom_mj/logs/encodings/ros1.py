"""The encoding of ROS 1, turned into CDR message by message."""

from collections.abc import Iterator, Sequence
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from boom_mj.logs.channel import Channel, DecodingError, Group
from boom_mj.logs.encodings.cdr import CdrDecoder


class Ros1Decoder:
    """Messages of one ROS 1 channel -> groups.

    Raises:
        ValueError: a definition that cannot be read.
    """

    def __init__(self, channel: Channel) -> None:
        self._type = channel.type
        self._types = get_typestore(Stores.EMPTY)
        self._types.register(get_types_from_msg(channel.schema.decode(), channel.type))
        self._cdr = CdrDecoder(channel)

    def decode(self, messages: Sequence[bytes], fields: Sequence[str]) -> Iterator[Group]:
        yield from self._cdr.decode([self._convert(i, message) for i, message in enumerate(messages)], fields)

    def tree(self, message: bytes) -> Any:
        """A message with a `Leaf` for every number."""
        return self._cdr.tree(self._convert(0, message))

    def _convert(self, index: int, message: bytes) -> bytes:
        try:
            return bytes(self._types.ros1_to_cdr(message, self._type))
        except Exception as error:  # whatever broken bytes lead to
            raise DecodingError(index, error) from error
