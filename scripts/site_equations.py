"""The page of the equations, with links to the code that says their numbers."""

import ast
import io
import re
import tokenize
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

PACKAGE = Path(__file__).parents[1] / "boom_mj"
LAST = 35  # equation of the paper
EQUATION = re.compile(r"(?<![\w)\]])\((\d\d?)[a-d]?\)(?:-\((\d\d?)\))?|\beqs?\. \(?(\d\d?)\)?(?:, (\d\d?))?")


class Mention(NamedTuple):
    """Where the code says the number of an equation: file, line, and the function, class or module around it."""

    path: Path
    line: int
    owner: str


def mentions() -> dict[int, list[Mention]]:
    """By number, where docstrings and comments say an equation of the paper: modules only where no part of one does."""
    found: dict[int, list[Mention]] = defaultdict(list)
    for path in sorted(set(PACKAGE.rglob("*.py")) - set(PACKAGE.rglob("__init__.py"))):
        source = path.read_text()
        tree = ast.parse(source)
        for line, text in _prose(tree, source):
            owner, start = _around(tree, line)
            name = ".".join((*path.relative_to(PACKAGE).with_suffix("").parts, *owner))
            for number in _numbers(text):
                found[number].append(Mention(path, start, name))
    return {number: _parts(said) for number, said in found.items()}


def _parts(said: list[Mention]) -> list[Mention]:
    """Every owner once, without those that hold another."""
    owners = {mention.owner: mention for mention in said}
    return [m for name, m in sorted(owners.items()) if not any(other.startswith(f"{name}.") for other in owners)]


def _prose(tree: ast.Module, source: str) -> list[tuple[int, str]]:
    """Docstrings (of attributes, too) and comments, with their lines."""
    strings = [
        (node.lineno, node.value.value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    ]
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    return strings + [(token.start[0], token.string) for token in tokens if token.type == tokenize.COMMENT]


def _around(tree: ast.Module, line: int) -> tuple[tuple[str, ...], int]:
    """Names of the classes and functions around a line, and where the innermost begins."""
    names, start, body = [], 1, tree.body
    while True:
        kinds = (ast.ClassDef, ast.FunctionDef)
        inside = [n for n in body if isinstance(n, kinds) and n.lineno <= line <= (n.end_lineno or 0)]
        if not inside:
            return tuple(names), start
        names.append(inside[0].name)
        start, body = inside[0].lineno, inside[0].body


def _numbers(text: str) -> set[int]:
    """Equations that a text names; (13)-(17) are five."""
    found: set[int] = set()
    for first, last, *named in EQUATION.findall(text):
        found |= set(range(int(first), int(last or first) + 1)) if first else {int(n) for n in named if n}
    return {number for number in found if 1 <= number <= LAST}


def with_code(markdown: str) -> str:
    """The equations page, every line of an equation followed by links to the code."""
    found = mentions()

    def linked(match: re.Match[str]) -> str:
        links = [f"[`{m.owner}`]({_link(m)})" for m in found.get(int(match[1]), ())]
        return f"{match[0]}\n  <br>{', '.join(links) or 'not used'}"

    return re.sub(r"^- \*\*\((\d+)\)\*\*.*(?:\n  .*)*", linked, markdown, flags=re.M)


def _link(mention: Mention) -> str:
    return f"{listing_of(mention.path)}#__codelineno-0-{mention.line}"


def listing_of(path: Path) -> str:
    """The page that shows a file of the package."""
    return f"code/{path.relative_to(PACKAGE).with_suffix('.md').as_posix()}"
