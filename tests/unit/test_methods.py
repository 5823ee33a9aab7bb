"""The methods of the benchmark: each answers a short case in the form that the schema asks for."""

import importlib
import json
import re
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from boom_mj.blind import BoomBench, Suite, make_cases, read_answer
from boom_mj.simulation import CATALOGUE, Experiment

ROOT = Path(__file__).parents[2]
METHODS = ROOT / "benchmarks" / "methods"
MACHINE = (ROOT / "models" / "boom24.toml").read_text()


def brief(name: str) -> Experiment:
    known = CATALOGUE[name]
    return known.model_copy(update={"duration": 4.0, "release": 1.0, "move": ()})


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A case of one effect on the second boom, 4 s a recording."""
    at = tmp_path_factory.mktemp("methods")
    bench = BoomBench(MACHINE, Suite((brief("release_bow_vertical"),), (brief("release_bow_horizontal"),)))
    list(make_cases(1, b"everybody may read it", bench, {"single": 1.0}, at / "cases", at / "seal.json", 1))
    return next((at / "cases").glob("*/train")).parent


@pytest.fixture
def method(monkeypatch: pytest.MonkeyPatch):
    def imported(name: str) -> ModuleType:
        monkeypatch.syspath_prepend(str(METHODS))
        return importlib.import_module(name)

    return imported


def test_a_set_of_cases_tells_what_is_asked(case: Path) -> None:
    schema = json.loads((case.parent / "answer.schema.json").read_text())
    assert schema["required"] == ["verdict", "effects"]
    assert (case.parent / "README.md").read_text().startswith("# What is wrong with these machines?")


def test_the_example_of_the_how_to_answers(case: Path, method, tmp_path: Path) -> None:
    (tmp_path / f"{case.name}.json").write_text(json.dumps(method("example").answer(case)))
    assert read_answer(tmp_path / f"{case.name}.json")["verdict"] in ("explained", "consistent", "unexplained")
    page = (ROOT / "docs" / "how-to" / "benchmark.md").read_text()
    (shown,) = re.findall(r'^```python title="example.py"\n(.*?)^```$', page, re.M | re.S)
    assert shown == (METHODS / "example.py").read_text()


@pytest.mark.parametrize("name", ["location", "machine_parameters", "single_effects"])
def test_methods_answer(case: Path, method, name: str, tmp_path: Path) -> None:
    more = {"fitted": 1} if name == "single_effects" else {}
    answer, cases = method(name).solve(method("cases").read_case(case), **more), method("cases")
    cases.answer_all(case.parent, tmp_path, lambda read: answer)
    found = read_answer(tmp_path / f"{case.name}.json")
    assert found["cpu_s"] >= 0 and found["verdict"] in ("explained", "consistent")


class Forest:
    """Two classes, the second of which a case may withhold."""

    classes_ = ("nothing", '{"id": "tip_payload", "location": {}}')

    def predict_proba(self, rows: list[np.ndarray]) -> list[list[float]]:
        assert np.isfinite(rows).all()
        return [[0.4, 0.6]]


def test_a_classifier_counts_what_is_withheld_as_outside(case: Path, method) -> None:
    classifier, cases = method("classifier"), method("cases")
    read = cases.read_case(case)
    model = classifier.linearise(read.predictor())
    named = classifier.solve(cases.Case(read.name, (), read.system, read.data), model, Forest())
    assert named["effects"] == [{"id": "tip_payload", "location": {}, "probability": 0.6}]
    barred = classifier.solve(cases.Case(read.name, ("tip_payload",), read.system, read.data), model, Forest())
    assert (barred["verdict"], barred["effects"]) == ("unexplained", [])
    assert barred["others"] == {"none": 0.4, "outside_library": 0.6}
    assert [classifier.label({"class": k, "effects": []}) for k in ("none", "stranger")] == ["nothing", "outside"]
