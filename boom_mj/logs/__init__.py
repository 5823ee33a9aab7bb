"""Recordings to and from files."""

from boom_mj.logs.mcap import read_mcap as read_mcap
from boom_mj.logs.mcap import whole_file as whole_file
from boom_mj.logs.mcap import write_mcap as write_mcap
