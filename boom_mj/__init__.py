"""Flexible large manipulators in MuJoCo: machine files, models, simulation, replay of logs, diagnosis of the gap."""

from typing import TYPE_CHECKING

from boom_mj.doors import door

if TYPE_CHECKING:
    from boom_mj.api import Answer as Answer
    from boom_mj.api import Cause as Cause
    from boom_mj.api import Estimate as Estimate
    from boom_mj.api import LawAnswer as LawAnswer
    from boom_mj.api import diagnose as diagnose
    from boom_mj.api import discover as discover
    from boom_mj.effects import make_effect as make_effect
    from boom_mj.effects import parse_effect as parse_effect
    from boom_mj.errors import BoomError as BoomError
    from boom_mj.logs import load_topic_map as load_topic_map
    from boom_mj.logs import read_log as read_log
    from boom_mj.logs import read_mcap as read_mcap
    from boom_mj.logs import write_mcap as write_mcap
    from boom_mj.machine import Machine as Machine
    from boom_mj.machine import load_machine as load_machine
    from boom_mj.mjcf import build as build
    from boom_mj.recording import Recording as Recording
    from boom_mj.recording import Signal as Signal
    from boom_mj.reference import ReferenceModel as ReferenceModel
    from boom_mj.reference import Simplifications as Simplifications
    from boom_mj.replay import Replay as Replay
    from boom_mj.replay import replay as replay
    from boom_mj.sensors import measure as measure
    from boom_mj.sensors import record as record
    from boom_mj.simulation import CATALOGUE as CATALOGUE
    from boom_mj.simulation import Experiment as Experiment
    from boom_mj.simulation import Trajectory as Trajectory
    from boom_mj.simulation import load_experiment as load_experiment
    from boom_mj.simulation import make_plant as make_plant
    from boom_mj.simulation import run_experiment as run_experiment
else:  # the same, imported where it is asked for; a test holds both together
    __getattr__, __dir__, __all__ = door(
        __name__,
        {
            "boom_mj.api": ("Answer", "Cause", "Estimate", "LawAnswer", "diagnose", "discover"),
            "boom_mj.effects": ("make_effect", "parse_effect"),
            "boom_mj.errors": ("BoomError",),
            "boom_mj.logs": ("load_topic_map", "read_log", "read_mcap", "write_mcap"),
            "boom_mj.machine": ("Machine", "load_machine"),
            "boom_mj.mjcf": ("build",),
            "boom_mj.recording": ("Recording", "Signal"),
            "boom_mj.reference": ("ReferenceModel", "Simplifications"),
            "boom_mj.replay": ("Replay", "replay"),
            "boom_mj.sensors": ("measure", "record"),
            "boom_mj.simulation": (
                "CATALOGUE",
                "Experiment",
                "Trajectory",
                "load_experiment",
                "make_plant",
                "run_experiment",
            ),
        },
    )
