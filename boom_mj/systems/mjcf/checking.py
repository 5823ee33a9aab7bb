"""Whether a channel map speaks of things that the model has."""

import mujoco

from boom_mj.errors import ChannelMapError
from boom_mj.systems.mjcf.channel_map import ChannelMap
from boom_mj.systems.mjcf.settings import with_settings

SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


def check(spec: mujoco.MjSpec, channels: ChannelMap) -> None:
    """Refuse a map that names what the model does not have.

    Raises:
        ChannelMapError: the channel, the name, and the names that there are.
    """
    for entry in channels.log:
        with_settings(spec, entry.set)
    model = spec.copy().compile()
    known = {
        "joint": [model.joint(k).name for k in range(model.njnt) if model.jnt_type[k] in SCALAR],
        "actuator": [model.actuator(k).name for k in range(model.nu)],
        "sensor": [model.sensor(k).name for k in range(model.nsensor)],
    }
    wrong = [
        f"channel '{entry.name}': {key} = '{name}' is none of the model's hinges and slides" * (key == "joint")
        + f"channel '{entry.name}': {key} = '{name}' is not in the model" * (key != "joint")
        + f"; it has {', '.join(names) or 'none'}"
        for entry in channels.channel
        for key, names in known.items()
        if (name := getattr(entry, key)) and name not in names
    ]
    if wrong:
        raise ChannelMapError("\n".join(wrong))
