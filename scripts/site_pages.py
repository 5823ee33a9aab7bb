"""Pages of the documentation that come from the code: a hook of mkdocs (mkdocs.yml), built by scripts/site.

Home is the README, the commands come from the command line's own help, the Python reference from what the rooms
export, effects and criteria from their tables; reference/files.md gets the keys of every file, reference/equations.md
links to the code that says the equations' numbers.
"""

import ast
import inspect
import json
import re
from collections.abc import Mapping, Sequence
from importlib import import_module
from itertools import groupby
from pathlib import Path
from types import ModuleType

import typer
import typer.cli
from pydantic import BaseModel
from site_equations import listing_of, mentions, with_code
from site_files import with_keys

from boom_mj.cli import app
from boom_mj.diagnosis.criteria import described
from boom_mj.effects import BOOM_SITES, Effect, Parameter, Site, builtin

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))
ROOMS = (
    "boom_mj", "boom_mj.errors", "boom_mj.machine", "boom_mj.recording", "boom_mj.effects", "boom_mj.reference",
    "boom_mj.mjcf", "boom_mj.simulation", "boom_mj.sensors", "boom_mj.replay", "boom_mj.logs", "boom_mj.systems.boom",
    "boom_mj.systems.mjcf", "boom_mj.calibration", "boom_mj.diagnosis", "boom_mj.discovery", "boom_mj.blind",
    "boom_mj.report", "boom_mj.testing",
)  # fmt: skip
CRITERIA = "boom_mj.diagnosis.criteria"
SYSTEMS, PROTOCOLS = "boom_mj.systems.", "systems.system"


# What the hook is asked for


def on_files(files, config):  # type: ignore[no-untyped-def]
    """Add the pages that are made of the code."""
    from mkdocs.structure.files import File, InclusionLevel

    pages = {
        "index.md": home((ROOT / "README.md").read_text()),
        "contributing.md": home((ROOT / "CONTRIBUTING.md").read_text()),
        "changelog.md": (ROOT / "CHANGELOG.md").read_text(),
        "reference/commands.md": commands(),
        "reference/python.md": python_index(),
        "reference/effects.md": effects(),
        "reference/criteria.md": criteria(),
        **{notebook_page(path): notebook(path) for path in NOTEBOOKS},
    }
    for name, text in pages.items():
        files.append(File.generated(config, name, content=text))
    for room, text in python().items():
        page = File.generated(config, python_page(room), content=text)
        page.inclusion = InclusionLevel.NOT_IN_NAV
        files.append(page)
    for path in sorted({mention.path for found in mentions().values() for mention in found}):
        text = f'---\nhide: [toc]\n---\n# {path.name}\n\n```python linenums="1"\n{path.read_text()}```\n'
        listing = File.generated(config, listing_of(path), content=text)
        listing.inclusion = InclusionLevel.NOT_IN_NAV
        files.append(listing)
    return files


def on_post_build(config):  # type: ignore[no-untyped-def]
    """Say how much of what the rooms export is documented."""
    count, bare = undocumented()
    print(f"{count - len(bare)} of {count} public names are documented")


def on_page_markdown(markdown, page, config, files):  # type: ignore[no-untyped-def]
    """Link the equations to the code, and fill the tables of files."""
    made = {"reference/equations.md": with_code, "reference/files.md": with_keys}
    return made.get(page.file.src_uri, str)(markdown)


# Home and commands


def home(text: str) -> str:
    """A page of the repository's root as one of the site: docs/ is where it lies now."""
    text = text.replace("](docs/", "](").replace("](CONTRIBUTING.md", "](contributing.md")
    text = text.replace("](CHANGELOG.md", "](changelog.md")
    return re.sub(r"\]\(examples/(\w+)\.ipynb", r"](tutorials/notebooks/\1.md", text)


def notebook_page(path: Path) -> str:
    """Where the page of a notebook lies."""
    return f"tutorials/notebooks/{path.stem}.md"


