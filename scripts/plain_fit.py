"""What a user would try first on an MJCF machine: fit the parameters that it has, all at once, and add nothing.

    python scripts/plain_fit.py --map models/real/emps.toml LOG... [--holdout LOG...]

Parameters are those that a nominal file holds: damping, stiffness, armature and masses. The gap is whitened as
`gap diagnose` does it, so that the lines can be compared.
"""

import argparse
from pathlib import Path

from threadpoolctl import threadpool_limits

from boom_mj.diagnosis.candidate import Candidate, Kind
from boom_mj.diagnosis.fitting import fit
from boom_mj.diagnosis.linearisation import Linearisation, linearise
from boom_mj.diagnosis.scoring import score
from boom_mj.effects import builtin
from boom_mj.estimation.bootstrap import gap
from boom_mj.systems.mjcf import load_mjcf
from boom_mj.systems.predictor import Predictor

PARAMETERS = ("viscous_joint_friction", "joint_stiffness", "armature", "body_mass", "link_stiffness", "link_damping")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("logs", nargs="+", type=Path)
    parser.add_argument("--map", type=Path, required=True)
    parser.add_argument("--model", type=Path)
    parser.add_argument("--holdout", nargs="+", type=Path, default=[])
    given = parser.parse_args()
    machine = load_mjcf(given.logs, given.holdout, given.map, given.model)
    with threadpool_limits(1):
        model = linearise(Predictor(machine.system, machine.data))
        nominal = model.clean(model.residual(model.base))
        kinds = [
            (kind, site)
            for name, kind in builtin().items()
            if name in PARAMETERS
            for site in kind.allowed(machine.system.sites())
        ]
        felt = tuple(kind(site) for kind, site in kinds if _felt(model, (kind, site)))
        found = score(model, fit(model, Candidate(felt)))
    for number, name, parameter in found.fit.candidate.parameters:
        effect = found.fit.effects[number]
        place = "/".join(map(str, effect.location.values()))
        print(f"{effect.id:22} {place:10} {name:10} {effect.values[name]:10.4g} {parameter.unit}")
    print(f"gap training {gap(nominal, machine.data.train):.2f} -> {found.train:.2f}")
    print(f"gap held out {gap(nominal, machine.data.held_out):.2f} -> {found.held_out:.2f}")


def _felt(model: Linearisation, what: Kind) -> bool:
    """Whether the data say anything of it."""
    kind, site = what
    effect = kind(site, **kind.screening(site)[0][0])
    moved, still = model.predictor.predict([(effect,), ()], model.facts.fidelity.coarse)
    return float(abs(model.noise.white(moved - still)).max()) > 1e-3


if __name__ == "__main__":
    main()
