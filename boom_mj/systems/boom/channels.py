"""Where a boom's channels belong: sensor, link and direction."""

from boom_mj.recording import QUANTITIES
from boom_mj.replay.comparison import boom_group
from boom_mj.systems.system import ChannelPlace

SENSORS = {"specific_force": "accelerometer", "angular_rate": "gyroscope"}


def channel_place(signal: str, column: int) -> ChannelPlace:
    """Of a signal's column."""
    channel = QUANTITIES[signal].channels[column]
    group = boom_group(signal, channel)
    if group.startswith("imu/"):
        _, link, kind, direction = group.split("/")
        sensor = SENSORS[kind]
    elif group.startswith("markers/"):
        _, link, direction = group.split("/")
        sensor = "marker"
    else:
        sensor, link, direction = "cylinder", "link" + group[-1], "force"
    device = "/".join(group.split("/")[:2]) if sensor in SENSORS.values() else f"{signal}/{channel.partition('/')[0]}"
    place = f"cylinder {link[-1]}" if sensor == "cylinder" else f"{sensor}, link {link[-1]}"
    return ChannelPlace(group, sensor, link, direction, f"{place}, {direction}", place, device)
