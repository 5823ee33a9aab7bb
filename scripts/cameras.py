"""How well cameras measure a boom: geometry, errors of tracked markers, what spoils them: docs/results/cameras.md.

Run: MUJOCO_GL=egl .venv/bin/python scripts/cameras.py   (about an hour on two cores; pictures stay in out/cameras,
6 GB, and what is there is not made again, so that it can be stopped and started at any time)
"""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from camera_geometry import centroid_errors, projection_errors
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.optimize import least_squares

from boom_mj.cameras.rig import rig_of
from boom_mj.cameras.targets import SIDES
from boom_mj.logs import read_mcap
from boom_mj.logs.pictures import COVARIANCE
from boom_mj.machine import load_machine
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment

Array = np.ndarray
ROOT = Path(__file__).parents[1]
WORK = ROOT / "out" / "cameras"
MACHINE = load_machine(ROOT / "models" / "boom36.toml")
RIG = {camera.name: camera for camera in rig_of(MACHINE)}
CUT = 8.0  # s: the rope is cut
VERTICAL = ("--start", "6", "--stop", "26")
SHORT = ("--start", "7.8", "--stop", "11", "--every", "2")
BENDING = ("--start", "0", "--stop", "50", "--every", "4", "--experiment", "fold_in")
SPOILT = {  # what: arguments of render
    "ideal lenses": ("--no-distortion",),
    "lenses of the machine file": (),
    "JPEG, quality 80": ("--jpeg", "80"),
    "sensor noise": ("--noise",),
    "motion blur, 4 ms": ("--blur", "3"),
    "rolling shutter, 10 ms": ("--rolling", "4"),
    "noise, blur and rolling shutter": ("--noise", "--blur", "2", "--rolling", "3"),
    "half the resolution": ("--scale", "0.5"),
    "three quarters of the resolution": ("--scale", "0.75"),
}


def boom(*arguments: object) -> subprocess.CompletedProcess:
    """A command of boom_mj; what it tells on stderr is shown."""
    line = [sys.executable, "-m", "boom_mj", *map(str, arguments)]
    done = subprocess.run(line, text=True, capture_output=True, cwd=ROOT)
    print(done.stderr, end="", flush=True)
    return done


def tracked(name: str, *options: str) -> dict:
    """Render and track a data set unless that was done; what `track` says of it, or why it failed."""
    folder, said = WORK / name, WORK / f"{name}.json"
    if not said.is_file():
        print(f"{name}: {' '.join(options)}", flush=True)
        boom("render", "boom36", "-o", folder, *options).check_returncode()
        files = "-o", WORK / f"{name}.mcap", "--overlay", WORK / f"{name}.png"
        done = boom("track", folder, *files, "--json")
        failed = done.stderr.rpartition("error: ")[2].partition(" of the reference plates")[0]
        said.write_text(json.dumps({"failed": failed}) if done.returncode else done.stdout)
    return json.loads(said.read_text())


def labels(name: str, camera: str) -> list[dict]:
    """Labels of a camera's frames in order."""
    return [json.loads(path.read_bytes()) for path in sorted((WORK / name / "labels" / camera).glob("*.json"))]


def markers(name: str) -> tuple[Array, Array, Array]:
    """Times (n,), tracked and true positions of a data set's markers, (n, 12, 3) each, m."""
    signal = read_mcap(WORK / f"{name}.mcap")["markers"]
    truth = np.array([label["markers"] for label in labels(name, "camera1")])
    return signal.time, signal.values.reshape(len(truth), -1, 3), truth


def rms(values: Array, axis: int | None = None) -> Array:
    """Root mean square of what is not NaN."""
    return np.sqrt(np.nanmean(values**2, axis=axis))


def lens_rows(said: dict) -> Iterator[str]:
    """Lenses and places of the cameras as tracking found them, against the machine file."""
    for name, found in said["cameras"].items():
        lens, place = RIG[name].view.intrinsics, RIG[name].view.position
        focal = 100 * (np.array(found["focal_px"]) / lens.focal - 1)
        center = np.array(found["center_px"]) - lens.center
        moved = 1000 * (np.array(found["position_m"]) - place)
        yield (
            f"| {name} | {focal[0]:+.3f}, {focal[1]:+.3f} | {center[0]:+.2f}, {center[1]:+.2f} | "
            f"{found['lens_rms_px']:.3f} | {', '.join(f'{v:+.1f}' for v in moved)} | {found['reference_rms_px']:.3f} | "
            f"{len(found['reference_plates'])} |"
        )


