"""A law of a free joint acts on what the model does: it is not given the motion that it shall predict."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from boom_mj.discovery import discover, law_file
from boom_mj.effects import Parameter, laws, load_effects
from boom_mj.errors import SimulationError
from boom_mj.recording import Recording
from boom_mj.systems.mjcf import MjcfSystem, load_mjcf
from boom_mj.systems.mjcf.settings import with_settings
from boom_mj.systems.mjcf.system import BASE
from boom_mj.systems.predictor import Predictor
from tests.laws.arm import predictor, system

pytestmark = pytest.mark.usefixtures("own_files")
WHEEL = 0.5 * 0.5 * 0.1**2  # kg m^2


class Held(laws.JointLaw):
    """A spring, a damper and an inertia."""

    id = "test_held"
    table = {
        "stiffness": Parameter("N m/rad", 0.0, -10.0, 10.0, 0.01),
        "damping": Parameter("N m s/rad", 0.0, -1.0, 1.0, 0.01),
        "inertia": Parameter("kg m^2", 0.0, -1.0, 1.0, 1e-3),
    }

    def law(self, position, speed, load, time, stiffness, damping, inertia):
        return stiffness * position + damping * speed + inertia * laws.rate(time, speed)


class Twice(laws.JointLaw):
    """A drive that exerts more."""

    id = "test_twice"
    table = {"gain": Parameter("1", 0.0, -1.0, 1.0, 0.1)}

    def law(self, position, speed, load, time, gain):
        return -gain * load


class Recalled(laws.JointLaw):
    """Friction that builds up and fades, of the whole past."""

    id = "test_recalled"
    table = {"build": Parameter("N m s/rad", 0.0, -1.0, 1.0, 0.01), "fade": Parameter("N m", 0.0, -1.0, 1.0, 0.01)}

    def law(self, position, speed, load, time, build, fade):
        direction = laws.direction(speed, 0.5)
        late, early = laws.lagged(time, speed, 0.4), laws.lagged(time, direction, 0.1)
        return build * (late + early) + fade * laws.fading(time, direction, 0.3)


class Carried(Recalled):
    """The same, of what the filters keep."""

    id = "test_carried"
    remembers = False


def log() -> Recording:
    return predictor().data.recordings[0]


def turn(machine: MjcfSystem, *effects: laws.JointLaw, of: Recording | None = None) -> np.ndarray:
    return machine.simulate(effects, BASE, of or log())["turn"].values[:, 0]


def at_spin(kind: type[laws.JointLaw], **sizes: float) -> laws.JointLaw:
    site = next(site for site in kind.allowed(system().sites()) if site.location.get("joint") == "spin")
    return kind(site, **sizes)


def edited(key: str, value: float) -> MjcfSystem:
    """The machine with one number of its MJCF file otherwise."""
    own = system()
    noise = {name: float(level[0]) for name, level in own.facts.noise.items()}
    return MjcfSystem(with_settings(own.spec, {key: value}), own.channels, predictor().data.recordings, noise)


@pytest.mark.parametrize(
    ("name", "size", "number", "value"),
    [
        ("stiffness", 0.02, "stiffness", 0.02),
        ("damping", 0.03, "damping", 0.02 + 0.03),
        ("inertia", 0.4 * WHEEL, "armature", 0.4 * WHEEL),
    ],
)
def test_a_law_does_what_the_model_file_would(name: str, size: float, number: str, value: float) -> None:
    """MuJoCo's own spring, damper and armature."""
    by_law, by_file = turn(system(), at_spin(Held, **{name: size})), turn(edited(f"joint spin.{number}", value))
    assert np.ptp(by_file - turn(system())) > 0.1
    assert by_law == pytest.approx(by_file, abs=0.01 * np.ptp(by_file))


def test_what_was_measured_after_the_start_is_not_used() -> None:
    """Else the joint's own equation of motion, of what was measured, would explain any machine."""
    motion = log()["motion/spin"]
    other = log().with_signals(
        {"motion/spin": replace(motion, values=motion.values + np.sin(5 * motion.time)[:, None])}
    )
    law = at_spin(Held, stiffness=0.02, damping=0.01, inertia=0.2 * WHEEL)
    assert np.array_equal(turn(system(), law), turn(system(), law, of=other))


