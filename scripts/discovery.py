"""Sealed check of `gap discover`: booms with a law that is in no library, shoved or healthy ones, withheld effects.

    python scripts/discovery.py make WORK --commit ID [--laws 40] [--healthy 20] [--shoves 10]
    python scripts/discovery.py run WORK [--only GLOB]
    python scripts/discovery.py report WORK -o docs/results/discovery.md [--note TEXT]

The seed is the SHA-256 of the commit's id and the campaign's name, so that it can be neither chosen nor lost. `make`
writes the truth, its hash first; `run` makes the logs of a case, asks the command line, keeps its answer and goes on
where it was stopped; `report` opens the seal. Forces and readings are computed here, not by the grammar: the memory by
its own recursion. The plant has finer hinges and another integrator.
"""

import argparse
import json
import resource
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any, ClassVar

import mujoco
import numpy as np

from boom_mj.blind.detectability import Detectability
from boom_mj.blind.figures import wilson
from boom_mj.blind.plant import nuisances, true_plant
from boom_mj.blind.sampling import VISIBLE, draw
from boom_mj.effects import BOOM_SITES, Effect, ForceEffect, ModelEffect, Motion, OutputEffect, Parameter, builtin
from boom_mj.effects.spec_edits import bent_by
from boom_mj.logs import write_mcap
from boom_mj.machine import Machine, cylinder_lengths, load_machine
from boom_mj.recording import Signal
from boom_mj.sensors import record
from boom_mj.simulation import CATALOGUE, run_experiment

Array = np.ndarray
NAME = "discovery"
TRAIN, HOLDOUT = ("fold_in", "sweep", "release_bow_vertical"), ("mixed", "release_bow_horizontal")
FORMS = ("load_friction", "ripple", "tip_drag", "hardening", "sag", "gain", "memory", "stop", "square_drag", "ground")
BEND = 0.02  # rad
MOMENT = 4e5  # N m, of a boom half stretched
TRIES = 12  # draws of a form
NUMBER = {"number": Parameter("1", 0.0, -1e12, 1e12, 1.0)}


class Cylinder(OutputEffect):
    """One of the forms in a cylinder's force."""

    id = "hidden_cylinder"
    at = ("cylinder",)
    table: ClassVar = NUMBER
    form: str
    sizes: Mapping[str, float]

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        column = int(self.location["cylinder"]) - 2
        joints, force = signals["joint/position"], signals["cylinder/force"]
        length = cylinder_lengths(machine, joints.values)[:, column]
        speed, load, s = np.gradient(length, joints.time), force.values[:, column], self.sizes
        sign = np.tanh(speed / 2e-4)
        if self.form == "load_friction":
            extra = s["mu"] * np.abs(load) * sign
        elif self.form == "ripple":
            extra = s["amplitude"] * np.sin(2 * np.pi * length / s["period"] + s["phase"])
        elif self.form == "sag":
            extra = -s["a"] * np.abs(speed) * load
        elif self.form == "gain":
            extra = s["g"] * (joints.values[:, column + 1] - s["angle"]) * load
        elif self.form == "memory":
            extra = s["force"] * decayed(joints.time, speed, s["tau"])
        elif self.form == "stop":
            extra = s["stiffness"] * np.maximum(s["side"] * (length - s["at"]), 0.0)
        else:
            extra = s["drag"] * np.abs(speed) * speed
        values = force.values.copy()
        values[:, column] += extra
        return {"cylinder/force": replace(force, values=values)}


def decayed(time: Array, speed: Array, tau: float) -> Array:
    """After a stop 1 in the direction in which it moved, falling to 1/e in tau; 0 in motion and before the first."""
    moving, out, last, since = np.abs(speed) > 2e-4, np.zeros(len(time)), 0.0, 0.0
    for k in range(len(time)):
        if moving[k]:
            last, since = np.sign(speed[k]), time[k]
        else:
            out[k] = last * np.exp(-(time[k] - since) / tau)
    return out


class ImuGain(OutputEffect):
    """The gain of an accelerometer's axis depends on the joint's angle."""

    id = "hidden_gain"
    at = ("link",)
    table: ClassVar = NUMBER
    sizes: Mapping[str, float]

    def observe(self, signals: Mapping[str, Signal], machine: Machine) -> Mapping[str, Signal]:
        link = int(self.location["link"])
        name = f"imu/link{link}/specific_force"
        values = signals[name].values.copy()
        values[:, 1] *= 1 + self.sizes["g"] * signals["joint/position"].values[:, link - 1]
        return {name: replace(signals[name], values=values)}


