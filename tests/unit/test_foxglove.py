"""The layout for Foxglove shows topics and fields that twins have, as readers that are not ours find them."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from boom_mj.cli import run

ROOT = Path(__file__).parents[2]
LAYOUT = json.loads((ROOT / "docs" / "how-to" / "foxglove" / "diagnosis.json").read_text())
SERIES = [path["value"] for name, panel in LAYOUT["configById"].items() for path in panel.get("paths", ())]


@pytest.fixture(scope="module")
def twin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("foxglove")
    assert run(["simulate", "boom36", "slew_t", "-o", str(folder / "log.mcap")]) == 0
    assert run(["replay", str(folder / "log.mcap"), "-o", str(folder / "twin.mcap"), "--residual"]) == 0
    return folder / "twin.mcap"


def value_of(message: Any, path: str) -> float:
    for name, index in re.findall(r"\.(\w+)(?:\[(\d+)\])?", path):
        message = getattr(message, name)
        message = message[int(index)] if index else message
    return float(message)


def panels(place: Any) -> Iterator[str]:
    if isinstance(place, str):
        yield place
    else:
        yield from panels(place["first"])
        yield from panels(place["second"])


def test_every_panel_has_its_settings() -> None:
    assert sorted(panels(LAYOUT["layout"])) == sorted(LAYOUT["configById"])


def test_every_series_is_in_a_twin(twin: Path) -> None:
    found: dict[str, list[float]] = {}
    with twin.open("rb") as stream:
        for _, channel, _, message in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            for path in SERIES:
                topic, _, field = path.partition(".")
                if topic == channel.topic:
                    found.setdefault(path, []).append(value_of(message, f".{field}"))
    assert set(found) == set(SERIES)
    for measured, simulated, left in zip(SERIES[::3], SERIES[1::3], SERIES[2::3]):
        difference = np.array(found[measured]) - np.array(found[simulated])
        np.testing.assert_allclose(found[left], difference, atol=1e-9)


def test_what_is_shown_in_space_is_there_for_another_reader(twin: Path) -> None:
    shown = set(LAYOUT["configById"]["3D!boom"]["topics"]) | {"/tf"}
    with AnyReader([twin], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        connections = [c for c in reader.connections if c.topic in shown]
        read = {}
        for connection, _, data in reader.messages(connections):
            read.setdefault(connection.topic, reader.deserialize(data, connection.msgtype))
    assert set(read) == shown
    frames = {t.child_frame_id for t in read["/tf"].transforms}
    assert {marker.header.frame_id for marker in read["/scene"].markers} <= frames
    assert read["/markers"].header.frame_id == LAYOUT["configById"]["3D!boom"]["followTf"] == "world"
