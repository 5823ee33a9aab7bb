"""Any machine that has an MJCF file, a log, and a channel map that says which field of the log is what."""

from boom_mj.systems.mjcf.channel_map import ChannelMap as ChannelMap
from boom_mj.systems.mjcf.channel_map import load_channel_map as load_channel_map
from boom_mj.systems.mjcf.load import corrected_model as corrected_model
from boom_mj.systems.mjcf.load import robot_campaign as robot_campaign
from boom_mj.systems.mjcf.load import twin_tables as twin_tables
from boom_mj.systems.mjcf.system import MjcfSystem as MjcfSystem
