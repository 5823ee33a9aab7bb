"""What a user would try first on an MJCF machine: fit the parameters that it has, all at once, and add nothing.

    python scripts/plain_fit.py --map models/real/emps.toml LOG... [--holdout LOG...]

Parameters are those that a nominal file holds: damping, stiffness, armature and masses. The gap is said in the same
metric as `gap diagnose` says it, so that the lines can be compared.
"""

import argparse
from pathlib import Path

from threadpoolctl import threadpool_limits

from boom_mj.diagnosis.candidate import Candidate
from boom_mj.diagnosis.fitting import fit
from boom_mj.diagnosis.linearisation import make_metric
from boom_mj.diagnosis.scoring import gap, judge
from boom_mj.systems.mjcf import robot_campaign

PARAMETERS = ("viscous_friction", "joint_stiffness", "armature", "body_mass", "link_stiffness", "link_damping")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("logs", nargs="+", type=Path)
    parser.add_argument("--map", type=Path, required=True)
    parser.add_argument("--model", type=Path)
    parser.add_argument("--holdout", nargs="+", type=Path, default=[])
    given = parser.parse_args()
    campaign = robot_campaign(given.logs, given.holdout, given.map, given.model)
    with threadpool_limits(1):
        metric = make_metric(campaign)
        nominal = metric.clean(metric.residual(metric.base))
        library = [(kind, place) for kind, place in campaign.subject.library() if kind.id in PARAMETERS]
        felt = [(kind, place) for kind, place in library if _felt(metric, kind(place, **kind.probes(place)[0][0]))]
        found = judge(metric, fit(metric, Candidate(tuple(kind(place) for kind, place in felt))))
    for effect, (number, name, knob) in zip(found.fit.effects, found.fit.candidate.knobs):
        print(f"{effect.id:18} {effect.name:10} {name:10} {found.fit.effects[number].values[name]:10.4g} {knob.unit}")
    print(f"gap training {gap(nominal, campaign.train):.2f} -> {found.train:.2f}")
    print(f"gap held out {gap(nominal, campaign.held_out):.2f} -> {found.held_out:.2f}")


def _felt(metric, effect) -> bool:
    """Whether the data say anything of it."""
    moved, still = metric.campaign.predict([(effect,), ()], metric.campaign.subject.fidelity.coarse)
    return float(abs(metric.white(moved - still)).max()) > 1e-3


if __name__ == "__main__":
    main()
