"""Candidates: what is left of them with one effect or parameter less."""

from boom_mj.diagnosis.candidate import Candidate, causes
from boom_mj.effects import BOOM_SITES, Site, effect_library, parse_effect


def labels(*effects: str) -> set[str]:
    return {simpler.label for simpler in Candidate(tuple(map(parse_effect, effects))).simpler()}


def test_a_single_effect_gives_up_parameters_only() -> None:
    assert labels("base_compliance:axes=roll+pitch,roll=1e7,pitch=2e7") == {
        "base_compliance axes roll",
        "base_compliance axes pitch",
    }
    assert labels("tip_payload:mass=50") == set()


def test_a_pair_gives_up_an_effect_or_parameters_and_keeps_the_rest() -> None:
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


def test_an_effect_gives_way_to_its_special_cases_with_their_share_of_its_values() -> None:
    library, site = effect_library(), Site((("joint", "a"),), frozenset({"mjcf"}))
    whole = library["dry_and_viscous_friction"](site, force=0.4, damping=0.7)
    (dry,), (viscous,) = (one.effects for one in Candidate((whole,)).simpler())
    assert (dry.id, dry.values) == ("coulomb_friction", {"force": 0.4})
    assert (viscous.id, viscous.values) == ("viscous_joint_friction", {"damping": 0.7})
    assert not list(Candidate((dry,)).simpler())


def test_what_shares_a_cause_does_not_stand_beside() -> None:
    library = effect_library()
    joint, other = (Site((("joint", name),), frozenset({"mjcf"})) for name in "ab")
    rubbing, dry = library["dry_and_viscous_friction"], library["coulomb_friction"]
    assert causes(rubbing, joint) & causes(dry, joint)
    assert not causes(rubbing, joint) & causes(dry, other)
    base = library["base_compliance"]
    sites = {site.location["axes"]: site for site in base.allowed(BOOM_SITES)}
    both, roll, pitch = (causes(base, sites[axes]) for axes in ("roll+pitch", "roll", "pitch"))
    assert both & roll and both & pitch and not roll & pitch