class Hardening(ModelEffect):
    """A link's bending moment grows with the cube of its curvature."""

    id = "hidden_link"
    at = ("link",)
    table: ClassVar = NUMBER
    sizes: Mapping[str, float]

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        for hinge, length in bent_by(spec, machine, int(self.location["link"]), "v"):
            hinge.stiffness[2] += hinge.stiffness[0] * self.sizes["cube"] / length**2


class Ground(ModelEffect):
    """The machine pitches at the origin, on ground whose moment grows with the cube of the angle as well."""

    id = "hidden_ground"
    table: ClassVar = NUMBER
    sizes: Mapping[str, float]

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        base, s = spec.body("base"), self.sizes
        base.explicitinertial, base.mass, base.inertia = True, 1.0, [1.0, 1.0, 1.0]
        joint = base.add_joint(name="ground", axis=[0.0, 1.0, 0.0])
        joint.stiffness = [s["stiffness"], 0.0, s["stiffness"] * s["hardness"]]
        joint.damping[0] = machine.damping.relaxation_time * s["stiffness"]


class Drag(ModelEffect):
    """A ball at the tip in a fluid: MuJoCo's rho C pi r^2 |v| v, which a test of the laws holds against its power."""

    id = "hidden_drag"
    table: ClassVar = NUMBER
    sizes: Mapping[str, float]

    def edit(self, spec: mujoco.MjSpec, machine: Machine) -> None:
        spec.option.density, radius = 1e-4, 0.05
        tip = spec.site("tip")
        ball = tip.parent.add_geom(name="hidden", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[radius, 0, 0], pos=tip.pos)
        ball.mass, ball.contype, ball.conaffinity, ball.fluid_ellipsoid = 0.0, 0, 0, 1.0
        ball.fluid_coefs = [self.sizes["c"] / (1e-4 * np.pi * radius**2), 0.0, 0.0, 0.0, 0.0]


MOVING = {"hardening": Hardening, "tip_drag": Drag, "ground": Ground}
"""Forms that move the machine otherwise."""


class Shove(ForceEffect):
    """Somebody pushes: bumps in time at one point, across the boom's plane and upwards."""

    id = "hidden_shove"
    table: ClassVar = NUMBER
    point: str
    sizes: Mapping[str, float]

    def force(self, motion: Motion) -> Mapping[str, Array]:
        (up, left), slew = history(self.sizes, motion.time), motion.joints[:, 0]
        return {self.point: np.stack([-np.sin(slew) * left, np.cos(slew) * left, up], axis=1)}


def history(sizes: Mapping[str, float], time: Array) -> Array:
    """Of a shove, upwards and to the left, (2, n), N."""
    bumps = [s * np.exp(-(((time - sizes[f"at{k}"]) / sizes["width"]) ** 2)) for k, s in enumerate((1, -1, 1))]
    return np.outer([np.sin(sizes["way"]), np.cos(sizes["way"])], sizes["peak"] * np.sum(bumps, axis=0))


POINTS = {"tip": "the tip", **{f"marker{3 * link - 4}": f"the middle of link {link}" for link in (3, 4, 5)}}


def shove(rng: np.random.Generator) -> dict[str, Any]:
    """At a random point, the further in, the harder."""
    k = int(rng.integers(4))
    point, times = list(POINTS)[k], np.sort(rng.uniform([4, 14, 30], [10, 26, 50]))
    sizes = {"peak": rng.uniform(300, 600) * (1, 4, 2, 1.5)[k], "way": rng.uniform(-np.pi, np.pi)}
    sizes |= {"width": rng.uniform(0.8, 2.5), **{f"at{j}": t for j, t in enumerate(times)}}
    return {"form": "shove", "place": {"point": point}, "sizes": {n: float(v) for n, v in sizes.items()}, "terms": {}}


