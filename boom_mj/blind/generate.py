"""Making a set of blind cases: logs in one folder, answers in a sealed file elsewhere.

    DIR/README.md               the task, for any method (`task`)
    DIR/answer.schema.json      what an answer holds (`answers`)
    DIR/machine.toml            the nominal machine; of one with a channel map map.toml and model.xml
    DIR/seal.sha256             hash of the sealed answers
    DIR/CASE/withhold.json      the effect that the diagnosis of this case does without
    DIR/CASE/train/*.mcap       training recordings; with a channel map *.csv
    DIR/CASE/holdout/*.mcap     held-out recordings

Names, order and times of files say nothing: cases are named by hashes of the secret, all times are STAMP, and a log
holds what its sensors said and nothing else (reading and writing it again gives the same bytes).
"""

import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from boom_mj.blind.answers import answer_schema
from boom_mj.blind.bench import Bench
from boom_mj.blind.sampling import Order, draw_all, draw_clutter, family, known_effects, orders, others
from boom_mj.effects import Effect
from boom_mj.errors import EffectError, EquilibriumError, InputError, SimulationError
from boom_mj.files import locked, read_json, sweep, write_text
from boom_mj.spreading import results

SECRET = 16  # bytes that a seed file must have, or else it can be guessed from its hash
STAMP = 946684800  # s, the year 2000: modification time of everything in a set
TRIES = 5


@dataclass(frozen=True)
class _Case:
    """What a process needs to make a case."""

    name: str
    entropy: tuple[int, ...]
    order: Order
    bench: Bench
    clutter: int
    folder: str

    def __str__(self) -> str:
        return f"case {self.name}"


def make_cases(
    cases: int,
    secret: bytes,
    bench: Bench,
    mix: Mapping[str, float],
    folder: Path,
    seal: Path,
    jobs: int = 1,
    cluster: str | None = None,
    clutter: int = 0,
) -> Iterator[int]:
    """Make a set; yields how many cases are done. Cases that an earlier call has finished stay as they are.

    Args:
        secret: the only source of chance: the same secret gives the same logs and the same seal.
        bench: where machines of the kind are recorded.
        mix: class -> share.
        seal: file for the answers, outside the folder.
        jobs, cluster: see `spread`.
        clutter: small effects that every machine has besides.

    Raises:
        InputError: the seal would lie among the cases, the secret is too short, the campaign is sealed already.
    """
    if folder.resolve() in seal.resolve().parents:
        raise InputError(f"{seal}: the seal must lie outside {folder}")
    if len(secret) < SECRET:
        raise InputError(f"the seed file holds {len(secret)} bytes; at least {SECRET} are needed to keep the secret")
    digest = sha256(b"blind cases" + secret).digest()  # not the hash that may be published
    entropy = tuple(int(word) for word in np.frombuffer(digest, "<u4"))
    drawn = orders(cases, mix, np.random.default_rng(entropy), known_effects(bench.sites), list(bench.unlisted))
    todo = [
        _Case(_hash(digest, "case", k)[:12], (*entropy, k), order, bench, clutter, str(folder.resolve()))
        for k, order in enumerate(drawn)
    ]
    parts = seal.with_suffix(".parts")
    if (folder / "seal.sha256").exists() and not parts.exists():  # with its parts, sealing was interrupted
        raise InputError(f"{folder} holds a sealed campaign already")
    with locked(folder), locked(parts):
        yield from _made(todo, secret, digest, bench, folder, seal, parts, jobs, cluster)


def _made(
    todo: list[_Case],
    secret: bytes,
    digest: bytes,
    bench: Bench,
    folder: Path,
    seal: Path,
    parts: Path,
    jobs: int,
    cluster: str | None,
) -> Iterator[int]:
    """Make the cases that are not done, and seal."""
    waiting = [case for case in todo if not (parts / f"{case.name}.json").exists()]
    yield len(todo) - len(waiting)
    for number, (case, answer) in enumerate(results(_make, waiting, jobs, cluster), len(todo) - len(waiting) + 1):
        _write_json(parts / f"{case.name}.json", answer)
        yield number
    answers = {case.name: read_json(parts / f"{case.name}.json", InputError) for case in todo}
    salt = {"salt": _hash(digest, "salt", 0), "seed_sha256": sha256(secret).hexdigest()}
    _write_json(seal, {**salt, "cases": dict(sorted(answers.items()))})
    for name, text in (*bench.files.items(), ("README.md", bench.readme)):
        write_text(folder / name, text)
    _write_json(folder / "answer.schema.json", answer_schema())
    write_text(folder / "seal.sha256", f"{sha256(seal.read_bytes()).hexdigest()}\n")
    sweep(folder.rglob(".*.part"))
    _same_times(folder)
    for part in parts.iterdir():
        part.unlink()
    parts.rmdir()


def _hash(digest: bytes, purpose: str, number: int) -> str:
    return sha256(digest + f"{purpose} {number}".encode()).hexdigest()


def _write_json(path: Path, content: Any) -> None:
    write_text(path, json.dumps(content, indent=1) + "\n")


def _make(case: _Case) -> dict[str, Any]:
    """Simulate and write a case; what its seal says."""
    rng, folder = np.random.default_rng(case.entropy), Path(case.folder) / case.name
    for attempt in range(2 * TRIES):
        if attempt >= TRIES:  # no size nor place will do
            case = replace(case, order=others(case.order, rng, case.bench.sites))
        try:
            sealed = _drawn(case, rng, folder)
            break
        except (EffectError, EquilibriumError, SimulationError):
            continue  # the coarse model stood it, the fine one does not
    else:
        raise InputError(f"no {case.order.kind} case of {', '.join(case.order.ids)} can be simulated")
    withheld = case.order.kind == "withheld"
    without = family(sealed["effects"][0]["id"]) if withheld else [case.order.without]
    _write_json(folder / "withhold.json", {"without": without})
    return sealed


def _drawn(case: _Case, rng: np.random.Generator, folder: Path) -> dict[str, Any]:
    bench = case.bench
    own = bench.individual(rng, case.order.kind == "clutter")
    drawn = draw_all(case.order, rng, bench.visibility, bench.sites, bench.visible)
    effects = [effect for effect, _ in drawn]
    small = draw_clutter(case.clutter, case.order, effects, rng, bench.sites)
    named = {(effect.id, *effect.location.values()) for effect in (*effects, *small)}
    own = tuple(n for n in own if (n.id, *n.location.values()) not in named)  # an effect's size is all there is of it
    bench.record((*own, *small, *effects), rng, folder)
    sealed = {
        "class": case.order.kind,
        "effects": [{"id": e.id, "location": e.location, "parameters": values} for e, values in drawn],
        "visibility": bench.visibility(effects) if effects else 0.0,
        "nuisances": [_brief(effect) for effect in own],
    }
    clutter = [{**_brief(effect), "alike": [_placed(*cause) for cause in bench.alike(effect)]} for effect in small]
    return {**sealed, "clutter": clutter} if case.clutter else sealed


def _brief(effect: Effect) -> dict[str, Any]:
    return {"id": effect.id, "location": effect.location, "parameters": effect.values}


def _placed(name: str, place: tuple[tuple[str, int | str], ...]) -> dict[str, Any]:
    return {"id": name, "location": dict(place)}


def _same_times(folder: Path) -> None:
    """Set all times within a folder to STAMP, in the order of names."""
    for path in (*sorted(folder.rglob("*"), reverse=True), folder):
        os.utime(path, (STAMP, STAMP))
