"""What the machine's sensors say of a simulated motion: rates, and noise if asked for."""

from collections.abc import Sequence

import numpy as np

from boom_mj.effects import AngleEffect, Effect, OutputEffect
from boom_mj.effects.kinds import INVERSIONS
from boom_mj.errors import EffectError
from boom_mj.machine import Machine, cylinder_lengths
from boom_mj.recording import Recording, Signal, named_signal, sample
from boom_mj.simulation import Experiment, Trajectory

Array = np.ndarray
RESOLUTION = 10.0  # steps of a sensor's converter within one standard deviation of its noise


def ideal_signals(trajectory: Trajectory) -> dict[str, Signal]:
    """Every sensor without noise, at the steps of the simulation, as the plant's effects leave it."""
    machine, time = trajectory.plant.machine, trajectory.time
    found = {"joint/position": trajectory.joints}
    for link in machine.links:
        found[f"imu/{link.name}/specific_force"] = trajectory.sensor(f"accelerometer_{link.name}")
        found[f"imu/{link.name}/angular_rate"] = trajectory.sensor(f"gyro_{link.name}")
    markers = len(machine.links) * len(machine.sensors.markers_x)
    found["markers"] = np.hstack([trajectory.sensor(f"marker{k + 1}") for k in range(markers)])
    found["cylinder/force"] = trajectory.cylinder_force
    found["cylinder/length"] = cylinder_lengths(machine, trajectory.joints)
    found["load"] = trajectory.tip_force
    signals = {name: named_signal(name, time, values) for name, values in found.items()}
    return apply_sensor_effects(trajectory.plant.effects, signals, machine)


def apply_sensor_effects(effects: Sequence[Effect], signals: dict[str, Signal], machine: Machine) -> dict[str, Signal]:
    """What sensors with effects make of ideal signals."""
    for effect in effects:
        if isinstance(effect, OutputEffect):
            signals = {**signals, **effect.observe(signals, machine)}
        if isinstance(effect, AngleEffect):
            joints = signals["joint/position"]
            read = joints.values + angle_errors([effect], joints.values)
            signals = {**signals, "joint/position": named_signal("joint/position", joints.time, read)}
    return signals


def angle_errors(effects: Sequence[Effect], angles: Array) -> Array:
    """Readings less true angles (n, 5), rad: errors of one joint add up."""
    errors = np.zeros_like(angles)
    for effect in effects:
        if isinstance(effect, AngleEffect):
            joint = int(effect.location["joint"]) - 1
            errors[:, joint] += effect.error(angles[:, joint])
    return errors


def true_angles(effects: Sequence[Effect], reading: Array) -> Array:
    """Joint angles behind a reading, (n, 5), rad: the fixed point of reading less error, which is small and smooth.

    Raises:
        EffectError: the errors are no sensor's, so large that none is found within half a turn.
    """
    errors, angles = [e for e in effects if isinstance(e, AngleEffect)], reading
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(INVERSIONS if errors else 0):
            angles = reading - angle_errors(errors, angles)
        if errors and not np.all(np.abs(reading - angles) < np.pi):
            named = ", ".join(map(repr, errors))
            raise EffectError(f"no joint angle within half a turn of the reading explains it with {named}")
    return angles


def sample_rates(machine: Machine) -> dict[str, float]:
    """Rate of every signal, Hz, by the machine file; what is known rather than measured comes at the joints' rate."""
    rates = machine.sensors.rates_hz
    imus = {
        f"imu/{link.name}/{kind}": rates.imu for link in machine.links for kind in ("specific_force", "angular_rate")
    }
    cylinder = {"cylinder/force": rates.cylinder, "cylinder/length": rates.cylinder}
    return {"joint/position": rates.joint, **imus, "markers": rates.marker, **cylinder, "load": rates.joint}


def noise_levels(machine: Machine) -> dict[str, Array]:
    """Standard deviation of every channel of the noisy signals, in their units."""
    noise = machine.sensors.noise
    levels = {"joint/position": np.full(5, np.radians(noise.joint_deg))}
    for link in machine.links:
        levels[f"imu/{link.name}/specific_force"] = np.full(3, noise.accelerometer)
        levels[f"imu/{link.name}/angular_rate"] = np.full(3, noise.gyroscope)
    marker = [noise.marker_xz, noise.marker_y, noise.marker_xz]
    levels["markers"] = np.array(marker * len(machine.links) * len(machine.sensors.markers_x))
    levels["cylinder/force"] = np.full(2, noise.cylinder_force)
    return levels


def measure(
    trajectory: Trajectory, name: str, description: str, duration: float, rng: np.random.Generator | None = None
) -> Recording:
    """The recording that the machine's sensors would make.

    Args:
        duration: s; samples lie at 0, 1/rate, .. up to it.
        rng: draws the noise; None leaves it out.
    """
    machine = trajectory.plant.machine
    signals, levels = ideal_signals(trajectory), noise_levels(machine)
    sampled = {}
    for signal, rate in sample_rates(machine).items():
        time = np.arange(int(np.floor(duration * rate + 1e-9)) + 1) / rate
        values = sample(signals[signal], time)
        if rng is not None and signal in levels:
            values = _digital(values + rng.normal(size=values.shape) * levels[signal], levels[signal])
        sampled[signal] = named_signal(signal, time, values)
    return Recording(name, machine.name, description, sampled)


def record(trajectory: Trajectory, experiment: Experiment, rng: np.random.Generator | None = None) -> Recording:
    """The log of an experiment: what was measured, and the commands given to the joints; see `measure`."""
    recording = measure(trajectory, experiment.name, experiment.description, experiment.duration, rng)
    time = recording["joint/position"].time
    position, velocity, _ = experiment.joint_path(time)
    commands = {"joint_command/position": position, "joint_command/velocity": velocity}
    return recording.with_signals({name: named_signal(name, time, values) for name, values in commands.items()})


def _digital(values: Array, noise: Array) -> Array:
    """Values in steps of a power of two well below the noise, as a converter gives them; such logs pack better."""
    step = 2.0 ** np.floor(np.log2(np.where(noise > 0, noise, 1e-12) / RESOLUTION))
    return step * np.round(values / step)
