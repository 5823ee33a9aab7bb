"""The places of a machine where a law may be, with what its variables do in the training recordings."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from boom_mj.diagnosis.linearisation import Linearisation
from boom_mj.discovery.places import Place
from boom_mj.effects import Site, laws
from boom_mj.effects.spec_edits import BASE_AXES
from boom_mj.recording import Signal
from boom_mj.systems.mjcf.readout import temperature

Array = np.ndarray
Signals = Mapping[str, Signal]
Sense = Callable[[int], dict[str, Array]]
CREEP = 2e-4  # m/s, over which a cylinder's dry friction changes sign
SLOW = 0.02  # of its root mean square, the same of a joint's speed
LOADS = 3.0  # deviations of a channel's noise that a law of it is worth finding
ANGLE = 5e-3  # rad, of an angle sensor's error
LEAST = 0.1  # of what a joint's actuator exerts, that a law of it is worth finding
WARMER = 1.0  # K, by which a temperature must change that a law may be of it
BEND = 0.02  # rad, slope that a link of the loaded boom gathers
SHARE = 0.3  # of a link's stiffness at that slope
STOPS = 4  # thresholds of a link's stop that are tried: each costs a simulation
FIRST = 2  # terms of a link, a change of stiffness and of rest: they imitate all others to a large part
GIVE = 1e-8  # rad/(N m), of what a boom stands on
BASE = {f"{axis}_{name}": size for axis in BASE_AXES for name, size in (("tilt", 5e-3), ("give", GIVE))}
STANDS = 4  # terms of the base, its tilts and what it gives, that are looked at before how hard it becomes
POINT = {"drag": 20.0, "weight": 200.0, "inertia": 20.0}  # N s^2/m^2, N and kg


class Motions:
    """What happens in every recording, simulated once where it is asked for."""

    def __init__(self, model: Linearisation):
        self.model = model
        self._runs: dict[int, Signals] = {}

    def signals(self, index: int) -> Signals:
        """Simulated signals of a recording, one sample a block."""
        if index not in self._runs:
            model = self.model
            dense = model.system.simulate((), model.facts.fidelity.coarse, model.data.recordings[index])
            self._runs[index] = _thinned(dense, model.data.block_s)
        return self._runs[index]

    def trained(self, sense: Sense) -> dict[str, Array]:
        """Variables over all recordings that train, (n,) each."""
        parts = [sense(index) for index in self.model.data.trained]
        return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def places_of(model: Linearisation) -> list[Place]:
    """Every place of the machine that has a grammar."""
    sites, motions = model.system.sites(), Motions(model)
    kinds = ((base, site, describe) for base, describe in KINDS.items() for site in base.allowed(sites))
    return [place for base, site, describe in kinds for place in describe(base, site, motions)]


def _thinned(signals: Signals, block_s: float) -> Signals:
    """One sample a block."""
    thin = {}
    for name, signal in signals.items():
        every = max(1, round(block_s * (len(signal.time) - 1) / (signal.time[-1] - signal.time[0])))
        thin[name] = Signal(signal.time[::every], signal.values[::every], signal.channels, signal.unit, signal.frame)
    return thin


def _cylinder(base: type[laws.Law], site: Site, motions: Motions) -> Iterator[Place]:
    number, machine = int(site.location["cylinder"]), _machine(motions.model)

    def sense(index: int) -> dict[str, Array]:
        return laws.cylinder_variables(motions.signals(index), machine, number - 2)

    variables = motions.trained(sense)
    if np.any(np.abs(variables["speed"]) > CREEP):  # what never moves tells of no law
        words = {"x": "m", "F": "N", "creep": CREEP, "middle": _middle(variables["position"])}
        size = LOADS * float(motions.model.facts.noise["cylinder/force"][number - 2])
        channel = ("cylinder/force", number - 2)
        yield Place(base, site, f"the force of cylinder {number}", variables, size, words, channel=channel, sense=sense)


def _imu(base: type[laws.Law], site: Site, motions: Motions) -> Iterator[Place]:
    link, noise = int(site.location["link"]), motions.model.facts.noise
    for sensor, what, unit in (("specific_force", "accelerometer", "m/s^2"), ("angular_rate", "gyroscope", "rad/s")):
        name = f"imu/link{link}/{sensor}"
        for column, axis in enumerate(laws.AXES if name in noise else ""):

            def sense(index: int, name: str = name, column: int = column) -> dict[str, Array]:
                return laws.axis_variables(motions.signals(index), name, column, link)

            yield Place(
                base,
                site,
                f"the {axis} axis of link {link}'s {what}",
                motions.trained(sense),
                LOADS * float(noise[name][column]),
                {"F": unit},
                {"sensor": sensor, "axis": axis},
                channel=(name, column),
                sense=sense,
            )


def _marker(base: type[laws.Law], site: Site, motions: Motions) -> Iterator[Place]:
    number, noise = int(site.location["marker"]), motions.model.facts.noise.get("markers", ())
    for axis, way in enumerate(laws.AXES if len(noise) else ""):
        column = 3 * number - 3 + axis

        def sense(index: int, column: int = column) -> dict[str, Array]:
            return laws.axis_variables(motions.signals(index), "markers", column, 1)

        yield Place(
            base,
            site,
            f"the {way} coordinate of marker {number}",
            motions.trained(sense),
            LOADS * float(noise[column]),
            {"F": "m"},
            {"axis": way},
            channel=("markers", column),
            sense=sense,
        )


def _angle(base: type[laws.Law], site: Site, motions: Motions) -> Iterator[Place]:
    joint, data = int(site.location["joint"]), motions.model.data
    signals = [motions.signals(k)["joint/position"] for k in data.trained]
    angle = np.concatenate([signal.values[:, joint - 1] for signal in signals])
    if np.ptp(angle) > ANGLE:
        words = {"middle": _middle(angle)}
        yield Place(base, site, f"the angle sensor of joint {joint}", {"angle": angle}, ANGLE, words)


def _link(base: type[laws.Law], site: Site, motions: Motions) -> Iterator[Place]:
    link = _machine(motions.model).links[int(site.location["link"]) - 2]
    bent = BEND / link.length
    sizes = {"linear": SHARE, "offset": SHARE * bent, "square": SHARE / bent, "cube": SHARE / bent**2}
    sizes["stop_stiffness"] = 1e6
    slope = {"slope": np.linspace(-BEND, BEND, 9)}
    for bends, way in (("v", "vertical"), ("w", "lateral")):
        acts = f"the {way} bending of link {site.location['link']}"
        yield Place(base, site, acts, slope, 1.0, {}, {"bends": bends}, sizes, thresholds=STOPS, first=FIRST)


def _point(base: type[laws.Law], site: Site, motions: Motions) -> Iterator[Place]:
    link = site.location.get("link")
    yield Place(base, site, f"the middle of link {link}" if link else "the tip", {}, 1.0, {}, sizes=POINT)


def _base(base: type[laws.Law], site: Site, motions: Motions) -> Iterator[Place]:
    if site.location["axes"] == "+".join(BASE_AXES):
        yield Place(base, site, "the base", {}, 1.0, {}, sizes=BASE, first=STANDS)


def _joint(base: type[laws.Law], site: Site, motions: Motions) -> Iterator[Place]:
    joint, model = str(site.location["joint"]), motions.model
    channels = model.system.channels  # type: ignore[attr-defined]
    drives = [entry.name for entry in channels.role("drive") if entry.joint == joint]

    def sense(index: int) -> dict[str, Array]:
        log = model.data.recordings[index]
        line, motion = model.system.timeline(log), log[drives[0] if drives else f"motion/{joint}"]
        time = np.arange(0.0, line.duration_s, model.data.block_s)
        position = np.interp(time, motion.time - line.start_s, motion.values[:, 0])
        speed = np.gradient(position, model.data.block_s)
        known = {"position": position, "speed": speed, "load": np.full_like(time, site.value), "time": time}
        warm = temperature(channels, joint, log, time)
        return known if warm is None else {**known, "temperature": warm}

    variables = _varied(motions.trained(sense))
    middle = _middle(variables["position"])
    words = {"x": site.unit, "F": site.force_unit, "creep": SLOW * site.speed, "middle": middle, **_warm(variables)}
    yield Place(base, site, f"what resists joint {joint}", variables, LEAST * site.value, words, sense=sense)


def _actuator(base: type[laws.Law], site: Site, motions: Motions) -> Iterator[Place]:
    name, data = str(site.location["actuator"]), motions.model.data
    entries = motions.model.system.channels.role("control")  # type: ignore[attr-defined]
    logged = [entry.name for entry in entries if entry.actuator == name]
    if logged:
        signals = [data.recordings[k][logged[0]] for k in data.trained]
        command = np.concatenate([signal.values[:, 0] for signal in signals])
        variables = {"command": command, "time": np.concatenate([signal.time for signal in signals])}
        words = {"x": site.unit}
        yield Place(base, site, f"what the actuator {name} does", variables, LEAST * site.value, words)


def _channel(base: type[laws.Law], site: Site, motions: Motions) -> Iterator[Place]:
    name = str(site.location["channel"])

    def sense(index: int) -> dict[str, Array]:
        return laws.channel_variables(motions.signals(index), name)

    size = LOADS * float(motions.model.facts.noise[name][0])
    variables = _varied(motions.trained(sense))
    words = {"F": site.unit, **_warm(variables)}
    yield Place(base, site, f"the channel {name}", variables, size, words, channel=(name, 0), sense=sense)


def _varied(variables: dict[str, Array]) -> dict[str, Array]:
    """Without a temperature that stays the same."""
    still = "temperature" in variables and np.ptp(variables["temperature"]) < WARMER
    return {name: values for name, values in variables.items() if name != "temperature" or not still}


def _warm(variables: Mapping[str, Array]) -> dict[str, float]:
    """The middle of a temperature, where it is known."""
    return {"warm": _middle(variables["temperature"])} if "temperature" in variables else {}


def _middle(values: Array) -> float:
    """The median, in a few digits of the range: it is written in formulas."""
    return round(float(np.median(values)), 1 - int(np.floor(np.log10(max(float(np.ptp(values)), 1e-9)))))


def _machine(model: Linearisation) -> Any:
    """A boom's."""
    return model.system.machine  # type: ignore[attr-defined]


Describe = Callable[[type[laws.Law], Site, Motions], Iterator[Place]]
KINDS: Mapping[type[laws.Law], Describe] = {
    laws.CylinderLaw: _cylinder,
    laws.ImuLaw: _imu,
    laws.MarkerLaw: _marker,
    laws.AngleLaw: _angle,
    laws.LinkLaw: _link,
    laws.TipLaw: _point,
    laws.MiddleLaw: _point,
    laws.BaseLaw: _base,
    laws.JointLaw: _joint,
    laws.ChannelLaw: _channel,
    laws.ActuatorLaw: _actuator,
}
"""What is known of the places of every kind of law."""
