"""A machine file's text with effects in it."""

from collections.abc import Iterator
from typing import Any

from boom_mj.effects import Effect
from boom_mj.machine import EffectEntry, Machine
from boom_mj.systems.system import NO_REASONS, Hypothesis, Reasons


def with_effects_text(
    machine_text: str, causes: Hypothesis, nuisances: Hypothesis = (), reasons: Reasons = NO_REASONS
) -> str:
    """A machine file's text with effects added; every line says why it is there."""
    text = machine_text.rstrip("\n") + "\n"
    for kind, effects in (("nuisance, as built", nuisances), ("cause", causes)):
        for effect in effects:
            text += "\n" + "".join(_lines(effect, kind, reasons))
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


def _lines(effect: Effect, kind: str, reasons: Reasons) -> Iterator[str]:
    """Of its entry, each with its reason."""
    yield f"[[effect]]  # {reasons.get((effect, 'id'), kind)}\n"
    for key, value in _entry(effect).items():
        role = "what" if key == "id" else "where" if key in effect.location else "how much"
        why = reasons.get((effect, key), "") if role == "how much" else ""
        yield f"{key} = {value!r}".replace("'", '"') + f"  # {role}{': ' * bool(why)}{why}\n"
