"""generate: the machine as an MJCF file."""

from pathlib import Path
from typing import Annotated

import typer

from boom_mj.cli.arguments import Hinges, MachineFile, find_model, output_path
from boom_mj.logs import whole_file
from boom_mj.machine import Beam
from boom_mj.mjcf import build, build_beam


def command(
    machine: MachineFile,
    output: Annotated[
        Path | None, typer.Option("-o", metavar="MODEL.xml", help="Where to; stdout if left out.")
    ] = None,
    hinges: Hinges = 1,
) -> None:
    """Write the MJCF model, which stock MuJoCo opens: python -m mujoco.viewer --mjcf=MODEL.xml"""
    if output is not None:
        output_path(output, ".xml")
    found = find_model(machine)
    spec = build_beam(found, hinges) if isinstance(found, Beam) else build(found, hinges).spec
    spec.compile()
    text = spec.to_xml()
    if output is None:
        print(text, end="")
        return
    with whole_file(output) as stream:
        stream.write(text.encode())
    print(output)
