"""Encodings of messages: one file each; a decoder turns the messages of a channel into columns of numbers."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import Any, Protocol

from boom_mj.logs.channel import Channel, Group
from boom_mj.logs.encodings.cdr import ROS1, CdrDecoder
from boom_mj.logs.encodings.json_text import json_decoder
from boom_mj.logs.encodings.protobuf import protobuf_decoder
from boom_mj.logs.encodings.row import RowDecoder


class Decoder(Protocol):
    """Decodes the messages of one channel."""

    def decode(self, messages: Sequence[Any], fields: Sequence[str]) -> Iterator[Group]:
        """Groups of messages that are laid out alike, with the numbers of the fields.

        Raises:
            DecodingError: a message that is not what its type says.
        """

    def tree(self, message: Any) -> Any:
        """One message as a tree of mappings, lists and leaves; see `boom_mj.logs.fields`."""


DECODERS: Mapping[str, Callable[[Channel], Decoder]] = MappingProxyType(
    {
        "cdr": CdrDecoder,
        "ros1": partial(CdrDecoder, rules=ROS1),
        "json": json_decoder,
        "protobuf": protobuf_decoder,
        "row": RowDecoder,
    }
)


def decoder_of(channel: Channel) -> Decoder:
    """Decoder of a channel.

    Raises:
        ValueError: an unknown encoding, or a type that the log does not define.
    """
    if channel.encoding not in DECODERS:
        raise ValueError(
            f"messages are {channel.type} in {channel.encoding or 'no encoding'}; readable are {', '.join(DECODERS)}"
        )
    try:
        return DECODERS[channel.encoding](channel)
    except ValueError:
        raise
    except Exception as error:  # the parsers of definitions have exceptions of their own
        raise ValueError(f"the definition of {channel.type} cannot be read: {error}") from error
