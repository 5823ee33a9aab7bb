"""Flexible large manipulators in MuJoCo: from a machine file to a model, its simulation and the replay of logs."""

import boom_mj.engine  # noqa: F401  # isort: skip

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
from boom_mj.sensors import measure as measure
from boom_mj.sensors import replay as replay
from boom_mj.simulation import CATALOGUE as CATALOGUE
from boom_mj.simulation import Experiment as Experiment
from boom_mj.simulation import Trajectory as Trajectory
from boom_mj.simulation import load_experiment as load_experiment
from boom_mj.simulation import make_plant as make_plant
from boom_mj.simulation import run_experiment as run_experiment