def drawn(form: str, machine: Machine, rng: np.random.Generator) -> dict[str, Any]:
    """A form at a random place of random size: what is sealed."""
    cylinder = int(rng.integers(2, 4))
    place: dict[str, Any] = {"cylinder": cylinder}
    lengths = np.concatenate([_lengths(machine, name)[:, cylinder - 2] for name in TRAIN])
    low, high = lengths.min(), lengths.max()
    sign = float(rng.choice([-1, 1]))
    if form == "load_friction":
        sizes, terms = {"mu": rng.uniform(0.02, 0.08)}, {"load_friction": "mu"}
    elif form == "ripple":
        period = (high - low) / rng.uniform(1.5, 8)
        sizes = {"amplitude": rng.uniform(3e3, 1e4), "period": period, "phase": rng.uniform(-np.pi, np.pi)}
        terms = {"ripple": "amplitude"}
    elif form == "tip_drag":
        place, sizes, terms = {}, {"c": rng.uniform(60, 250)}, {"drag": "c"}
    elif form == "hardening":
        link = int(rng.integers(2, 5))
        share = rng.uniform(0.2, 0.8)
        place = {"link": link, "bends": "v"}
        sizes, terms = {"cube": share * (machine.links[link - 2].length / BEND) ** 2}, {"cube": "cube"}
    elif form == "ground":
        place, stiffness = {"axes": "roll+pitch"}, rng.uniform(2e7, 1e8)  # pitch: motions that slew little do not roll
        sizes = {"stiffness": stiffness, "hardness": rng.uniform(1, 5) / (MOMENT / stiffness) ** 2}
        sizes["give"] = 1 / stiffness
        terms = {"pitch_hard_give": "give"}
    elif form == "sag":
        sizes, terms = {"a": rng.uniform(1, 5)}, {"sag": "a"}
    elif form == "gain" and rng.random() < 0.5:
        place = {"link": int(rng.integers(2, 6)), "sensor": "specific_force", "axis": "y"}
        sizes, terms = {"g": sign * rng.uniform(0.02, 0.08)}, {"scale_angle": "g"}
    elif form == "gain":
        angle = float(rng.uniform(*np.percentile(_angles(TRAIN[0])[:, cylinder - 1], [20, 80])))
        sizes, terms = {"g": sign * rng.uniform(0.03, 0.12), "angle": angle}, {"load_angle": "g", "load_scale": ""}
    elif form == "memory":
        sizes, terms = {"force": sign * rng.uniform(8e3, 3e4), "tau": rng.uniform(0.8, 4)}, {"after_stop": "force"}
    elif form == "stop":
        at = low + rng.uniform(0.3, 0.7) * (high - low)
        sizes = {"stiffness": rng.uniform(1e5, 5e5), "at": at, "side": sign}
        terms = {"upper_stop" if sign > 0 else "lower_stop": "stiffness"}
    else:
        sizes, terms = {"drag": rng.uniform(3e7, 1.5e8)}, {"drag": "drag"}
    return {"form": form, "place": place, "sizes": {k: float(v) for k, v in sizes.items()}, "terms": terms}


def _angles(name: str) -> Array:
    return CATALOGUE[name].joint_path(np.arange(0, CATALOGUE[name].duration, 0.1))[0]


def _lengths(machine: Machine, name: str) -> Array:
    return cylinder_lengths(machine, _angles(name))


def eyes_of(machine: Machine) -> list[Detectability]:
    """How plainly effects show in training and held out."""
    return [Detectability(machine, tuple(CATALOGUE[name] for name in names)) for names in (TRAIN, HOLDOUT)]


def seen(form: str, machine: Machine, rng: np.random.Generator, eyes: Sequence[Detectability]) -> dict[str, Any]:
    """A form that shows in training and held out, or of TRIES the one that shows most."""
    found: list[tuple[float, dict[str, Any]]] = []
    while len(found) < TRIES and (not found or found[-1][0] < VISIBLE):
        truth = drawn(form, machine, rng)
        found.append((min(eye.visibility([effect_of(truth)]) for eye in eyes), truth))
    visibility, truth = max(found, key=lambda one: one[0])
    return {**truth, "visibility": visibility}


def effect_of(truth: Mapping[str, Any]) -> Effect:
    """The hidden effect."""
    place = truth["place"]
    if truth["form"] == "shove":
        effect: Effect = Shove(number=1.0)
        object.__setattr__(effect, "sizes", truth["sizes"])
        object.__setattr__(effect, "point", place["point"])
        return effect
    kind = MOVING.get(truth["form"]) or (ImuGain if "link" in place else Cylinder)
    site = next(s for s in BOOM_SITES if s.location == {k: v for k, v in place.items() if k in ("link", "cylinder")})
    effect = kind(site, number=1.0)
    object.__setattr__(effect, "sizes", truth["sizes"])
    object.__setattr__(effect, "form", truth["form"])
    return effect


