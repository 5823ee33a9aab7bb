"""A small blind check from the secret to the score, and what its files give away."""

import json
import shutil
from collections import Counter
from hashlib import sha256
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from boom_mj.blind import (
    BoomBench,
    Suite,
    answer_cases,
    answer_schema,
    make_cases,
    score,
    waiting_cases,
    with_hindsight,
)
from boom_mj.blind.generate import STAMP
from boom_mj.blind.task import readme
from boom_mj.blind.unlisted import UNLISTED
from boom_mj.effects import effect_library
from boom_mj.errors import InputError
from boom_mj.logs import read_log, write_mcap
from boom_mj.simulation import CATALOGUE, Experiment

MACHINE = (Path(__file__).parents[2] / "models" / "boom36.toml").read_text()
SECRET = b"a secret that everybody may read, 11"  # whose effects show in 10 s, and are soon found
MIXTURE = {"single": 1.0, "none": 1.0, "pair": 1.0, "withheld": 1.0, "stranger": 1.0}
OF_ALL = ("README.md", "answer.schema.json", "machine.toml")  # what every set of a machine has
CASES = sum(map(int, MIXTURE.values()))


def brief(name: str) -> Experiment:
    """10 s of an experiment of the catalogue; what happens in it happens early."""
    known = CATALOGUE[name]
    moves = tuple(move.model_copy(update={"start": move.start - 2}) for move in known.move)
    return known.model_copy(update={"duration": 10.0, "release": known.release and 3.0, "move": moves})


BRIEF = Suite((brief("slew_t"),), (brief("release_bow_horizontal"),))


def make(at: Path, cluster: str | None = None) -> list[int]:
    bench = BoomBench(MACHINE, BRIEF)
    return list(make_cases(CASES, SECRET, bench, MIXTURE, at / "cases", at / "seal.json", 1, cluster))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    at = tmp_path_factory.mktemp("blind")
    assert make(at) == [*range(CASES + 1)]
    return at


def sealed(at: Path) -> dict[str, dict]:
    return json.loads((at / "seal.json").read_text())["cases"]


def test_the_published_hash_is_the_seals(made: Path) -> None:
    assert (made / "cases" / "seal.sha256").read_text().strip() == sha256((made / "seal.json").read_bytes()).hexdigest()
    assert Counter(case["class"] for case in sealed(made).values()) == MIXTURE
    assert not list(made.glob("*.parts"))


def test_cases_differ_in_their_samples_only(made: Path, tmp_path: Path) -> None:
    """Names, order, times and metadata are the same everywhere; a log is its samples and nothing else."""
    cases = sorted(path for path in (made / "cases").iterdir() if path.is_dir())
    assert [case.name for case in cases] == sorted(sealed(made))
    listed = [sorted(str(path.relative_to(case)) for path in case.rglob("*")) for case in cases]
    assert len({*map(tuple, listed)}) == 1 and len(listed[0]) == 2 + 2 + 1
    for path in (made / "cases").rglob("*"):
        assert path.stat().st_mtime == STAMP, path
        assert path.stat().st_mode == next((made / "cases").rglob(path.name)).stat().st_mode
    for path in (made / "cases").rglob("*.mcap"):
        log, known = read_log(path), CATALOGUE[path.stem]
        assert (log.name, log.machine, log.description) == (known.name, "boom36", known.description)
        write_mcap(log, tmp_path / "again.mcap")
        assert (tmp_path / "again.mcap").read_bytes() == path.read_bytes()


def test_no_file_holds_a_word_of_the_seal(made: Path) -> None:
    text = json.loads((made / "seal.json").read_text())
    words = [*effect_library(), *UNLISTED, text["salt"], text["seed_sha256"], "single", "none", "withheld", "stranger"]
    for path in (made / "cases").rglob("*"):
        if path.is_file() and path.name not in ("withhold.json", *OF_ALL):
            content = path.read_bytes()
            assert not [word for word in words if len(word) > 8 and word.encode() in content], path
    assert (made / "cases" / "machine.toml").read_text() == MACHINE
    assert (made / "cases" / "README.md").read_text() == readme()
    assert json.loads((made / "cases" / "answer.schema.json").read_text()) == answer_schema()
    for case, truth in sealed(made).items():
        (listed,) = json.loads((made / "cases" / case / "withhold.json").read_text())["without"]
        assert listed in effect_library()
        assert (listed in [effect["id"] for effect in truth["effects"]]) == (truth["class"] == "withheld")


def test_an_interrupted_making_goes_on_and_ends_in_the_same_seal(made: Path, cluster: str, tmp_path: Path) -> None:
    """As if it had been killed within its healthy case, and went on on a cluster."""
    parts = tmp_path / "seal.parts"
    parts.mkdir()
    for case, truth in sealed(made).items():
        if truth["class"] != "none":
            (parts / f"{case}.json").write_text(json.dumps(truth))
            shutil.copytree(made / "cases" / case, tmp_path / "cases" / case)
    assert make(tmp_path, cluster) == [CASES - 1, CASES]
    assert (tmp_path / "seal.json").read_bytes() == (made / "seal.json").read_bytes()
    for path in (made / "cases").rglob("*.mcap"):
        assert (tmp_path / path.relative_to(made)).read_bytes() == path.read_bytes()


def test_a_case_is_given_as_many_causes_as_are_asked_for(made: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run, asked = import_module("boom_mj.blind.run"), []

    def diagnose(predictor: object, without: tuple[str, ...], most: int | None) -> None:
        asked.append(most)
        raise InputError("asked")

    monkeypatch.setattr(run, "diagnose", diagnose)
    case = next(path.parent for path in (made / "cases").rglob("withhold.json"))
    for most in (None, 4):
        with pytest.raises(InputError, match="asked"):
            run.solve(case, most=most)
    assert asked == [None, 4]


@pytest.mark.slow
def test_from_the_secret_to_the_score(made: Path, cluster: str) -> None:
    """Cases diagnosed in processes that cannot open the seal; an answer that is there stays, others wait."""
    answers, truths = made / "answers", sealed(made)
    answers.mkdir()
    waiting, count = waiting_cases(made / "cases", answers)
    assert ([case.name for case in waiting], count) == (sorted(truths), CASES)
    (healthy,) = [case for case in waiting if truths[case.name]["class"] == "none"]
    assert list(answer_cases([healthy], answers)) == [(healthy, None)]
    first = (answers / f"{healthy.name}.json").read_bytes()
    left, _ = waiting_cases(made / "cases", answers)
    assert left == [case for case in waiting if case != healthy]
    later = [case for case in left if truths[case.name]["class"] in ("pair", "stranger")]
    left = [case for case in left if case not in later]
    assert sorted(answer_cases(left, answers, cluster=cluster)) == [(case, None) for case in left]
    assert (answers / f"{healthy.name}.json").read_bytes() == first
    assert waiting_cases(made / "cases", answers) == (later, CASES)
    found = score(made / "cases", made / "seal.json", answers)
    assert {o.case for o in found.outcomes if not o.right} == {case.name for case in later}, found.outcomes
    ill = next(case for case, truth in truths.items() if truth["class"] == "single")
    (answers / f"{ill}.json").unlink()
    missed = with_hindsight(score(made / "cases", made / "seal.json", answers), made / "cases", made / "seal.json")
    leaves = {o.case: o.truth_leaves for o in missed.outcomes if np.isfinite(o.truth_leaves)}
    assert leaves.keys() == {ill, *(case.name for case in later if truths[case.name]["class"] == "pair")}
    assert [*leaves.values()] == pytest.approx([1, 1], abs=0.06)
