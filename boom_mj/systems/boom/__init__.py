"""A boom whose logged joint angles drive its model."""

from boom_mj.systems.boom.system import BoomSystem as BoomSystem