def marker_rows(name: str) -> Iterator[str]:
    """Every marker: share of the frames in which it has a position, rms errors, largest error."""
    _, found, truth = markers(name)
    error = 1000 * (found - truth)
    for k in range(found.shape[1]):
        share = np.isfinite(found[:, k, 0]).mean()
        if not share:
            yield f"| {k + 1} | 0.0 | | | | |"
            continue
        x, y, z = rms(error[:, k], axis=0)
        largest = np.nanmax(np.linalg.norm(error[:, k], axis=1))
        yield f"| {k + 1} | {100 * share:.1f} | {x:.1f} | {y:.1f} | {z:.1f} | {largest:.1f} |"
    x, y, z = rms(error, axis=(0, 1))
    largest = np.nanmax(np.linalg.norm(error, axis=2))
    share = 100 * np.isfinite(found[..., 0]).mean()
    yield f"| **all** | {share:.1f} | **{x:.1f}** | **{y:.1f}** | **{z:.1f}** | {largest:.1f} |"


def covariances(name: str) -> Array:
    """Stated covariances, (n, 12, 3, 3), m^2."""
    with (WORK / f"{name}.mcap").open("rb") as stream:
        messages = make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages([COVARIANCE])
        return np.array([decoded.data for *_, decoded in messages]).reshape(-1, 12, 3, 3)


def pull(name: str) -> Array:
    """Rms of error over stated standard deviation along x, y, z; 1 if covariances tell the truth."""
    _, found, truth = markers(name)
    return rms((found - truth) / np.sqrt(np.einsum("nmaa->nma", covariances(name))), axis=(0, 1))


def first_frequency(time: Array, height: Array) -> tuple[float, float]:
    """Frequency of the first of two decaying vibrations about a level, and its standard error, Hz."""

    def residual(p: Array) -> Array:
        level, *modes = p
        parts = [
            np.exp(-d * (time - time[0])) * (a * np.cos(2 * np.pi * f * time) + b * np.sin(2 * np.pi * f * time))
            for a, b, f, d in (modes[:4], modes[4:])
        ]
        return height - level - sum(parts)

    step = np.median(np.diff(time))
    power = np.abs(np.fft.rfft((height - height.mean()) * np.hanning(len(height)), 8 * len(height)))
    start = np.fft.rfftfreq(8 * len(height), step)[np.argmax(power)]
    swing = np.ptp(height) / 4
    fit = least_squares(residual, [height.mean(), swing, swing, start, 0.05, 0, 0, 3.6 * start, 0.3], x_scale="jac")
    variance = np.linalg.inv(fit.jac.T @ fit.jac) * 2 * fit.cost / (len(time) - len(fit.x))
    return float(fit.x[3]), float(np.sqrt(variance[3, 3]))


def frequencies(name: str) -> tuple[float, float, float]:
    """First frequency of the tip: tracked with its standard error, and true, Hz."""
    time, found, _ = markers(name)
    there = np.isfinite(found[:, -1, 2]) & (time > CUT + 0.5)
    seen, error = first_frequency(time[there], found[there, -1, 2])
    motion = run_experiment(make_plant(MACHINE, 1), CATALOGUE["release_stretched_vertical"])
    free = (motion.time > CUT + 0.5) & (motion.time < time[-1])
    true, _ = first_frequency(motion.time[free], motion.sensor("marker12")[free, 2])
    return seen, error, true


def spoilt_rows() -> Iterator[str]:
    """What spoils the pictures, and what that does to the positions."""
    for k, (what, options) in enumerate(SPOILT.items()):
        name = f"spoilt{k}"
        said = tracked(name, *SHORT, *options)
        if "failed" in said:
            yield f"| {what} | 0.0 | {said['failed']} of the reference plates | | | | |"
            continue
        _, found, truth = markers(name)
        error = 1000 * (found - truth)
        x, y, z = rms(error, axis=(0, 1))
        largest = np.nanmax(np.linalg.norm(error, axis=2))
        lens = max(camera["lens_rms_px"] for camera in said["cameras"].values())
        yield (
            f"| {what} | {100 * np.isfinite(found[..., 0]).mean():.1f} | {x:.1f} | {y:.1f} | {z:.1f} | {largest:.1f} | "
            f"{lens:.3f} |"
        )


def tip_speed(name: str) -> float:
    """Largest speed of a marker, m/s."""
    time, _, truth = markers(name)
    return float(np.linalg.norm(np.diff(truth, axis=0), axis=2).max() / np.diff(time).min())


