"""validate: MuJoCo's hinges against the Lagrangian reference."""

import json
from typing import TYPE_CHECKING, Annotated

import typer

from boom_mj.cli.arguments import AsJson, MachineFile, find_machine

if TYPE_CHECKING:
    import numpy as np

    from boom_mj.simulation.agreement import Agreement


def command(
    machine: MachineFile,
    poses: Annotated[int, typer.Option(min=1, help="Random poses within the joint limits.")] = 200,
    hinges: Annotated[
        list[int] | None, typer.Option(help="Hinges per elastic coordinate; may be given several times.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the poses.")] = 0,
    as_json: AsJson = False,
) -> None:
    """Compare MuJoCo's tip deflections and frequencies with the Lagrangian reference's over random poses, in %.

    Example: python -m boom_mj validate boom36 --poses 20 --hinges 1 --hinges 4
    """
    from rich.console import Console
    from rich.progress import Progress

    from boom_mj.simulation.agreement import compare_models, random_poses

    boom = find_machine(machine)
    places, found = random_poses(boom, poses, seed), []
    console = Console(stderr=True)
    for count in hinges or [1]:
        with Progress(console=console, disable=not console.is_terminal) as bar:
            task = bar.add_task(f"hinges = {count}", total=poses)
            found.append(compare_models(boom, count, places, lambda done: bar.update(task, completed=done)))  # noqa: B023
        if not console.is_terminal:
            console.print(f"compared {poses} poses at hinges = {count}", highlight=False)
    print(json.dumps(_document(boom.name, found), indent=1) if as_json else "\n\n".join(map(_table, found)))


def _document(name: str, found: "list[Agreement]") -> dict:
    import numpy as np

    from boom_mj.simulation.agreement import FIGURES

    def figures(differences: "np.ndarray") -> dict:
        size = np.abs(differences)
        return {
            figure: {"worst": float(size[:, k].max()), "median": float(np.median(size[:, k]))}
            for k, figure in enumerate(FIGURES)
        }

    return {
        "machine": name,
        "poses": len(found[0].poses),
        "hinges": {
            str(a.hinges): {
                **figures(a.paper),
                "finite_rotations": figures(a.finite),
                "mass_matrix_worst": [{"row": r, "column": c, "difference": d} for r, c, d in a.mass_entries],
            }
            for a in found
        },
    }


def _table(a: "Agreement") -> str:
    import numpy as np

    from boom_mj.simulation.agreement import FIGURES

    lines = [
        f"hinges = {a.hinges}: MuJoCo against the reference over {len(a.poses)} poses, percent",
        f"{'':14}{'median':>9}{'95 %':>9}{'worst':>9}{'worst, finite rotations':>25}   worst pose, deg",
    ]
    for k, figure in enumerate(FIGURES):
        size, like = 100 * np.abs(a.paper[:, k]), 100 * np.abs(a.finite[:, k])
        pose = " ".join(f"{angle:.0f}" for angle in np.degrees(a.poses[np.argmax(size)]))
        numbers = f"{np.median(size):9.2f}{np.quantile(size, 0.95):9.2f}{size.max():9.2f}{like.max():25.2f}"
        lines.append(f"{figure:14}{numbers}   {pose}")
    entries = ", ".join(f"({row}, {column}) {100 * value:+.1f}" for row, column, value in a.mass_entries)
    lines.append(f"mass matrix, worst entries in percent of the root of their diagonal entries: {entries}")
    return "\n".join(lines)