def write_case(truth: Mapping[str, Any], folder: Path) -> None:
    """The logs of a case."""
    machine, rng = load_machine("boom36"), np.random.default_rng(truth["seed"])
    own = nuisances(machine, rng)
    added = [effect_of(truth)] if truth["form"] in (*FORMS, "shove") else []
    if truth["form"] == "withheld":
        eyes = eyes_of(machine)
        found, _ = draw(truth["id"], rng, lambda effects: min(eye.visibility(effects) for eye in eyes))
        added, own = [found], tuple(n for n in own if n.cause != found.cause)
    plant = true_plant(machine, (*own, *added))
    for part, names in (("train", TRAIN), ("holdout", HOLDOUT)):
        (folder / part).mkdir(parents=True, exist_ok=True)
        for name in names:
            experiment = CATALOGUE[name]
            write_mcap(record(run_experiment(plant, experiment), experiment, rng), folder / part / f"{name}.mcap")


def make(work: Path, commit: str, laws: int, healthy: int, shoves: int) -> None:
    seed = sha256(f"{commit}{NAME}".encode()).digest()
    rng = np.random.default_rng(list(seed))
    machine = load_machine("boom36")
    forms = [FORMS[k % len(FORMS)] for k in range(laws)]
    eyes = eyes_of(machine)
    cases = [seen(form, machine, rng, eyes) for form in forms]
    cases += [{"form": "healthy", "place": {}, "sizes": {}, "terms": {}}] * healthy
    cases += [shove(rng) for _ in range(shoves)]
    known = [name for name, kind in builtin().items() if kind.competes and kind.allowed(BOOM_SITES)]
    cases += [{"form": "withheld", "id": name, "place": {}, "sizes": {}, "terms": {}} for name in known]
    truth = {}
    for k in rng.permutation(len(cases)):
        name = sha256(seed + f"case {k}".encode()).hexdigest()[:8]
        truth[f"{'w' if cases[k]['form'] == 'withheld' else 'c'}{name}"] = {
            **cases[k],
            "seed": [*map(int, rng.integers(2**31, size=4))],
        }
    work.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"commit": commit, "cases": truth}, indent=1)
    (work / "truth.json").write_text(text)
    (work / "seal.sha256").write_text(sha256(text.encode()).hexdigest() + "\n")
    print(f"{len(truth)} cases of {commit}; seal {sha256(text.encode()).hexdigest()}")


def ask(work: Path, only: str) -> None:
    """Make and ask every case that has no answer yet; logs are deleted afterwards."""
    truth = json.loads((work / "truth.json").read_text())["cases"]
    for done, (name, case) in enumerate(truth.items(), 1):
        answer = work / f"{name}.json"
        if answer.exists() or not Path(name).match(only):
            continue
        logs = work / name
        write_case(case, logs)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        began, cpu = time.time(), used.ru_utime + used.ru_stime
        command = [sys.executable, "-m", "boom_mj", "gap", "discover", *map(str, sorted((logs / "train").iterdir()))]
        command += ["--holdout", *map(str, sorted((logs / "holdout").iterdir())), "--json", "-"]
        command += ["--without", case["id"]] if case["form"] == "withheld" else []
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        found = (
            json.loads(ended.stdout) if ended.returncode == 0 else {"verdict": "error", "sentence": ended.stderr[-500:]}
        )
        found |= {"wall_s": time.time() - began, "cpu_s": used.ru_utime + used.ru_stime - cpu}
        answer.with_suffix(".part").write_text(json.dumps(found, indent=1))
        answer.with_suffix(".part").rename(answer)
        shutil.rmtree(logs)
        print(f"{done} of {len(truth)}: {name}, {found['verdict']}, {found['cpu_s']:.0f} s", flush=True)


def coefficient(law: Mapping[str, Any], term: str) -> float:
    """The size of a term as it was found."""
    values = {name: p["value"] for name, p in law["parameters"].items()}
    return float(np.hypot(values["sine"], values["cosine"])) if term == "ripple" else values.get(term, np.nan)


