"""Where a boom's channels belong: sensor, link and direction."""

from boom_mj.recording import QUANTITIES
from boom_mj.systems.system import ChannelPlace

MARKERS_PER_LINK = 3
SENSORS = {"specific_force": "accelerometer", "angular_rate": "gyroscope"}


def group_of(signal: str, channel: str) -> str:
    """Channel group: sensor, link and direction, such as "markers/link4/z"."""
    if signal == "markers":
        number, axis = int(channel.partition("/")[0].removeprefix("marker")), channel[-1]
        return f"markers/link{2 + (number - 1) // MARKERS_PER_LINK}/{axis}"
    return channel if signal.startswith("cylinder") else f"{signal}/{channel}"


def channel_place(signal: str, column: int) -> ChannelPlace:
    """Of a signal's column."""
    group = group_of(signal, QUANTITIES[signal].channels[column])
    if group.startswith("imu/"):
        _, link, kind, direction = group.split("/")
        sensor = SENSORS[kind]
    elif group.startswith("markers/"):
        _, link, direction = group.split("/")
        sensor = "marker"
    else:
        sensor, link, direction = "cylinder", "link" + group[-1], "force"
    place = f"cylinder {link[-1]}" if sensor == "cylinder" else f"{sensor}, link {link[-1]}"
    return ChannelPlace(group, sensor, link, direction, f"{place}, {direction}", place)
