"""Replay: a log drives the model; what the sensors would have said is compared with what they said."""

from boom_mj.replay.comparison import Group as Group
from boom_mj.replay.comparison import compare as compare
from boom_mj.replay.comparison import residual as residual
from boom_mj.replay.replay import Replay as Replay
from boom_mj.replay.replay import replay as replay
