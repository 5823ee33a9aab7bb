"""Any MJCF file with a channel map as a system."""

from boom_mj.systems.mjcf.channel_map import ChannelMap as ChannelMap
from boom_mj.systems.mjcf.channel_map import load_channel_map as load_channel_map
from boom_mj.systems.mjcf.export import tables as tables
from boom_mj.systems.mjcf.load import load_mjcf as load_mjcf
from boom_mj.systems.mjcf.system import MjcfSystem as MjcfSystem
