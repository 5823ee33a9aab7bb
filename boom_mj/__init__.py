"""Flexible large manipulators in MuJoCo: machine files, models, simulation, replay of logs, diagnosis of the gap."""

import boom_mj.engine  # noqa: F401  # isort: skip

from boom_mj.api import Answer, Cause, Estimate, diagnose
from boom_mj.effects import make_effect, parse_effect
from boom_mj.errors import BoomError
from boom_mj.logs import load_topic_map, read_log, read_mcap, write_mcap
from boom_mj.machine import Machine, load_machine
from boom_mj.mjcf import build
from boom_mj.recording import Recording, Signal
from boom_mj.reference import ReferenceModel, Simplifications
from boom_mj.replay import Replay, replay
from boom_mj.sensors import measure, record
from boom_mj.simulation import CATALOGUE, Experiment, Trajectory, load_experiment, make_plant, run_experiment

__all__ = [
    "CATALOGUE",
    "Answer",
    "BoomError",
    "Cause",
    "Estimate",
    "Experiment",
    "Machine",
    "Recording",
    "ReferenceModel",
    "Replay",
    "Signal",
    "Simplifications",
    "Trajectory",
    "build",
    "diagnose",
    "load_experiment",
    "load_machine",
    "load_topic_map",
    "make_effect",
    "make_plant",
    "measure",
    "parse_effect",
    "read_log",
    "read_mcap",
    "record",
    "replay",
    "run_experiment",
    "write_mcap",
]