def occlusion_rows(name: str) -> Iterator[str]:
    """By how well two cameras see a marker: how often, how often with a position, errors in mm and in deviations."""
    _, found, truth = markers(name)
    share = np.zeros((len(RIG), *found.shape[:2]))  # of a marker's plate that each camera sees
    for frames, seen in zip((labels(name, camera) for camera in RIG), share):
        for label, row in zip(frames, seen):
            plates = [[label["plates"][f"marker{k + 1}_{side}"]["visible"] for side in SIDES] for k in range(len(row))]
            row[:] = np.max(plates, axis=1)
    second, there = np.sort(share, axis=0)[-2], np.isfinite(found[..., 0])
    error = found - truth
    distance = 1000 * np.linalg.norm(error, axis=2)
    sigmas = np.sqrt(np.einsum("nma,nmab,nmb->nm", error, np.linalg.inv(covariances(name)), error))
    groups = {
        "two whole plates": second > 0.99,
        "half of two plates or more": (second >= 0.5) & (second <= 0.99),
        "less": (second > 0) & (second < 0.5),
        "nothing of the second": second == 0,
        "**all**": second >= 0,
    }
    for what, chosen in groups.items():
        given = chosen & there
        line = f"| {what} | {100 * chosen.mean():.1f} | {100 * given.sum() / max(chosen.sum(), 1):.1f} |"
        if not given.any():
            yield line + " | | | |"
            continue
        x, y, z = 1000 * rms(error[given], axis=0)
        yield line + f" {x:.1f}, {y:.1f}, {z:.1f} | {distance[given].max():.1f} | {sigmas[given].max():.1f} |"


def speed() -> tuple[list[str], list[str]]:
    """Rows of the loops, and of whole data sets by their workers."""
    result = WORK / "rendering.json"
    if not result.is_file():
        subprocess.run([sys.executable, ROOT / "benchmarks" / "rendering.py", "-o", result], check=True, cwd=ROOT)
    found = json.loads(result.read_text())
    costs, loops = found["loops"], []
    for name, (wall, cpu) in costs.items():
        bare_wall, bare_cpu = costs[f"bare loop, {'ideal' if 'ideal' in name else 'distorting'} lenses"]
        loops.append(f"| {name} | {wall:.3f} | {bare_wall / wall:.2f} | {cpu:.3f} | {bare_cpu / cpu:.2f} |")
    return loops, [f"| {workers} | {rate:.2f} |" for workers, rate in found["workers"].items()]


def draw_picture(path: Path) -> None:
    """The overlays of a stretched and of a folding boom below each other, in few enough colours for a small file."""
    rows = [cv2.imread(str(WORK / f"{name}.png")) for name in ("spoilt1", "fold_in")]
    picture = cv2.resize(np.vstack(rows), None, fx=0.75, fy=0.75, interpolation=cv2.INTER_AREA)
    few = np.minimum(picture.astype(int) // 14 * 14 + 8, 255).astype(np.uint8)
    cv2.imwrite(str(path), few, [cv2.IMWRITE_PNG_COMPRESSION, 9])


def main() -> None:
    WORK.mkdir(parents=True, exist_ok=True)
    opencv, mujocos = projection_errors(MACHINE)
    centroid = centroid_errors(MACHINE, "release_stretched_vertical")
    clean = tracked("vertical", *VERTICAL)
    seen, error, true = frequencies("vertical")
    tracked("fold_in", *BENDING)
    loops, workers = speed()
    filled = {
        "opencv": f"{opencv:.1e}",
        "mujoco": f"{mujocos:.4f}",
        "centroid": f"{rms(centroid):.3f} rms, {centroid.max():.3f} largest, of {len(centroid)}",
        "lenses": "\n".join(lens_rows(clean)),
        "markers": "\n".join(marker_rows("vertical")),
        "pull": ", ".join(f"{v:.2f}" for v in pull("vertical")),
        "frequency": f"{seen:.6f} +- {error:.6f} Hz seen, {true:.6f} Hz true, {100 * (seen / true - 1):+.4f} %",
        "speed": f"{tip_speed('vertical'):.1f}",
        "spoilt": "\n".join(spoilt_rows()),
        "hidden": "\n".join(occlusion_rows("fold_in")),
        "loops": "\n".join(loops),
        "workers": "\n".join(workers),
    }
    draw_picture(ROOT / "docs" / "cameras.png")
    text = (ROOT / "docs" / "results" / "cameras.md.in").read_text()
    for name, value in filled.items():
        text = text.replace("{" + name + "}", value)
    (ROOT / "docs" / "results" / "cameras.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
