"""What is known to differ in one log: numbers of the MJCF file, set before anything else is done to the model."""

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from boom_mj.effects.spec_edits import add_mass
from boom_mj.errors import ChannelMapError

Value = float | Sequence[float]
KINDS = ("joint", "body", "geom", "site", "actuator", "tendon", "equality", "option")


def with_settings(spec: mujoco.MjSpec, settings: Mapping[str, Value]) -> mujoco.MjSpec:
    """A copy in which "KIND NAME.ATTRIBUTE" has its value: "joint slide.damping", "actuator servo.kp", "option.wind".

    Attributes are those of the MJCF file; `body NAME.payload` hangs a mass (kg) at the end of a body.

    Raises:
        ChannelMapError: there is no such element or attribute.
    """
    spec = spec.copy()
    for key, value in settings.items():
        place, _, attribute = key.rpartition(".")
        kind, _, name = place.partition(" ")
        if kind not in KINDS:
            raise ChannelMapError(f"'{key}': '{kind}' is none of {', '.join(KINDS)}")
        element = spec.option if kind == "option" else getattr(spec, kind)(name)
        if element is None:
            raise ChannelMapError(f"'{key}': the model has no {kind} '{name}'")
        _set(spec, key, element, name, attribute, value)
    return spec


def _set(spec: mujoco.MjSpec, key: str, element: object, name: str, attribute: str, value: Value) -> None:
    if attribute == "payload" and isinstance(element, mujoco.MjsBody):
        add_mass(spec, name, float(np.asarray(value)))
    elif attribute in ("kp", "kv") and isinstance(element, mujoco.MjsActuator):
        gain = float(np.asarray(value))
        element.biasprm[1 if attribute == "kp" else 2] = -gain
        if attribute == "kp" or not element.biasprm[1]:
            element.gainprm[0] = gain
    elif not hasattr(element, attribute):
        raise ChannelMapError(f"'{key}': there is no attribute '{attribute}'")
    else:
        old = getattr(element, attribute)
        if isinstance(old, np.ndarray) and np.isscalar(value):
            old[0] = value
        else:
            setattr(element, attribute, value)
