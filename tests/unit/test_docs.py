"""What is told can be done: commands in README and docs, every command's help, examples, equations, the public API."""

import importlib.util
import inspect
import re
import shlex
import tomllib
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import typer
from typer.core import TyperGroup

from boom_mj.cli import app
from boom_mj.effects import Effect
from boom_mj.machine import load_machine
from boom_mj.simulation import load_experiment, make_plant
from boom_mj.systems.mjcf import load_channel_map

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
CALL = re.compile(r"python -m boom_mj ((?:\\\n|[^`\n#|>;)])*)")
BLOCK = re.compile(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.M | re.S)
CALLS = [
    pytest.param(call.replace("\\\n", " "), id=f"{page.name}: {call[:60]}")
    for page in PAGES
    for call in CALL.findall(page.read_text())
    if not call.startswith("COMMAND")
]
COMMANDS = {}


def collect(command: typer.core.TyperCommand | TyperGroup, name: str = "") -> None:
    COMMANDS[name.strip()] = command
    for part, below in getattr(command, "commands", {}).items():
        collect(below, f"{name} {part}")


collect(typer.main.get_command(app))


def parse(call: str) -> None:
    """Raise what the command line would say of a call; brackets around what may be left out do not matter."""
    words, command = shlex.split(re.sub(r"[\[\]]", "", call)), COMMANDS[""]
    while isinstance(command, TyperGroup):
        command = command.commands[words.pop(0)]
    command.make_context("boom_mj", words)


def site_pages() -> ModuleType:
    spec = importlib.util.spec_from_file_location("site_pages", ROOT / "scripts" / "site_pages.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


SITE = site_pages()


@pytest.mark.parametrize("call", CALLS)
def test_commands_in_the_pages_are_commands(call: str) -> None:
    parse(call)


def test_a_wrong_command_is_found() -> None:
    for call in ("fly", "generate", "generate boom36 --wings 2", "generate boom36 --hinges many"):
        with pytest.raises(Exception, match=r"fly|Missing|No such option|integer"):
            parse(call)


@pytest.mark.parametrize("name", COMMANDS)
def test_help_teaches(name: str) -> None:
    command = COMMANDS[name]
    assert command.help and len(command.help.split()) > 3
    assert all(p.help for p in command.params if p.name != "help")
    if not isinstance(command, TyperGroup):
        (example,) = re.findall(r"^\s*Example: python -m boom_mj (.*)$", command.help, re.M)
        assert example.startswith(name)
        parse(example)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_blocks_of_code_are_good(page: Path, tmp_path: Path) -> None:
    for language, title, text in BLOCK.findall(page.read_text()):
        if language == "toml":
            tomllib.loads(text)
        if language == "toml" and title:
            (tmp_path / title).write_text(text)
            file = tmp_path / title
            load_channel_map(file) if "[[channel]]" in text else load_experiment(str(file)).check(
                load_machine("boom36")
            )
        if language == "python":
            compile(text, page.name, "exec")
            for module, names in re.findall(r"^from (\S+) import (.+)$", text, re.M):
                assert all(hasattr(import_module(module), name.strip()) for name in names.split(","))


def test_the_effect_of_the_tutorial_is_one() -> None:
    page = (ROOT / "docs" / "tutorials" / "add_effect.md").read_text()
    (code,) = [text for language, title, text in BLOCK.findall(page) if language == "python"]
    space: dict = {}
    exec(code, space)
    rope = next(
        kind for kind in space.values() if inspect.isclass(kind) and issubclass(kind, Effect) and "id" in vars(kind)
    )
    boom = load_machine("boom36")
    force = rope(force=100.0).push(boom, np.zeros(3), np.zeros((3, 5)))["tip"]
    np.testing.assert_array_equal(force, [[0.0, 100.0, 0.0]] * 3)
    assert make_plant(boom, 1, [rope(force=100.0)]).model.actuator("push_tip_y").id >= 0


def test_the_ten_lines_are_those_of_the_tour() -> None:
    lines = [
        text
        for page in ("README.md", "docs/tour.md")
        for language, _, text in BLOCK.findall((ROOT / page).read_text())
        if language == "python"
    ]
    assert len(lines) == 2 and lines[0] == lines[1]
    assert len([line for line in lines[0].splitlines() if line]) == 10


def test_every_equation_has_its_code() -> None:
    page = SITE.with_code((ROOT / "docs" / "equations.md").read_text())
    numbers = [int(number) for number in re.findall(r"^- \*\*\((\d+)\)\*\*", page, re.M)]
    assert numbers == list(range(1, SITE.LAST + 1))
    assert set(SITE.mentions()) == set(numbers)
    for path, line in re.findall(r"\]\(code/(\S+)\.md#__codelineno-0-(\d+)\)", page):
        assert len((ROOT / "boom_mj" / f"{path}.py").read_text().splitlines()) >= int(line)


def test_every_public_name_is_documented_and_in_the_reference() -> None:
    count, bare = SITE.undocumented()
    assert count > 200 and bare == []
    text = SITE.python()
    for paths in SITE.public_paths().values():
        assert all(f"::: {path}\n" in text for path in paths)
