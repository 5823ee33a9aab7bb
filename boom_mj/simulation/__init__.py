"""Experiments on compiled booms: rest, prescribed joint motion, rope cuts."""

from boom_mj.engine import mujoco as _mujoco  # noqa: F401  # isort: skip

from boom_mj.simulation.catalogue import CATALOGUE as CATALOGUE
from boom_mj.simulation.catalogue import load_experiment as load_experiment
from boom_mj.simulation.diverged import LastStates as LastStates
from boom_mj.simulation.experiments import Experiment as Experiment
from boom_mj.simulation.plant import Plant as Plant
from boom_mj.simulation.plant import make_plant as make_plant
from boom_mj.simulation.simulate import Trajectory as Trajectory
from boom_mj.simulation.simulate import driven_model as driven_model
from boom_mj.simulation.simulate import run as run
from boom_mj.simulation.simulate import run_experiment as run_experiment
from boom_mj.simulation.simulate import step_times as step_times
from boom_mj.simulation.smoothing import smooth_angles as smooth_angles
