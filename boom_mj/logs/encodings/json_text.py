"""JSON messages."""

import json
from typing import Any

from boom_mj.logs.channel import Channel
from boom_mj.logs.encodings.tree import TreeDecoder


def json_decoder(channel: Channel) -> TreeDecoder:
    """Decoder of a channel of JSON objects; null is a number that is not there."""
    return TreeDecoder(_tree)


def _tree(message: bytes) -> Any:
    tree = json.loads(message)
    if not isinstance(tree, dict):
        raise ValueError(f"a JSON {type(tree).__name__} instead of an object")
    return tree
