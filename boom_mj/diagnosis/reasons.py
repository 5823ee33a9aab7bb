"""Why a corrected file holds what it holds: a reason for every line of every effect that is written."""

from boom_mj.diagnosis.conclusion import Diagnosis
from boom_mj.diagnosis.named import described
from boom_mj.diagnosis.predictions import built_with, causes, estimated_nuisances, nuisances
from boom_mj.diagnosis.steps import nuisance_sizes
from boom_mj.effects import Effect, behind
from boom_mj.systems.system import Reasons


def reasons(found: Diagnosis) -> Reasons:
    """Of effects as a whole, by (effect, "id"), and of their parameters, by (effect, name).

    A cause's parameter has its 95 % interval, a nuisance's its prior; both what the file says without them.
    """
    said: dict[tuple[Effect, str], str] = {}
    for effect in built_with(found):
        said[effect, "id"] = "nuisance: as the healthy recordings say"
    for effect in estimated_nuisances(found):
        said[effect, "id"] = "nuisance: estimated along with the causes"
    for size in nuisance_sizes(estimated_nuisances(found), nuisances(found)):
        unit = _unit(size.effect, size.parameter)
        said[size.effect, size.parameter] = f"estimate; prior {size.neutral:.4g} +- {size.deviation:.2g}{unit}"
    for effect, cause, sure in zip(causes(found), described(found) if found.best else (), found.named):
        kind = "cause" if sure else "suspect, not sure"
        said[effect, "id"] = f"{kind}: probability {cause['probability']:.2f}"
        for name, size in cause["parameters"].items():
            ends = " .. ".join("no bound" if size[end] is None else f"{size[end]:.5g}" for end in ("low", "high"))
            said[effect, name] = f"estimate; 95 % {ends}{_unit(effect, name)}; without it {_neutral(effect, name)}"
    return said


def _unit(effect: Effect, name: str) -> str:
    return behind(effect.declared[name].unit)


def _neutral(effect: Effect, name: str) -> str:
    return f"{effect.declared[name].neutral:.5g}"
