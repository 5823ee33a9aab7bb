"""Diagnosing blind cases, spread over processes.

A process gets the path of one case and the text of the nominal machine; answers come back to the caller, who writes
each of them whole. What was interrupted goes on where it was.
"""

import json
import time
from collections.abc import Iterator, Sequence
from functools import partial
from hashlib import sha256
from pathlib import Path

from boom_mj.blind.sandbox import confined_to
from boom_mj.diagnosis.answer import document
from boom_mj.diagnosis.diagnose import diagnose
from boom_mj.effects import Equipped, effect_library
from boom_mj.errors import InputError
from boom_mj.files import locked, read_bytes, read_json, read_text, write_text
from boom_mj.logs import read_log
from boom_mj.machine import parse_machine
from boom_mj.recording import Recording
from boom_mj.spreading import spread
from boom_mj.systems.boom.load import CheckedData, checked_data
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.predictor import Predictor

PARTS = "train", "holdout"  # folders of a case


def waiting_cases(folder: Path, answers: Path) -> tuple[list[Path], int]:
    """Cases without an answer, in the order of their names, and how many there are in all.

    Raises:
        InputError: no sealed set, or one whose seal lies within reach.
    """
    if not (folder / "seal.sha256").is_file():
        raise InputError(f"{folder} holds no sealed campaign: there is no seal.sha256")
    published = read_text(folder / "seal.sha256", InputError).strip()
    for path in sorted(folder.rglob("*")):
        if path.is_file() and sha256(read_bytes(path, InputError)).hexdigest() == published:
            raise InputError(f"{path} is the seal: a campaign must not be run with its answers inside")
    cases = sorted(path.parent for path in folder.glob("*/withhold.json"))
    return [case for case in cases if not (answers / f"{case.name}.json").exists()], len(cases)


def answer_cases(
    cases: Sequence[Path],
    machine: str,
    answers: Path,
    jobs: int = 1,
    cluster: str | None = None,
    most: int | None = None,
) -> Iterator[tuple[Path, Exception | None]]:
    """Diagnose cases and write CASE.json for each; yields every case as it ends, with what went wrong.

    Args:
        machine: text of the nominal machine's file.
        answers: folder for the answers.
        jobs, cluster: see `spread`.
        most: see `diagnose`.
    """
    work = Equipped(partial(solve, machine=machine, most=most))
    with locked(answers):
        for done in spread(work, [case.resolve() for case in cases], jobs, cluster):
            try:
                write_text(answers / f"{done.item.name}.json", done.result())
            except Exception as error:  # one bad case must not end the run
                yield done.item, error
            else:
                yield done.item, None


def solve(case: Path, machine: str, most: int | None = None) -> str:
    """The answer to one case as JSON, by a process that can open nothing but the case."""
    began, spent = time.perf_counter(), time.process_time()
    effect_library()  # of other packages, too, before the door shuts
    with confined_to(case):
        without = tuple(read_json(case / "withhold.json", InputError)["without"])
        system, checked = checked_case(case, machine)
        answer = diagnose(Predictor(system, checked.data, threads=1), without, most=most)
        found = document(answer, checked.names, checked.findings)
    took = {"wall_s": time.perf_counter() - began, "cpu_s": time.process_time() - spent}
    return json.dumps({**found, "without": without, **took}, indent=1)


def checked_case(case: Path, machine: str) -> tuple[BoomSystem, CheckedData]:
    """The nominal boom and the recordings of a case."""
    train, held_out = case_logs(case)
    system = BoomSystem(parse_machine(machine))
    return system, checked_data(system, [*train, *held_out], len(train))


def case_logs(case: Path) -> tuple[list[Recording], list[Recording]]:
    """Logs of a case for training, and held out, by name."""
    train, held_out = ([read_log(path) for path in sorted((case / part).glob("*.mcap"))] for part in PARTS)
    return train, held_out