def judged(case: Mapping[str, Any], answer: Mapping[str, Any]) -> dict[str, Any]:
    """Whether place, form and sizes are right."""
    law = answer.get("law")
    if not law:
        return {"law": False, "place": False, "form": False, "error": np.nan}
    true = set(case["terms"])
    names = {"stop_stiffness": "stop"}
    found = {names.get(term, term) for term in law["terms"]}
    right = law["place"] == case["place"]
    form = right and true <= found and len(found) <= len(true) + 1
    errors = []
    for term, size in case["terms"].items():
        if form and size:
            sealed = -case["sizes"][size] if term == "sag" else case["sizes"][size]
            errors.append(abs(coefficient(law, term.replace("_hard_", "_")) / sealed - 1))
    return {"law": True, "place": right, "form": form, "error": max(errors, default=np.nan)}


def found_force(case: Mapping[str, Any], answer: Mapping[str, Any]) -> dict[str, Any]:
    """Whether the best force in time is at the right place, and how far it is off, over its size."""
    best = next(iter(answer.get("forces") or []), None)
    if not best or best["acts_on"] != POINTS[case["place"]["point"]]:
        return {"place": False, "error": np.nan, "closure": np.nan}
    off, all_of_it = [], []
    for one in best["histories"]:
        time = np.array(one["time"])
        true = history(case["sizes"], time)[:, time < time[-1] - 2]  # the last has not been felt yet
        off.append(np.array([one["up"]["value"], one["left"]["value"]])[:, : true.shape[1]] - true)
        all_of_it.append(true)
    error = np.sqrt(np.mean(np.hstack(off) ** 2) / np.mean(np.hstack(all_of_it) ** 2))
    return {"place": True, "error": float(error), "closure": best["closure"]}


def share(hits: Sequence[bool]) -> str:
    low, high = wilson(sum(hits), len(hits))
    return f"{sum(hits)} of {len(hits)} ({low:.0%} .. {high:.0%})"


def report(work: Path, page: Path, note: str) -> None:
    sealed = json.loads((work / "truth.json").read_text())
    answers = {
        name: json.loads((work / f"{name}.json").read_text())
        for name in sealed["cases"]
        if (work / f"{name}.json").exists()
    }
    cases = {name: sealed["cases"][name] for name in answers}
    laws = {n: c for n, c in cases.items() if c["form"] in FORMS}
    verdicts = {n: judged(c, answers[n]) for n, c in laws.items()}
    well = [answers[n] for n, c in cases.items() if c["form"] == "healthy"]
    healthy = [answer["verdict"] == "none" and not answer["front"] for answer in well]
    good = [v for v in verdicts.values() if v["form"]]
    closures = [answers[n]["gap"]["closure"] for n in laws if "gap" in answers[n]]
    cpu = [a["cpu_s"] for a in answers.values()]
    rows = [
        ("right place", "90 %", share([v["place"] for v in verdicts.values()])),
        ("right form: the terms, at most one more", "70 %", share([v["form"] for v in verdicts.values()])),
        ("sizes within 10 %, where the form is right", "all", share([v["error"] < 0.1 for v in good])),
        ("held-out closure, median", "0.95", f"{np.median(closures):.2f}"),
        ("healthy: nothing to discover", "20 of 20", share(healthy)),
        ("CPU seconds of a case, median and worst", "180", f"{np.median(cpu):.0f}, {max(cpu):.0f}"),
    ]
    shoves = {n: found_force(c, answers[n]) for n, c in cases.items() if c["form"] == "shove"}
    if shoves:
        there = [v for v in shoves.values() if v["place"]]
        errors, closed = (sorted(v[key] for v in there) for key in ("error", "closure"))
        rows += [
            ("a force of no formula: right place", "-", share([v["place"] for v in shoves.values()])),
            ("its time history off, over its size: median, worst", "-", f"{np.median(errors):.2f}, {errors[-1]:.2f}"),
            (
                "its closure, in channels with no part in it: median, worst",
                "-",
                f"{np.median(closed):.2f}, {closed[0]:.2f}",
            ),
        ]
    misses = [
        f"- `{n}`: {c['form']} at {_words(c['place'])} ({_sizes(c)}): {_last_line(answers[n])}"
        for n, c in laws.items()
        if not (verdicts[n]["form"] and verdicts[n]["error"] < 0.1)
    ]
    by_form = []
    for form in FORMS:
        own = [v for n, v in verdicts.items() if laws[n]["form"] == form]
        if own:
            counts = [len(own), *(sum(bool(v[key]) for v in own) for key in ("place", "form"))]
            counts.append(sum(v["error"] < 0.1 for v in own))
            by_form.append(f"| {form} | {' | '.join(map(str, counts))} |")
    misses += [
        f"- `{n}`: shove on {POINTS[cases[n]['place']['point']]} ({_sizes(cases[n])}): {_last_line(answers[n])}"
        for n, found in shoves.items()
        if not found["place"]
    ]
    withheld = []
    missing = [(c["id"], answers[n]) for n, c in cases.items() if c["form"] == "withheld"]
    for name, a in sorted(missing, key=lambda item: item[0]):
        law = (a.get("law") or (a.get("front") or [{"formula": "-"}])[0])["formula"]
        same = (a.get("law") or {}).get("same_as") or a.get("withheld") or "-"
        closure = f"{a['gap']['closure']:.2f}" if a.get("front") else "-"
        withheld.append(f"| {name} | {a['verdict']} | `{law}` | {closure} | {same} |")
    text = PAGE.format(
        commit=sealed["commit"][:12],
        seal=(work / "seal.sha256").read_text().strip()[:16],
        asked=len(sealed["cases"]),
        done=len(cases),
        table="\n".join(f"| {name} | {goal} | {value} |" for name, goal, value in rows),
        misses="\n".join(misses) or "None.",
        forms="\n".join(by_form),
        withheld="\n".join(withheld),
        note=f"{note}\n" if note else "",
    )
    page.write_text(text)
    print(text)
    print(Counter(a["verdict"] for a in answers.values()))


