"""Changes of Python that tests should notice: comparisons, signs, operators, constants, conditions, returns."""

import ast
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar


@dataclass(frozen=True)
class Point:
    """Where a file can be changed: the nth of its nodes that can be, and which change."""

    file: str
    line: int
    number: int
    what: str


class Mutation(ast.NodeTransformer):
    """Counts the places where something can be changed, and changes the one that is wanted.

    Comparisons are turned round (`<` to `>=`), as one that only differs at equal numbers says nothing of floats.
    """

    COMPARED: ClassVar = {
        ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
        ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
    }  # fmt: skip
    OPERATED: ClassVar = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult}

    def __init__(self, wanted: int = -1) -> None:
        self.wanted, self.found = wanted, []

    def change(self, node: ast.AST, what: str, changed: Callable[[], ast.AST]) -> ast.AST:
        self.found.append((node.lineno, what))
        return changed() if len(self.found) - 1 == self.wanted else node

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        self.generic_visit(node)
        kind = self.COMPARED[type(node.ops[0])]
        return self.change(
            node, f"{type(node.ops[0]).__name__} to {kind.__name__}",
            lambda: ast.Compare(node.left, [kind(), *node.ops[1:]], node.comparators),
        )  # fmt: skip

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        kind = self.OPERATED.get(type(node.op))
        texts = any(isinstance(n, ast.JoinedStr | ast.Constant) and not _number(n) for n in (node.left, node.right))
        if kind is None or texts:
            return node
        changed = ast.BinOp(node.left, kind(), node.right)
        return self.change(node, f"{type(node.op).__name__} to {kind.__name__}", lambda: changed)

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.AST:
        self.generic_visit(node)
        kind = ast.Or if isinstance(node.op, ast.And) else ast.And
        return self.change(node, f"to {kind.__name__}", lambda: ast.BoolOp(kind(), node.values))

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.op, ast.Not | ast.USub):
            return self.change(node, f"without {type(node.op).__name__}", lambda: node.operand)
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.AST:
        if not isinstance(node.value, bool | int | float):
            return node
        old = node.value
        new = not old if isinstance(old, bool) else old + 1 if isinstance(old, int) else 2 * old or 1.0
        return self.change(node, f"{old} to {new}", lambda: ast.Constant(new))

    def _condition(self, node: Any) -> Any:
        self.generic_visit(node)
        if not isinstance(node.test, ast.Compare | ast.BoolOp | ast.UnaryOp):  # those are changed themselves
            opposite = ast.UnaryOp(ast.Not(), node.test)
            node.test = self.change(node.test, "condition turned round", lambda: opposite)
        return node

    visit_If = visit_IfExp = visit_While = _condition

    def visit_Return(self, node: ast.Return) -> ast.AST:
        self.generic_visit(node)
        if node.value is None or (isinstance(node.value, ast.Constant) and node.value.value is None):
            return node
        return self.change(node, "returns None", lambda: ast.Return(ast.Constant(None)))

    # what decides nothing: annotations, decorators, messages of errors, checks of types

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        if node.value is not None:
            node.value = self.visit(node.value)
        return node

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        node.args.defaults = [self.visit(value) for value in node.args.defaults]
        node.args.kw_defaults = [value and self.visit(value) for value in node.args.kw_defaults]
        node.body = [self.visit(part) for part in node.body]
        return node

    def visit_Raise(self, node: ast.Raise) -> ast.AST:
        return node

    visit_Assert = visit_JoinedStr = visit_Raise

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        protocol = any(isinstance(base, ast.Name) and base.id == "Protocol" for base in node.bases)
        if not protocol:
            node.body = [self.visit(part) for part in node.body]
        return node


def _number(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and isinstance(node.value, int | float)


def points(path: Path, root: Path) -> list[Point]:
    """All places of a file."""
    mutation = Mutation()
    mutation.visit(ast.parse(path.read_text()))
    name = str(path.relative_to(root))
    return [Point(name, line, number, what) for number, (line, what) in enumerate(mutation.found)]


def mutated(path: Path, number: int) -> str:
    """The text with a place changed."""
    tree = Mutation(number).visit(ast.parse(path.read_text()))
    return ast.unparse(ast.fix_missing_locations(tree))
