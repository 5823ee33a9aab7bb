"""What can differ from the nominal machine: the theory here, one small file per effect in `library/`."""

from boom_mj.effects.effect import AngleEffect as AngleEffect
from boom_mj.effects.effect import Effect as Effect
from boom_mj.effects.effect import LoadEffect as LoadEffect
from boom_mj.effects.effect import ModelEffect as ModelEffect
from boom_mj.effects.effect import Parameter as Parameter
from boom_mj.effects.effect import SignalEffect as SignalEffect
from boom_mj.effects.effect import effect_library as effect_library
from boom_mj.effects.effect import effects_of as effects_of
from boom_mj.effects.effect import make_effect as make_effect
from boom_mj.effects.effect import parse_effect as parse_effect
