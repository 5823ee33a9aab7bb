"""The places of a machine where a law may be, with what its variables do in the training recordings."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.discovery.places import Place
from boom_mj.effects import Effect, Site, laws
from boom_mj.recording import Signal

Array = np.ndarray
Signals = Mapping[str, Signal]
CREEP = 2e-4  # m/s, over which a cylinder's dry friction changes sign
SLOW = 0.02  # of its root mean square, the same of a joint's speed
LOADS = 3.0  # deviations of a channel's noise that a law of it is worth finding
ANGLE = 5e-3  # rad, of an angle sensor's error
LEAST = 0.1  # of what a joint's actuator exerts, that a law of it is worth finding
BEND = 0.02  # rad, slope that a link of the loaded boom gathers
SHARE = 0.3  # of a link's stiffness at that slope
STOPS = 4  # thresholds of a link's stop that are tried: each costs a simulation
TIP = {"drag": 20.0, "weight": 200.0}  # N s^2/m^2 and N


def places_of(model: Linearisation) -> list[Place]:
    """Every place of the machine that has a grammar."""
    data, system = model.data, model.system
    level = model.facts.fidelity.coarse
    sites = system.sites()
    runs = [thinned(system.simulate((), level, data.recordings[k]), data.block_s) for k in data.trained]
    found: list[Place] = []
    for base, describe in KINDS.items():
        for site in base.allowed(sites):
            found += describe(base, site, runs, model)
    return found


def thinned(signals: Signals, block_s: float) -> dict[str, Signal]:
    """One sample a block."""
    thin = {}
    for name, signal in signals.items():
        every = max(1, round(block_s * (len(signal.time) - 1) / (signal.time[-1] - signal.time[0])))
        thin[name] = Signal(signal.time[::every], signal.values[::every], signal.channels, signal.unit, signal.frame)
    return thin


def _joined(parts: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _cylinder(base: type[Effect], site: Site, runs: Sequence[Signals], model: Linearisation) -> Iterator[Place]:
    number, machine = int(site.location["cylinder"]), _machine(model)

    def sense(signals: Signals) -> dict[str, Array]:
        return laws.cylinder_variables(signals, machine, number - 2)

    variables = _joined([sense(run) for run in runs])
    if not np.any(np.abs(variables["speed"]) > CREEP):
        return  # what never moves tells of no law
    words = {"x": "m", "F": "N", "creep": CREEP, "middle": float(np.median(variables["position"]))}
    size = LOADS * float(model.facts.noise["cylinder/force"][number - 2])
    yield Place(
        base,
        site,
        f"the force of cylinder {number}",
        variables,
        size,
        words,
        signal="cylinder/force",
        column=number - 2,
        sense=sense,
    )


def _imu(base: type[Effect], site: Site, runs: Sequence[Signals], model: Linearisation) -> Iterator[Place]:
    link = int(site.location["link"])
    for sensor, what, unit in (
        ("specific_force", "accelerometer", "m/s^2"),
        ("angular_rate", "gyroscope", "rad/s"),
    ):
        name = f"imu/link{link}/{sensor}"
        if name not in model.facts.noise or any(name not in run for run in runs):
            continue
        for column, axis in enumerate(laws.AXES):
            sense = partial(laws.imu_variables, link=link, sensor=sensor, column=column)
            variables = _joined([sense(run) for run in runs])
            size = LOADS * float(model.facts.noise[name][column])
            yield Place(
                base,
                site,
                f"the {axis} axis of link {link}'s {what}",
                variables,
                size,
                {"F": unit},
                {"sensor": sensor, "axis": axis},
                signal=name,
                column=column,
                sense=sense,
            )


def _angle(base: type[Effect], site: Site, runs: Sequence[Signals], model: Linearisation) -> Iterator[Place]:
    joint = int(site.location["joint"])
    angle = np.concatenate([run["joint/position"].values[:, joint - 1] for run in runs])
    if np.ptp(angle) > ANGLE:
        yield Place(base, site, f"the angle sensor of joint {joint}", {"angle": angle}, ANGLE, {})


def _link(base: type[Effect], site: Site, runs: Sequence[Signals], model: Linearisation) -> Iterator[Place]:
    link = _machine(model).links[int(site.location["link"]) - 2]
    sizes = {"cube": SHARE * (link.length / BEND) ** 2, "square": SHARE * link.length / BEND, "stop_stiffness": 1e6}
    slope = np.linspace(-BEND, BEND, 9)
    for bends, way in (("v", "vertical"), ("w", "lateral")):
        acts = f"the {way} bending of link {site.location['link']}"
        yield Place(base, site, acts, {"slope": slope}, 1.0, {}, {"bends": bends}, sizes, thresholds=STOPS)


def _tip(base: type[Effect], site: Site, runs: Sequence[Signals], model: Linearisation) -> Iterator[Place]:
    yield Place(base, site, "the tip", {}, 1.0, {}, sizes=TIP)


def _joint(base: type[Effect], site: Site, runs: Sequence[Signals], model: Linearisation) -> Iterator[Place]:
    joint, data = str(site.location["joint"]), model.data
    time, position, speed = [], [], []
    for k in data.trained:
        line = model.system.timeline(data.recordings[k])
        time.append(np.arange(0.0, line.duration_s, data.block_s))
        motion = data.recordings[k][_motion(model, joint)]
        position.append(np.interp(time[-1], motion.time - line.start_s, motion.values[:, 0]))
        speed.append(np.gradient(position[-1], data.block_s))
    found = {"position": position, "speed": speed, "load": [np.full_like(t, site.value) for t in time], "time": time}
    variables = {name: np.concatenate(parts) for name, parts in found.items()}
    words = {
        "x": site.unit,
        "F": site.force_unit,
        "creep": SLOW * site.speed,
        "middle": float(np.median(variables["position"])),
    }
    yield Place(base, site, f"what resists joint {joint}", variables, LEAST * site.value, words)


def _motion(model: Linearisation, joint: str) -> str:
    """Signal of a joint's measured motion: what drives it, or what is compared."""
    drives = [c.name for c in model.system.channels.role("drive") if c.joint == joint]  # type: ignore[attr-defined]
    return drives[0] if drives else f"motion/{joint}"


