"""How blind cases are drawn, and what a process that diagnoses one can reach."""

import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import boom_mj
from boom_mj.blind import MIX, SHORT, BoomBench, make_cases, waiting_cases
from boom_mj.blind.boom_bench import SUITE, Suite
from boom_mj.blind.plant import AS_BUILT, HINGES, nuisances, true_plant
from boom_mj.blind.sampling import Order, draw, draw_all, orders, others
from boom_mj.blind.sandbox import confined_to
from boom_mj.blind.unlisted import UNLISTED
from boom_mj.effects import BOOM_SITES, builtin, effect_library
from boom_mj.errors import InputError
from boom_mj.machine import load_machine
from boom_mj.mjcf import build
from boom_mj.systems.boom.system import FINE

ROOT = Path(__file__).parents[2]
BOOM = load_machine(ROOT / "models" / "boom36.toml")


def test_classes_have_their_shares_and_effects_are_dealt_evenly() -> None:
    found = orders(120, MIX, np.random.default_rng(1))
    assert Counter(order.kind for order in found) == {kind: int(share) for kind, share in MIX.items()}
    singles = Counter(order.ids[0] for order in found if order.kind == "single")
    of_booms = {name for name, kind in builtin().items() if kind.allowed(BOOM_SITES)}
    assert set(singles) == of_booms - {"joint_zero_offset"} and max(singles.values()) - min(singles.values()) <= 1
    withheld = {order.without for order in found if order.kind == "withheld"}
    assert len(withheld) == MIX["withheld"] and withheld <= set(singles)
    assert len({order.ids[0] for order in found if order.kind == "stranger"}) == len(UNLISTED) >= 5
    assert [order.kind for order in found] != sorted(order.kind for order in found)
    for order in found:
        assert len(set(order.ids)) == {"none": 0, "pair": 2}.get(order.kind, 1)
        assert (order.without in order.ids) == (order.kind == "withheld")


@pytest.mark.parametrize("suite", [SUITE, SHORT], ids=["whole", "short"])
def test_joints_whose_friction_may_be_asked_for_move_in_training_and_held_out(suite: Suite) -> None:
    kinds = [builtin()[name] for name in ("joint_friction", "viscous_friction")]
    asked = {site.location["joint"] for kind in kinds for site in kind.allowed(BOOM_SITES)}
    for part in (suite.train, suite.holdout):
        assert asked <= {move.joint for experiment in part for move in experiment.move}


def test_more_classes_leave_the_others_as_they_are() -> None:
    plain = {"single": 4.0, "pair": 2.0}
    old = orders(6, plain, np.random.default_rng(3))
    more = orders(12, {**plain, "several": 3.0, "clutter": 3.0}, np.random.default_rng(3))
    assert Counter(order.kind for order in more) == {"single": 4, "pair": 2, "several": 3, "clutter": 3}
    assert {o.ids[0] for o in old if o.kind == "single"} == {o.ids[0] for o in more if o.kind == "single"}
    for order in more:
        assert len(set(order.ids)) in {"several": (3, 4, 5), "pair": (2,)}.get(order.kind, (1,))


def test_machines_as_built_differ_more() -> None:
    usual, built = nuisances(BOOM, np.random.default_rng(0)), nuisances(BOOM, np.random.default_rng(0), AS_BUILT)
    for one, other in zip(usual, built):
        if one.id != "joint_zero_offset":
            assert 4.99 < (other.values["factor"] - 1) / (one.values["factor"] - 1) < 10.01
        else:
            assert one == other


def test_rounding_loses_no_case() -> None:
    assert all(len(orders(n, MIX, np.random.default_rng(0))) == n for n in range(1, 40))
    with pytest.raises(InputError, match="singles"):
        orders(3, {"singles": 1}, np.random.default_rng(0))


def test_sizes_spread_both_ways_and_places_everywhere() -> None:
    rng = np.random.default_rng(2)
    drawn = [draw("link_stiffness", rng, lambda effects: 9.0)[0] for _ in range(300)]
    factors = np.array([effect.values["factor"] for effect in drawn])
    assert np.all((np.abs(factors - 1) >= 0.05) & (np.abs(factors - 1) <= 0.2))
    assert 0.4 < np.mean(factors < 1) < 0.6
    assert len({tuple(effect.location.values()) for effect in drawn}) == 12


def test_what_does_not_show_is_drawn_again() -> None:
    def seen(effects: list) -> float:
        return 2.0 if effects[0].location["link"] == 3 else 0.01

    assert {draw("link_mass", np.random.default_rng(k), seen)[0].location["link"] for k in range(20)} == {3}
    assert draw("link_mass", np.random.default_rng(0), lambda effects: 0.01)[0].id == "link_mass"


