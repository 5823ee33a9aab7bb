"""What can differ from the nominal machine: the theory in `base`, one small file per effect in `library/`."""

from boom_mj.engine import mujoco as _mujoco  # noqa: F401  # isort: skip


from boom_mj.effects.base import DETUNING as DETUNING
from boom_mj.effects.base import Array as Array
from boom_mj.effects.base import Effect as Effect
from boom_mj.effects.base import Values as Values
from boom_mj.effects.kinds import ActuatorEffect as ActuatorEffect
from boom_mj.effects.kinds import AngleEffect as AngleEffect
from boom_mj.effects.kinds import ChannelEffect as ChannelEffect
from boom_mj.effects.kinds import ForceEffect as ForceEffect
from boom_mj.effects.kinds import InputEffect as InputEffect
from boom_mj.effects.kinds import MachineEffect as MachineEffect
from boom_mj.effects.kinds import ModelEffect as ModelEffect
from boom_mj.effects.kinds import Motion as Motion
from boom_mj.effects.kinds import OutputEffect as OutputEffect
from boom_mj.effects.kinds import ResistEffect as ResistEffect
from boom_mj.effects.kinds import is_output as is_output
from boom_mj.effects.parameter import Parameter as Parameter
from boom_mj.effects.parameter import behind as behind
from boom_mj.effects.registry import Equipped as Equipped
from boom_mj.effects.registry import builtin as builtin
from boom_mj.effects.registry import effect_library as effect_library
from boom_mj.effects.registry import effects_of as effects_of
from boom_mj.effects.registry import load_effects as load_effects
from boom_mj.effects.registry import make_effect as make_effect
from boom_mj.effects.registry import parse_effect as parse_effect
from boom_mj.effects.site import BOOM_SITES as BOOM_SITES
from boom_mj.effects.site import Location as Location
from boom_mj.effects.site import Site as Site