def _actuator(base: type[Effect], site: Site, runs: Sequence[Signals], model: Linearisation) -> Iterator[Place]:
    name, data = str(site.location["actuator"]), model.data
    entries = model.system.channels.role("control")  # type: ignore[attr-defined]
    logged = [entry.name for entry in entries if entry.actuator == name]
    if logged:
        signals = [data.recordings[k][logged[0]] for k in data.trained]
        command = np.concatenate([signal.values[:, 0] for signal in signals])
        variables = {"command": command, "time": np.concatenate([signal.time for signal in signals])}
        size = LEAST * site.value
        yield Place(base, site, f"what the actuator {name} does", variables, size, {"x": site.unit or "1"})


def _channel(base: type[Effect], site: Site, runs: Sequence[Signals], model: Linearisation) -> Iterator[Place]:
    name = str(site.location["channel"])

    def sense(signals: Signals) -> dict[str, Array]:
        return {"reading": signals[name].values[:, 0], "time": signals[name].time}

    size = LOADS * float(model.facts.noise[name][0])
    yield Place(
        base,
        site,
        f"the channel {name}",
        _joined([sense(run) for run in runs]),
        size,
        {"F": site.unit},
        signal=name,
        sense=sense,
    )


def _machine(model: Linearisation) -> Any:
    """A boom's."""
    return model.system.machine  # type: ignore[attr-defined]


Describe = Callable[[type[Effect], Site, Sequence[Signals], Linearisation], Iterator[Place]]
KINDS: Mapping[type[Effect], Describe] = {
    laws.CylinderLaw: _cylinder,
    laws.ImuLaw: _imu,
    laws.AngleLaw: _angle,
    laws.LinkLaw: _link,
    laws.TipLaw: _tip,
    laws.JointLaw: _joint,
    laws.ChannelLaw: _channel,
    laws.ActuatorLaw: _actuator,
}
"""What is known of the places of every kind of law."""