def test_what_shows_nowhere_gives_way_to_another_effect() -> None:
    def seen(effects: list) -> float:
        return 2.0 if effects[0].id in ("link_mass", "wind") else 0.01

    order = Order("pair", ("joint_play", "wind"), "tip_payload")
    (first, _), (second, _) = draw_all(order, np.random.default_rng(0), seen)
    assert (first.id, second.id) == ("link_mass", "wind")
    shown = draw_all(Order("single", ("wind",), "tip_payload"), np.random.default_rng(1), seen)
    assert shown == [draw("wind", np.random.default_rng(1), seen)]
    assert draw("wind", np.random.default_rng(1), lambda effects: 0.0)[0].id == "wind"  # shows nothing, and stands
    hidden = draw_all(Order("single", ("link_mass",), "tip_payload"), np.random.default_rng(0), lambda effects: 0.01)
    assert len(hidden) == 1 and hidden[0][0].id != "tip_payload"


def test_what_cannot_be_simulated_gives_way_to_as_many_others() -> None:
    rng = np.random.default_rng(0)
    pair = others(Order("pair", ("wind", "joint_play"), "tip_payload"), rng)
    assert (pair.kind, pair.without, len(set(pair.ids))) == ("pair", "tip_payload", 2)
    assert not {"wind", "joint_play", "tip_payload"} & {*pair.ids}
    withheld = others(Order("withheld", ("wind",), "wind"), rng)
    assert withheld.ids == (withheld.without,) != ("wind",)
    assert others(Order("stranger", ("camera_scale",), "wind"), rng).ids[0] in UNLISTED


def test_strangers_are_described_nowhere_in_the_library() -> None:
    assert not set(UNLISTED) & set(effect_library())
    written = "".join(path.read_text() for path in (ROOT / "boom_mj" / "effects").rglob("*.py"))
    assert not [name for name in UNLISTED if name in written]


@pytest.mark.parametrize("kind", UNLISTED.values(), ids=lambda kind: kind.id)
def test_strangers_compile_into_a_machine_that_stands(kind: type) -> None:
    effect = draw(kind.id, np.random.default_rng(3), lambda effects: 9.0)[0]
    assert np.all(np.isfinite(true_plant(BOOM, [effect]).static_equilibrium(np.radians([0, 60, -35, -40, -45]))))


def test_the_true_plant_is_not_the_diagnosing_model() -> None:
    plant, own = true_plant(BOOM, ()), build(BOOM, FINE.hinges).compile()
    assert FINE.hinges < HINGES and plant.model.nv > own.nv
    assert plant.model.opt.integrator != own.opt.integrator
    assert plant.model.opt.timestep < 0.5 * own.opt.timestep


def test_a_guessable_secret_and_a_seal_among_the_cases_are_refused(tmp_path: Path) -> None:
    wanted = (1, BoomBench("", SHORT), dict(MIX), tmp_path / "cases")
    with pytest.raises(InputError, match="outside"):
        next(make_cases(wanted[0], bytes(32), *wanted[1:], tmp_path / "cases" / "seal.json", 1))
    with pytest.raises(InputError, match="16"):
        next(make_cases(wanted[0], b"1234", *wanted[1:], tmp_path / "seal.json", 1))
    assert not (tmp_path / "cases").exists()


def test_a_diagnosis_opens_nothing_but_its_case(tmp_path: Path) -> None:
    case, seal = tmp_path / "case", tmp_path / "case-seal.json"
    case.mkdir()
    (case / "log").write_text("data")
    seal.write_text("truth")
    (case / "link").symlink_to(seal)
    with confined_to(case):
        assert (case / "log").read_text() == "data"
        assert Path(boom_mj.__file__).read_text()
        for path in (seal, case / "link", case / ".." / seal.name):
            with pytest.raises(PermissionError, match="seal"):
                path.read_text()
        with pytest.raises(PermissionError):
            os.open(seal, os.O_RDONLY)
    assert seal.read_text() == "truth"


def test_a_campaign_with_its_seal_inside_is_not_run(tmp_path: Path) -> None:
    from hashlib import sha256

    (tmp_path / "aa").mkdir()
    (tmp_path / "aa" / "withhold.json").write_text('{"without": []}')
    (tmp_path / "seal.sha256").write_text(sha256(b"truth").hexdigest())
    with pytest.raises(InputError, match=r"neither machine\.toml nor map\.toml"):
        waiting_cases(tmp_path, tmp_path / "answers")
    (tmp_path / "machine.toml").write_text("")
    assert waiting_cases(tmp_path, tmp_path / "answers") == ([tmp_path / "aa"], 1)
    (tmp_path / "aa" / "notes").write_bytes(b"truth")
    with pytest.raises(InputError, match="notes is the seal"):
        waiting_cases(tmp_path, tmp_path / "answers")
