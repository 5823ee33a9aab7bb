"""Runs the notebooks of examples/, cell by cell in one namespace, and writes what they print and draw into them.

    python scripts/notebooks.py [NOTEBOOK.ipynb ...] [-o FOLDER]

Without -o the notebooks themselves are written. Jupyter is not needed; nothing that changes from run to run - counts,
times, the kernel's version - is kept. tests/unit/test_notebooks.py holds what is committed against a run.
"""

import argparse
import ast
import base64
import contextlib
import io
import json
import os
import sys
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

EXAMPLES = Path(__file__).parents[1] / "examples"
DPI = 72


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("notebooks", nargs="*", type=Path)
    parser.add_argument("-o", dest="folder", type=Path)
    given = parser.parse_args()
    for path in given.notebooks or sorted(EXAMPLES.glob("*.ipynb")):
        target = (given.folder or path.parent) / path.name
        notebook = json.loads(path.read_text())
        with contextlib.chdir(path.parent):
            done = executed(notebook)
        target.write_text(json.dumps(done, indent=1, ensure_ascii=False) + "\n")
        print(os.path.relpath(target), file=sys.stderr)


def executed(notebook: dict[str, Any]) -> dict[str, Any]:
    """A notebook with its outputs made anew, and without what a run leaves beside them."""
    space: dict[str, Any] = {"__name__": "__main__"}
    cells = []
    for number, cell in enumerate(notebook["cells"]):
        kept = {"cell_type": cell["cell_type"], "id": f"cell-{number}", "metadata": {}, "source": cell["source"]}
        if cell["cell_type"] == "code":
            kept |= {"execution_count": None, "outputs": outputs("".join(cell["source"]), space)}
        cells.append(kept)
    kernel = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    return {"cells": cells, "metadata": kernel, "nbformat": 4, "nbformat_minor": 5}


def outputs(source: str, space: dict[str, Any]) -> list[dict[str, Any]]:
    """Run a cell; what it prints, its last expression and its figures."""
    tree, printed = ast.parse(source), io.StringIO()
    last = ast.Expression(tree.body.pop().value) if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), space)
        value = eval(compile(last, "cell", "eval"), space) if last else None
    found: list[dict[str, Any]] = []
    if printed.getvalue():
        found.append({"name": "stdout", "output_type": "stream", "text": lines(printed.getvalue())})
    if value is not None:
        found.append({"data": {"text/plain": lines(repr(value))}, "metadata": {}, "output_type": "display_data"})
    for number in plt.get_fignums():
        stream = io.BytesIO()
        plt.figure(number).savefig(stream, dpi=DPI, metadata={"Software": None})
        picture = base64.b64encode(stream.getvalue()).decode()
        found.append({"data": {"image/png": picture}, "metadata": {}, "output_type": "display_data"})
    plt.close("all")
    return found


def lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


if __name__ == "__main__":
    main()
