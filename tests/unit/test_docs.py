"""What pages say can be done: commands, every command's help, examples, words, tables of keys, equations, the API."""

import ast
import inspect
import re
import shlex
import sys
import tomllib
from dataclasses import fields
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.core import TyperGroup

from boom_mj.cli import app
from boom_mj.diagnosis.criteria import Criteria, SearchBudget
from boom_mj.effects import Effect, Motion, effect_library, kinds, registry
from boom_mj.logs.topic_map import Entry
from boom_mj.machine import load_machine
from boom_mj.machine.beam import Clamp, Marker
from boom_mj.simulation import load_experiment, make_plant
from boom_mj.simulation.experiments import Chirp, Experiment, Move
from boom_mj.systems.mjcf import load_channel_map
from boom_mj.systems.mjcf.channel_map import ChannelEntry, ChannelMap

sys.path.append(str(Path(__file__).parents[2] / "scripts"))
import site_equations
import site_files
import site_pages

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
KINDS = [k for k in vars(kinds).values() if inspect.isclass(k) and issubclass(k, Effect) and k is not Effect]
GLOSSARY = ROOT / "docs" / "reference" / "glossary.md"
_, _, LIST = GLOSSARY.read_text().partition("## Words that pages do not use")
WORDS = [word for row in re.findall(r"^\| (`.*?) \|", LIST, re.M) for word in re.findall(r"`([^`]+)`", row)]
PRIVATE = re.compile(rf"\b(?:{'|'.join(map(re.escape, WORDS))})\b", re.I)


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


@pytest.mark.usefixtures("own_files")
@pytest.mark.parametrize("call", CALLS)
def test_commands_in_the_pages_are_commands(call: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the Python files of the pages lie: files of effects are read before anything else."""
    for page in PAGES:
        for language, title, text in BLOCK.findall(page.read_text()):
            if language == "python" and title:
                (tmp_path / title).write_text(text)
    monkeypatch.chdir(tmp_path)
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


def test_the_effect_of_the_how_to_is_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (ROOT / "docs" / "how-to" / "add_effect.md").read_text()
    code = {title: text for language, title, text in BLOCK.findall(page) if language == "python"}
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(registry, "_files", {})
    (tmp_path / "tip_rope.py").write_text(code["tip_rope.py"])
    try:
        space: dict = {}
        exec(code["test_tip_rope.py"], space)
        space["test_laws"]()
        rope, boom = effect_library()["tip_rope"], load_machine("boom36")
    finally:
        effect_library.cache_clear()
    force = rope(force=100.0).force(Motion(np.zeros(3), machine=boom))["tip"]
    np.testing.assert_array_equal(force, [[0.0, 100.0, 0.0]] * 3)
    assert make_plant(boom, 1, [rope(force=100.0)]).model.actuator("push_tip_y").id >= 0


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_every_kind_of_effect_is_in_the_how_to(kind: type[Effect]) -> None:
    page = (ROOT / "docs" / "how-to" / "add_effect.md").read_text()
    assert f"`{kind.__name__}`" in page
    assert all(re.search(rf"`{name}[`(]", page) for name in kind.__abstractmethods__)


def words(text: str) -> set[str]:
    """Private words of a text, outside code."""
    plain = re.sub(r"`[^`]*`", "", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S))
    return {match[0].lower() for match in PRIVATE.finditer(plain)}


@pytest.mark.parametrize("page", [page for page in PAGES if page != GLOSSARY], ids=lambda page: page.name)
def test_pages_speak_the_words_of_the_field(page: Path) -> None:
    assert words(page.read_text()) == set()


def test_a_private_word_is_found() -> None:
    assert len(WORDS) > 40
    assert words("A knob of the contest, and `knob` in code.\n```\ntwin\n```\nTwins") == {"knob", "contest", "twins"}


def test_every_key_of_an_answer_is_described() -> None:
    page = (ROOT / "docs" / "reference" / "answer.md").read_text()
    keys = set()
    for path in ("diagnosis/answer.py", "diagnosis/named.py", "diagnosis/sentences.py", "calibration/answer.py"):
        for node in ast.walk(ast.parse((ROOT / "boom_mj" / path).read_text())):
            found = node.keys if isinstance(node, ast.Dict) else ()
            keys |= {key.value for key in found if isinstance(key, ast.Constant)}
    assert {"verdict", "closure", "identifiability"} < keys
    assert [key for key in sorted(keys) if f"`{key}`" not in page] == []


def test_every_key_of_a_file_is_described() -> None:
    page = site_files.with_keys((ROOT / "docs" / "reference" / "files.md").read_text())
    assert "<!--" not in page
    for kind in (Experiment, Move, Chirp, Clamp, Marker, Entry, ChannelMap, ChannelEntry):
        for name, field in kind.model_fields.items():
            assert f"`{field.alias or name}`" in page or f"`[[{name}]]`" in page, f"{kind.__name__}.{name}"


def test_criteria_are_those_of_the_code() -> None:
    page = site_pages.criteria()
    assert all(f"| `{field.name}` |" in page for field in (*fields(Criteria), *fields(SearchBudget)))


def test_the_ten_lines_are_those_of_ten_minutes() -> None:
    lines = [
        text
        for page in ("README.md", "docs/tutorials/ten_minutes.md")
        for language, _, text in BLOCK.findall((ROOT / page).read_text())
        if language == "python"
    ]
    assert len(lines) == 2 and lines[0] == lines[1]
    assert len([line for line in lines[0].splitlines() if line]) == 10


def test_every_equation_has_its_code() -> None:
    page = site_equations.with_code((ROOT / "docs" / "reference" / "equations.md").read_text())
    numbers = [int(number) for number in re.findall(r"^- \*\*\((\d+)\)\*\*", page, re.M)]
    assert numbers == list(range(1, site_equations.LAST + 1))
    assert set(site_equations.mentions()) == set(numbers)
    for path, line in re.findall(r"\]\(code/(\S+)\.md#__codelineno-0-(\d+)\)", page):
        assert len((ROOT / "boom_mj" / f"{path}.py").read_text().splitlines()) >= int(line)


def test_every_public_name_is_documented_and_in_the_reference() -> None:
    count, bare = site_pages.undocumented()
    assert count > 200 and bare == []
    text, index = "\n".join(site_pages.python().values()), site_pages.python_index()
    for room, paths in site_pages.public_paths().items():
        assert f"| [`{room}`](python/{room}.md) |" in index
        assert all(text.count(f"::: {path}\n") == 1 and f"#{path})" in index for path in paths)
