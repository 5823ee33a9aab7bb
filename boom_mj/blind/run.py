"""Diagnosing blind cases, spread over processes.

A process gets the path of one case and reads that and what is nominal; answers come back to the caller, who writes
each of them whole. What was interrupted goes on where it was.
"""

import json
import time
from collections.abc import Iterator, Sequence
from functools import partial
from hashlib import sha256
from pathlib import Path

from boom_mj.blind.boom_bench import MACHINE
from boom_mj.blind.mjcf_bench import MAP, MODEL, PARTS, case_of_mjcf
from boom_mj.blind.sandbox import confined_to
from boom_mj.diagnosis.answer import document
from boom_mj.diagnosis.diagnose import diagnose
from boom_mj.effects import Equipped, effect_library
from boom_mj.errors import InputError, MachineFileError
from boom_mj.files import locked, read_bytes, read_json, read_text, write_text
from boom_mj.logs import read_log
from boom_mj.machine import parse_machine
from boom_mj.recording import Recording
from boom_mj.spreading import spread
from boom_mj.systems.boom.load import checked_data
from boom_mj.systems.boom.system import BoomSystem
from boom_mj.systems.predictor import Predictor
from boom_mj.systems.recorded import RecordedMachine

NOMINAL = MACHINE, MAP, MODEL  # files of a set that a diagnosis may read


def waiting_cases(folder: Path, answers: Path) -> tuple[list[Path], int]:
    """Cases without an answer, in the order of their names, and how many there are in all.

    Raises:
        InputError: no sealed set, or one whose seal lies within reach.
    """
    if not (folder / "seal.sha256").is_file():
        raise InputError(f"{folder} holds no sealed campaign: there is no seal.sha256")
    if not any((folder / name).is_file() for name in NOMINAL):
        raise InputError(f"{folder} holds no nominal machine: there is neither {MACHINE} nor {MAP}")
    published = read_text(folder / "seal.sha256", InputError).strip()
    for path in sorted(folder.rglob("*")):
        if path.is_file() and sha256(read_bytes(path, InputError)).hexdigest() == published:
            raise InputError(f"{path} is the seal: a campaign must not be run with its answers inside")
    cases = sorted(path.parent for path in folder.glob("*/withhold.json"))
    return [case for case in cases if not (answers / f"{case.name}.json").exists()], len(cases)


def answer_cases(
    cases: Sequence[Path],
    answers: Path,
    jobs: int = 1,
    cluster: str | None = None,
    most: int | None = None,
) -> Iterator[tuple[Path, Exception | None]]:
    """Diagnose cases and write CASE.json for each; yields every case as it ends, with what went wrong.

    Args:
        answers: folder for the answers.
        jobs, cluster: see `spread`.
        most: see `diagnose`.
    """
    work = Equipped(partial(solve, most=most))
    with locked(answers):
        for done in spread(work, [case.resolve() for case in cases], jobs, cluster):
            try:
                write_text(answers / f"{done.item.name}.json", done.result())
            except Exception as error:  # one bad case must not end the run
                yield done.item, error
            else:
                yield done.item, None


def solve(case: Path, most: int | None = None) -> str:
    """The answer to one case as JSON, by a process that can open nothing but the case and what is nominal."""
    began, spent = time.perf_counter(), time.process_time()
    effect_library()  # of other packages, too, before the door shuts
    with confined_to(case, *(case.parent / name for name in NOMINAL)):
        without = tuple(read_json(case / "withhold.json", InputError)["without"])
        read = read_case(case)
        answer = diagnose(Predictor(read.system, read.data, threads=1), without, most=most)
        found = document(answer, read.names, read.findings)
    took = {"wall_s": time.perf_counter() - began, "cpu_s": time.process_time() - spent}
    return json.dumps({**found, "without": without, **took}, indent=1)


def read_case(case: Path) -> RecordedMachine:
    """The nominal machine that lies beside a case, and its recordings."""
    nominal = case.parent
    if (nominal / MAP).is_file():
        return case_of_mjcf(case, nominal)
    train, held_out = case_logs(case)
    boom = BoomSystem(parse_machine(read_text(nominal / MACHINE, MachineFileError)))
    checked = checked_data(boom, [*train, *held_out], len(train))
    return RecordedMachine(boom, checked.data, checked.names, checked.findings)


def case_logs(case: Path) -> tuple[list[Recording], list[Recording]]:
    """Logs of a boom's case for training, and held out, by name."""
    train, held_out = ([read_log(path) for path in sorted((case / part).glob("*.mcap"))] for part in PARTS)
    return train, held_out
