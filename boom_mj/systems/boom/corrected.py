"""A machine file's text with effects in it."""

from collections.abc import Mapping
from typing import Any

from boom_mj.effects import Effect
from boom_mj.machine import EffectEntry, Machine
from boom_mj.systems.system import Hypothesis


def with_effects_text(machine_text: str, causes: Hypothesis, nuisances: Hypothesis = ()) -> str:
    """A machine file's text with effects added, each under a comment that says why it is there."""
    text = machine_text.rstrip("\n") + "\n"
    for why, effects in (("nuisance, as built: estimated", nuisances), ("cause: named by the diagnosis", causes)):
        text += "".join(f"\n# {why}\n{_toml(_entry(effect))}" for effect in effects)
    return text


def with_effects(machine: Machine, hypothesis: Hypothesis) -> Machine:
    """A machine as `with_effects_text` would write it."""
    added = (EffectEntry.model_validate(_entry(effect)) for effect in hypothesis)
    return machine.model_copy(update={"effect": (*machine.effect, *added)})


def _entry(effect: Effect) -> dict[str, Any]:
    """What a machine file says of an effect: id, place, and what is not neutral."""
    declared = effect.declared
    changed = {name: value for name, value in effect.values.items() if value != declared[name].neutral}
    return {"id": effect.id, **effect.location, **changed}


def _toml(entry: Mapping[str, Any]) -> str:
    return "\n".join(["[[effect]]", *(f"{k} = {v!r}".replace("'", '"') for k, v in entry.items())]) + "\n"
