"""What sensors would have said at every step from the machine file to what was recorded."""

from dataclasses import replace

from boom_mj.diagnosis.conclusion import Diagnosis
from boom_mj.diagnosis.linearisation import of_size
from boom_mj.effects import Effect
from boom_mj.recording import Recording
from boom_mj.systems.as_built import AsBuilt, nominal_system
from boom_mj.systems.predictor import Predictor
from boom_mj.systems.system import Hypothesis, Nuisance


def nuisances(found: Diagnosis) -> list[Nuisance]:
    """Of the machine with the causes, of which they leave something."""
    model = found.best.model if found.best else found.model
    return [nuisance.conditional_on(causes(found)) for nuisance in model.nuisances]


def estimated_nuisances(found: Diagnosis) -> tuple[Effect, ...]:
    """Nuisances as effects of the size that the diagnosis estimated, zero offsets first; none of the named causes."""
    model = found.best.model if found.best else found.model
    estimate = model.posterior.estimate(model.residual(*model.predict([causes(found)])))
    return of_size(nuisances(found), estimate)


def built_with(found: Diagnosis) -> tuple[Effect, ...]:
    """What healthy recordings say of how the machine was built, and nuisances as they were estimated."""
    system = found.model.system
    return (*(system.built if isinstance(system, AsBuilt) else ()), *estimated_nuisances(found))


def causes(found: Diagnosis) -> tuple[Effect, ...]:
    """The effects of the best explanation; none where there is none."""
    return found.best.fit.effects if found.best else ()


def explanation(found: Diagnosis) -> tuple[Effect, ...]:
    """The machine as built, and the effects of the best explanation."""
    return (*built_with(found), *causes(found))


def steps(found: Diagnosis) -> dict[str, Hypothesis]:
    """What the machine has that its file lacks, at every step."""
    built = built_with(found)
    return {"data_sheet": (), "as_built": built, "with_causes": (*built, *causes(found))}


def nominal_predictor(found: Diagnosis) -> Predictor:
    """Of the machine as its file is, whatever healthy recordings say of it."""
    predictor, nominal = found.model.predictor, nominal_system(found.model.system)
    return predictor if nominal is predictor.system else Predictor(nominal, predictor.data)


def simulated_recording(predictor: Predictor, effects: Hypothesis, index: int) -> Recording:
    """What the sensors of a recording would have said of a machine with effects, at its own times.

    Raises:
        EquilibriumError, SimulationError: the machine has no simulation.
    """
    log = predictor.data.recordings[index]
    values = predictor.recorded(effects, predictor.system.facts.fidelity.shown, index)
    signals = {name: replace(log[name], values=one) for name, one in values.items()}
    return Recording(log.name, log.machine, f"simulation: {log.description}", signals)
