"""The package's door and the command line's help import nothing that they do not need."""

import ast
import subprocess
import sys
from pathlib import Path
from types import FunctionType, ModuleType

import pytest

import boom_mj
import boom_mj.report
from boom_mj.cli.arguments import EXPERIMENTS
from boom_mj.simulation import CATALOGUE

HEAVY = {"cv2", "matplotlib", "jinja2", "scipy", "rosbags", "mcap", "distributed", "mujoco", "numpy"}
ROOT = Path(__file__).parents[2]


def imported_by(code: str) -> set[str]:
    show = f"import sys; print(*sys.modules); {code}; print(*sys.modules, file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", show], cwd=ROOT, capture_output=True, text=True, check=True)
    return {name.partition(".")[0] for name in done.stderr.splitlines()[-1].split()}


@pytest.mark.parametrize(
    "code",
    [
        "import boom_mj",
        "import boom_mj.report",
        "from boom_mj.cli import run; run(['--help'])",
        "from boom_mj.cli import run; run(['gap', 'diagnose', '--help'])",
        "from boom_mj.cli import run; run(['--version'])",
    ],
)
def test_nothing_heavy_comes_with(code: str) -> None:
    assert imported_by(code) & HEAVY == set()


def test_reading_a_machine_needs_no_way_to_draw() -> None:
    assert imported_by("from boom_mj import load_machine") & {"cv2", "matplotlib", "jinja2", "rosbags"} == set()


@pytest.mark.parametrize("package", [boom_mj, boom_mj.report])
def test_what_type_checkers_see_is_what_the_door_gives(package: ModuleType) -> None:
    (block,) = (node for node in ast.parse(Path(str(package.__file__)).read_text()).body if isinstance(node, ast.If))
    seen = {alias.asname: node.module for node in block.body for alias in node.names}
    assert sorted(seen) == package.__all__ == dir(package)
    for name, home in seen.items():
        assert getattr(package, name) is getattr(sys.modules[home], name)
    with pytest.raises(AttributeError, match=r"has no 'nonsense'; it has .*, "):
        package.nonsense  # noqa: B018


def test_a_function_keeps_its_name_from_a_room_of_the_same_name() -> None:
    show = "import boom_mj.replay.quality; from boom_mj import replay; print(type(replay).__name__)"
    for code in (show, "from boom_mj import replay; " + show, "import boom_mj.replay; " + show):
        done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
        assert done.stdout == f"{FunctionType.__name__}\n", done.stderr


def test_the_help_names_every_experiment() -> None:
    assert tuple(CATALOGUE) == EXPERIMENTS