def _words(place: Mapping[str, Any]) -> str:
    return " ".join(f"{k} {v}" for k, v in place.items()) or "the tip"


def _last_line(answer: Mapping[str, Any]) -> str:
    """Of its sentence, which of an error is a traceback."""
    return str(answer["sentence"].strip().splitlines()[-1])


def _sizes(case: Mapping[str, Any]) -> str:
    return ", ".join(f"{k} {v:.3g}" for k, v in case["sizes"].items())


PAGE = """# Laws that no library has: a sealed check

Booms of the blind check's plant (8 hinges, another integrator, shorter steps, zero offsets and small scatter), each
with one law that is in no library, drawn with its place and sizes from the SHA-256 of commit {commit} and
"discovery"; seal {seal}... {done} of {asked} cases were asked.

| | asked | measured (95 %) |
|---|---|---|
{table}

## Misses

{misses}

## By form

| form | cases | right place | right form | sizes within 10 % |
|---|---|---|---|---|
{forms}

## Effects of the library, withheld

The effect is in the data, and `--without` lets a law stand for it. *Known as*: the library's effect that leaves what
the law leaves, or the one that was left out and leaves less: the answer says that the law is not new.

| withheld | verdict | law, or the best of one term | closure | known as |
|---|---|---|---|---|
{withheld}

## What to mind

- The drag of plant and law is MuJoCo's own; a test holds it against its power. All other forms are computed apart.
- A law is at one place. What acts at several, such as damping of all links, in clocks and in cameras, ends
  in *none*; where another effect of the library imitates the withheld one, the answer names it instead of a law.
{note}
Made by `scripts/discovery.py make | run | report`; truth and answers: [answers.tar.xz](discovery/answers.tar.xz).
"""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("make", "run", "report"):
        one = commands.add_parser(name)
        one.add_argument("work", type=Path)
        if name == "make":
            one.add_argument("--commit", required=True)
            one.add_argument("--laws", type=int, default=40)
            one.add_argument("--healthy", type=int, default=20)
            one.add_argument("--shoves", type=int, default=10)
        elif name == "run":
            one.add_argument("--only", default="*")
        else:
            one.add_argument("-o", type=Path, required=True, dest="page")
            one.add_argument("--note", default="", help="what else there is to mind of these answers")
    given = vars(parser.parse_args())
    work: Callable[..., None] = {"make": make, "run": ask, "report": report}[given.pop("command")]
    work(**given)


if __name__ == "__main__":
    main()
