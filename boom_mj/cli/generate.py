"""generate: the machine as an MJCF file."""

from pathlib import Path
from typing import Annotated

import typer

from boom_mj.cli.arguments import Hinges, MachineFile, find_model, output_path
from boom_mj.errors import InputError
from boom_mj.files import write_text


def command(
    machine: MachineFile,
    output: Annotated[
        Path | None, typer.Option("-o", metavar="MODEL.xml|MODEL.urdf", help="Model to write; stdout if left out.")
    ] = None,
    hinges: Hinges = 1,
    urdf: Annotated[bool, typer.Option("--urdf", help="The rigid chain as URDF, which does not bend.")] = False,
) -> None:
    """Write a machine as an MJCF model, which stock MuJoCo opens: python -m mujoco.viewer --mjcf=MODEL.xml

    Keyframes stretched, bow and folded rest under weight, held by the drives.

    Example: python -m boom_mj generate boom36 -o boom.xml --hinges 4
    """
    from boom_mj.machine import Beam
    from boom_mj.mjcf import build, build_beam, urdf_text

    if output is not None:
        output_path(output, ".urdf" if urdf else ".xml")
    found = find_model(machine)
    if urdf and (isinstance(found, Beam) or hinges != 1):
        raise InputError("--urdf is the rigid chain of a boom: without --hinges, and not of a beam")
    if isinstance(found, Beam):
        spec = build_beam(found, hinges)
        spec.compile()
        text = spec.to_xml()
    elif urdf:
        text = urdf_text(found)
    else:
        text = build(found, hinges).to_xml()
    if output is None:
        print(text, end="")
        return
    write_text(output, text)
    print(output)
