"""The notebooks of examples/: each runs in a process and a folder of its own, and says what is committed."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from test_docs import words
from test_tour import missing

ROOT = Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))


def test_there_is_one_for_each_of_the_main_jobs() -> None:
    assert {path.stem for path in NOTEBOOKS} == {"simulate", "replay", "diagnose", "calibrate"}


def read(path: Path) -> list[dict[str, Any]]:
    return json.loads(path.read_text())["cells"]


def printed(cell: dict[str, Any]) -> str:
    return "".join(line for output in cell["outputs"] for line in output.get("text", ()))


@pytest.mark.slow
def test_notebooks_run_and_say_what_is_committed(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "examples", tmp_path / "examples", ignore=shutil.ignore_patterns("*.mcap.tmp"))
    (tmp_path / "out").mkdir()
    for path in NOTEBOOKS:
        call = (sys.executable, ROOT / "scripts" / "notebooks.py", tmp_path / "examples" / path.name)
        done = subprocess.run(
            [*call, "-o", tmp_path / "out"], cwd=tmp_path, capture_output=True, text=True, timeout=300
        )
        assert done.returncode == 0, done.stderr
        assert "Warning" not in done.stderr and "WARNING" not in done.stderr, done.stderr
        for kept, again in zip(read(path), read(tmp_path / "out" / path.name), strict=True):
            assert kept["source"] == again["source"]
            if kept["cell_type"] == "code":
                assert missing(printed(kept), printed(again)) is None, f"{path.name}\n{printed(again)}"
                assert [set(o.get("data", ())) for o in kept["outputs"]] == [
                    set(o.get("data", ())) for o in again["outputs"]
                ]
    assert not (tmp_path / "examples" / "MUJOCO_LOG.TXT").exists()


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_hold_outputs_and_nothing_that_changes(path: Path) -> None:
    text = path.read_text()
    assert re.search(r'"(execution_count": [^n]|execution"|image/svg|collapsed)', text) is None
    cells = [cell for cell in read(path) if cell["cell_type"] == "code"]
    assert any("image/png" in output.get("data", ()) for cell in cells for output in cell["outputs"])
    assert sum(bool(printed(cell)) for cell in cells) >= 1
    assert len(text) < 150_000 and all(cell["metadata"] == {} for cell in read(path))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_speak_the_words_of_the_field(path: Path) -> None:
    assert words("\n".join("".join(cell["source"]) for cell in read(path) if cell["cell_type"] == "markdown")) == set()
