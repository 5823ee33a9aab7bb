"""Logs: recordings as MCAP files of ROS 2 messages, which the usual tools open unaided; logs from elsewhere."""

from boom_mj.logs.reading import read_log as read_log
from boom_mj.logs.reading import read_mcap as read_mcap
from boom_mj.logs.topic_map import load_topic_map as load_topic_map
from boom_mj.logs.writing import write_mcap as write_mcap