def notebook(path: Path) -> str:
    """A notebook with what its cells printed and drew, as Markdown."""
    parts = []
    for cell in json.loads(path.read_text())["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(re.sub(r"`(\w+)\.ipynb`", r"[\1](\1.md)", source))
            continue
        parts.append(f"```python\n{source}\n```")
        for output in cell["outputs"]:
            if "text" in output:
                parts.append(f"```text\n{''.join(output['text']).rstrip()}\n```")
            elif "image/png" in output["data"]:
                parts.append(f"![what the cell draws](data:image/png;base64,{output['data']['image/png']})")
    title, _, rest = parts[0].partition("\n")
    note = f"*`examples/{path.name}`: `scripts/notebooks.py` runs it without Jupyter, and a test does.*"
    return "\n\n".join((title, note, rest.strip(), *parts[1:])) + "\n"


def commands() -> str:
    """Every command's help, as Markdown."""
    root = typer.main.get_command(app)
    text = typer.cli.get_docs_for_click(obj=root, ctx=typer.Context(root), name="python -m boom_mj")
    text = re.sub(r"^# .*", "# Commands", text, count=1)
    text = re.sub(r"^#+ `python -m boom_mj (.*)`$", r"## \1", text, flags=re.M)
    return re.sub(r"^Example: (.*)$", r"```console\n$ \1\n```", text, flags=re.M)


# Python


def public_names(module: ModuleType) -> list[str]:
    """What a room exports; of a single file, what it defines."""
    names = getattr(module, "__all__", None) or [
        name
        for name, value in vars(module).items()
        if not inspect.ismodule(value)
        and (hasattr(module, "__path__") or getattr(value, "__module__", None) == module.__name__)
    ]
    return sorted(name for name in names if not name.startswith("_"))


def public_paths() -> dict[str, list[str]]:
    """By room, where what it exports is defined."""
    rooms = {room: import_module(room) for room in ROOMS}
    homes = {room: [_home_of(module, name) for name in public_names(module)] for room, module in rooms.items()}
    return {room: [home for home in found if home.startswith("boom_mj.")] for room, found in homes.items()}


def _home_of(module: ModuleType, name: str) -> str:
    """The module that defines a name, and the name; an `import ... as` is followed through the source."""
    while True:
        for node in ast.walk(ast.parse(inspect.getsource(module))):  # names may be for type checkers only
            if isinstance(node, ast.ImportFrom) and name in {alias.asname or alias.name for alias in node.names}:
                module = import_module(str(node.module))
                break
        else:
            return f"{module.__name__}.{name}"


def python() -> dict[str, str]:
    """A page per room of what it exports; a name that a room above has shown is on that room's page alone."""
    pages, shown = {}, set()
    for room, paths in public_paths().items():
        new = [path for path in paths if path not in shown]
        shown |= set(new)
        lines = [f"# {room}", "", inspect.getdoc(import_module(room)) or "", ""]
        for path in new:
            lines += [f"::: {path}", "    options:", "      heading_level: 2"]
            lines += ["      show_if_no_docstring: true", ""] if _is_table(path) else [""]
        pages[room] = "\n".join(lines)
    return pages


def python_page(room: str) -> str:
    """Where the page of a room lies."""
    return f"reference/python/{room}.md"


def python_index() -> str:
    """Every room with what it exports, each name a link to what is said of it."""
    lines = [
        "# Python",
        "",
        "Typed throughout. The names of the first row come with `from boom_mj import ..`.",
        "",
    ]
    lines += ["| from | what | names |", "|---|---|---|"]
    for room, text in python().items():
        page = python_page(room).removeprefix("reference/")
        names = re.findall(r"^::: (\S+)$", text, re.M)
        links = ", ".join(f"[`{path.rpartition('.')[2]}`]({page}#{path})" for path in names)
        about = (inspect.getdoc(import_module(room)) or "").partition("\n")[0]
        lines.append(f"| [`{room}`]({page}) | {about} | {links} |")
    return "\n".join(lines) + "\n"


def _is_table(path: str) -> bool:
    """Whether the fields of a class are all there is to say, as of machine files."""
    module, _, name = path.rpartition(".")
    thing = getattr(import_module(module), name)
    return isinstance(thing, type) and issubclass(thing, BaseModel)


# Effects


def effects() -> str:
    """The library: physics, sites, parameters with bounds, what each is confused with."""
    lines = ["# Effects", "", "What a machine can have and its file lack. `typical`: a size that matters.", ""]
    lines += ["## Of a boom", ""]
    for kind in builtin().values():
        if sites := kind.allowed(BOOM_SITES):
            lines += [f"### {kind.id}", "", _paragraphs(kind), ""]
            lines += [f"- {key}: {', '.join(choices)}" for key, choices in _choices(sites).items()]
            lines += ["", *_table(kind.parameters(sites[0])), "", _alike(kind), ""]
    lines += ["## Of any MJCF machine", "", "Sizes and sites come from the model and its logs.", ""]
    for kind in builtin().values():
        if "boom" not in kind.needs:
            at = " and ".join(kind.at) or "the whole machine"
            lines += [f"### {kind.id} {{#any-{kind.id}}}", "", _paragraphs(kind), "", f"At: {at}. {_alike(kind)}", ""]
    return "\n".join(lines)


def _choices(sites: Sequence[Site]) -> dict[str, list[str]]:
    """What locations are made of, by key."""
    keys = dict.fromkeys(key for site in sites for key in site.keys)
    return {key: list(dict.fromkeys(str(s.location[key]) for s in sites if key in s.location)) for key in keys}


def _alike(kind: type[Effect]) -> str:
    alike = ", ".join(kind.confused_with) or "nothing known"
    return f"Confused with: {alike}. Separated by: {kind.separating_experiment}."


def _paragraphs(kind: type) -> str:
    return (inspect.getdoc(kind) or "").replace("*", r"\*")


def _table(parameters: Mapping[str, Parameter]) -> list[str]:
    rows = ["| parameter | unit | neutral | from | to | typical |", "|---|---|---|---|---|---|"]
    return rows + [
        f"| {name} | {p.unit} | {p.neutral:g} | {p.low:g} | {p.high:g} | {p.typical:g} |"
        for name, p in parameters.items()
    ]


# Criteria


def criteria() -> str:
    """Every number that decides about an answer."""
    lines = ["# Criteria", "", (inspect.getdoc(import_module(CRITERIA)) or "").replace("\n", " "), ""]
    titles = {"criteria": "What decides", "search": "What is tried"}
    for family, rows in groupby(described(), lambda row: row[0]):
        lines += [
            f"## {titles[family]}",
            "",
            "| name | boom | any MJCF machine | unit | reason |",
            "|---|---|---|---|---|",
        ]
        lines += [
            f"| `{field.name}` | {values['boom']:g} | {values['mjcf']:g} "
            f"| {field.metadata['unit']} | {field.metadata['reason']} |"
            for _, field, values in rows
        ]
        lines += [""]
    return "\n".join([*lines, "`gap criteria` prints the same.", ""])


# How much of it is documented


def undocumented() -> tuple[int, list[str]]:
    """How many names the rooms export, methods and properties included, and those without a docstring.

    Members of a system are documented by the protocols that it meets.
    """
    from griffe import load

    package, count, bare = load("boom_mj", search_paths=[ROOT]), 0, []
    protocols = [kind for kind in package[PROTOCOLS].classes.values() if "Protocol" in map(str, kind.bases)]
    met = {name for kind in protocols for name, member in kind.members.items() if member.has_docstring}
    for path in sorted({path for paths in public_paths().values() for path in paths}):
        found = package[path.removeprefix("boom_mj.")]
        said = {path: found.has_docstring}
        for base in reversed((found, *found.mro())) if found.is_class else ():
            for name, member in base.members.items():
                if not name.startswith("_") and (member.is_function or "property" in member.labels):
                    inherited = said.get(f"{path}.{name}", path.startswith(SYSTEMS) and name in met)
                    said[f"{path}.{name}"] = member.has_docstring or inherited
        count += len(said)
        bare += [name for name, documented in said.items() if not documented]
    return count, bare