def test_a_small_law_is_screened_as_it_acts() -> None:
    """By the motion of the machine without it: the same to first order."""

    class Glimpsed(Held):
        id = "test_glimpsed"
        sees = "nominal"

    size, healthy = {"stiffness": 1e-4, "damping": 1e-4, "inertia": 1e-3 * WHEEL}, turn(system())
    exact, quick = (turn(system(), at_spin(kind, **size)) - healthy for kind in (Held, Glimpsed))
    assert np.ptp(exact) > 1e-3
    assert quick == pytest.approx(exact, abs=0.02 * np.ptp(exact))


def test_filters_go_on_from_one_step_to_the_next() -> None:
    sizes = {"build": 0.02, "fade": 0.05}
    whole, carried = (turn(system(), at_spin(kind, **sizes)) for kind in (Recalled, Carried))
    assert np.ptp(whole - turn(system())) > 0.1
    assert carried == pytest.approx(whole, abs=1e-9)


def test_load_is_what_the_actuator_exerts_at_the_time() -> None:
    assert turn(system(), at_spin(Twice, gain=0.5)) == pytest.approx(
        turn(edited("actuator spinner.gear", 1.5)), abs=1e-9
    )


def test_a_law_that_cancels_the_machine_ends_in_one_sentence() -> None:
    with pytest.raises(SimulationError, match="left the numbers"):
        turn(system(), at_spin(Held, inertia=-2 * WHEEL))


WHEEL_FILE = """<mujoco model="wheel"><option timestep="0.005" integrator="implicitfast" gravity="0 0 0"/><worldbody>
<body name="wheel"><joint name="spin" damping="0.002"/>
<inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/></body></worldbody>
<actuator><motor name="motor" joint="spin"/></actuator></mujoco>"""
WHEEL_MAP = """
name = "wheel"
model = "wheel.xml"
time = "t"
window = 2.0
channel = [
  {name = "push", role = "control", actuator = "motor", field = "u", unit = "N m"},
  {name = "turn", role = "compare", joint = "spin", field = "q", unit = "rad", noise = 1e-3},
]
"""


def test_the_law_of_a_free_joint_is_found(tmp_path: Path) -> None:
    """Quadratic drag, integrated by SciPy."""
    drag, time = 2e-4, np.arange(0.0, 12.0, 0.02)

    def torque(t: float) -> float:
        return 0.06 * np.sin(1.3 * t) + 0.04 * np.sin(0.47 * t + 1)

    def moves(t: float, state: np.ndarray) -> list[float]:
        speed = state[1]
        return [speed, (torque(t) - 0.002 * speed - drag * speed * abs(speed)) / 0.01]

    angle = solve_ivp(moves, (0, time[-1]), [0.0, 0.0], t_eval=time, rtol=1e-8, atol=1e-8, max_step=0.05).y[0]
    angle += 1e-3 * np.random.default_rng(0).normal(size=len(time))
    (tmp_path / "wheel.xml").write_text(WHEEL_FILE)
    (tmp_path / "map.toml").write_text(WHEEL_MAP)
    rows = "\n".join(f"{t:.3f},{torque(t):.9g},{q:.9g}" for t, q in zip(time, angle))
    (tmp_path / "log.csv").write_text("t,u,q\n" + rows + "\n")
    given = load_mjcf([tmp_path / "log.csv"], [], tmp_path / "map.toml")
    wheel, data = given.system, given.data
    found = discover(Predictor(wheel, data))
    assert found.verdict == "law" and [term.name for term in found.best.terms] == ["drag"]
    assert found.best.scored.fit.effects[0].values["drag"] == pytest.approx(drag, rel=0.05)

    effect = found.best.scored.fit.effects[0]
    (tmp_path / "by_file.py").write_text(law_file(found, "by_file"))
    kind = load_effects(tmp_path / "by_file.py")["by_file"]
    assert not kind.remembers
    by_law, by_file = (turn(wheel, law, of=data.recordings[0]) for law in (effect, kind(effect.site, **effect.values)))
    assert by_file == pytest.approx(by_law, abs=1e-12)
