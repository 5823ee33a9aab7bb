"""Laws: effects whose physics is a formula at one place, such as `gap discover` finds and people write.

A law is a subclass of one of these with an id, a table and a method `law`, whose arguments are the variables of the
place - arrays (n,) by name - and the parameters. It vanishes where all parameters that are neutral at 0 are 0.
"""

from boom_mj.effects.filters import fading as fading
from boom_mj.effects.filters import lagged as lagged
from boom_mj.effects.filters import rate as rate
from boom_mj.effects.laws.boom import AXES as AXES
from boom_mj.effects.laws.boom import AngleLaw as AngleLaw
from boom_mj.effects.laws.boom import BaseLaw as BaseLaw
from boom_mj.effects.laws.boom import CylinderLaw as CylinderLaw
from boom_mj.effects.laws.boom import ImuLaw as ImuLaw
from boom_mj.effects.laws.boom import LinkLaw as LinkLaw
from boom_mj.effects.laws.boom import MarkerLaw as MarkerLaw
from boom_mj.effects.laws.boom import MiddleLaw as MiddleLaw
from boom_mj.effects.laws.boom import TipLaw as TipLaw
from boom_mj.effects.laws.boom import axis_variables as axis_variables
from boom_mj.effects.laws.boom import cylinder_variables as cylinder_variables
from boom_mj.effects.laws.law import TEMPERATURE as TEMPERATURE
from boom_mj.effects.laws.law import Law as Law
from boom_mj.effects.laws.law import direction as direction
from boom_mj.effects.laws.mjcf import ActuatorLaw as ActuatorLaw
from boom_mj.effects.laws.mjcf import ChannelLaw as ChannelLaw
from boom_mj.effects.laws.mjcf import JointLaw as JointLaw
from boom_mj.effects.laws.mjcf import channel_variables as channel_variables
