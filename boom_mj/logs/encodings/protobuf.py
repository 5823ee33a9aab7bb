"""Protobuf messages, by the descriptors that the log carries."""

from typing import Any

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from google.protobuf.message import Message

from boom_mj.logs.channel import Channel
from boom_mj.logs.encodings.tree import TreeDecoder


def protobuf_decoder(channel: Channel) -> TreeDecoder:
    """Decoder of a channel of protobuf messages, such as foxglove.JointStates.

    Raises:
        ValueError: descriptors that cannot be read or lack the type.
    """
    try:
        files = descriptor_pb2.FileDescriptorSet.FromString(channel.schema)
        pool = descriptor_pool.DescriptorPool()
        for file in files.file:
            pool.Add(file)
        kind = message_factory.GetMessageClass(pool.FindMessageTypeByName(channel.type))
    except Exception as error:  # the library raises whatever the descriptors lead to
        raise ValueError(f"the log does not define the type {channel.type}: {error}") from error
    return TreeDecoder(lambda data: _tree(kind.FromString(data)))


def _tree(message: Message) -> dict[str, Any]:
    """Fields by name; optional ones that are not set are left out."""
    tree: dict[str, Any] = {}
    for field in message.DESCRIPTOR.fields:
        value = getattr(message, field.name)
        nested = field.message_type is not None
        if field.is_repeated:
            tree[field.name] = [_tree(element) for element in value] if nested else list(value)
        elif not field.has_presence or message.HasField(field.name):
            tree[field.name] = _tree(value) if nested else value
    return tree
