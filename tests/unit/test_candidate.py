"""Candidates: what is left of them with one effect or knob less."""

from boom_mj.diagnosis.candidate import Candidate, causes
from boom_mj.effects import effect_library, parse_effect
from boom_mj.effects.general.coulomb_friction import CoulombFriction
from boom_mj.effects.general.joint_friction import JointFriction


def labels(*effects: str) -> set[str]:
    return {simpler.label for simpler in Candidate(tuple(map(parse_effect, effects))).simpler()}


def test_a_single_effect_gives_up_knobs_only() -> None:
    assert labels("base_compliance:axes=roll+pitch,roll=1e7,pitch=2e7") == {
        "base_compliance axes roll",
        "base_compliance axes pitch",
    }
    assert labels("tip_payload:mass=50") == set()


def test_a_pair_gives_up_an_effect_or_knobs_and_keeps_the_rest() -> None:
    pair = "tip_payload:mass=50", "base_compliance:axes=roll+pitch,roll=1e7,pitch=2e7"
    assert labels(*pair) == {
        "tip_payload",
        "base_compliance axes roll+pitch",
        "tip_payload + base_compliance axes roll",
        "tip_payload + base_compliance axes pitch",
    }
    keeps = [
        e for c in Candidate(tuple(map(parse_effect, pair))).simpler() for e in c.effects if "pitch" in str(e.location)
    ]
    assert {e.values["pitch"] for e in keeps} == {2e7}


def test_what_shares_a_cause_does_not_stand_beside() -> None:
    joint, other = {"joint": "a"}, {"joint": "b"}
    assert causes(JointFriction, joint) & causes(CoulombFriction, joint)
    assert not causes(JointFriction, joint) & causes(CoulombFriction, other)
    base = effect_library()["base_compliance"]
    both, roll, pitch = (causes(base, {"axes": axes}) for axes in ("roll+pitch", "roll", "pitch"))
    assert both & roll and both & pitch and not roll & pitch
