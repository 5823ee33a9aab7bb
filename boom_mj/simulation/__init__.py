"""Experiments on compiled booms: rest, prescribed joint motion, rope cuts, replay."""

from boom_mj.simulation.plant import Plant as Plant
from boom_mj.simulation.plant import make_plant as make_plant
