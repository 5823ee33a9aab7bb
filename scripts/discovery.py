"""Sealed check of `gap discover`: booms with a law that is in no library, shoved or healthy ones, withheld effects.

    python scripts/discovery.py make WORK --commit ID [--laws 40] [--healthy 20] [--shoves 10]
    python scripts/discovery.py run WORK [--only GLOB]
    python scripts/discovery.py report WORK -o docs/results/discovery.md [--note TEXT]

The seed is the SHA-256 of the commit's id and the campaign's name, so that it can be neither chosen nor lost. `make`
writes the truth, its hash first; `run` makes the logs of a case, asks the command line, keeps its answer and goes on
where it was stopped; `report` opens the seal. Laws are those of `hidden_laws`, not of the grammar; the plant has finer
hinges and another integrator.
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
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from hidden_laws import FORMS, HOLDOUT, POINTS, TRAIN, effect_of, eyes_of, history, seen, shove

from boom_mj.blind.figures import wilson
from boom_mj.blind.plant import nuisances, true_plant
from boom_mj.blind.sampling import draw
from boom_mj.effects import BOOM_SITES, builtin
from boom_mj.logs import write_mcap
from boom_mj.machine import load_machine
from boom_mj.sensors import record
from boom_mj.simulation import CATALOGUE, run_experiment

NAME = "discovery"


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
