"""Logs: recordings as MCAP files of ROS 2 messages, which the usual robotics tools open unaided."""

from boom_mj.logs.reading import read_mcap as read_mcap
from boom_mj.logs.writing import whole_file as whole_file
from boom_mj.logs.writing import write_mcap as write_mcap
