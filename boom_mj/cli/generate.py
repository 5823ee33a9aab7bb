"""generate: the machine as an MJCF file."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from boom_mj.cli.arguments import AsJson, Hinges, MachineFile, find_model, output_path
from boom_mj.errors import InputError
from boom_mj.files import write_text


def command(
    machine: MachineFile,
    output: Annotated[
        Path | None, typer.Option("-o", metavar="MODEL.xml|MODEL.urdf", help="Model to write; stdout if left out.")
    ] = None,
    hinges: Hinges = 1,
    urdf: Annotated[bool, typer.Option("--urdf", help="The rigid chain as URDF, which does not bend.")] = False,
    as_json: AsJson = False,
) -> None:
    """Write a machine as an MJCF model, which stock MuJoCo opens: python -m mujoco.viewer --mjcf=MODEL.xml

    Keyframes stretched, bow and folded rest under weight, held by the drives.

    Example: python -m boom_mj generate boom36 -o boom.xml --hinges 4
    """
    from boom_mj.machine import Beam
    from boom_mj.mjcf import build, build_beam, urdf_text

    if as_json and output is None:
        raise InputError("--json tells of a file: say which with -o")
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
    print(json.dumps(_document(found.name, output, text, hinges), indent=1) if as_json else output)


def _document(machine: str, path: Path, text: str, hinges: int) -> dict[str, Any]:
    import mujoco

    model = mujoco.MjModel.from_xml_string(text)
    return {
        "machine": machine,
        "model": str(path),
        "format": path.suffix.lstrip(".").replace("xml", "mjcf"),
        "hinges": hinges,
        "degrees_of_freedom": model.nv,
        "keyframes": [model.key(k).name for k in range(model.nkey)],
        "sensors": [model.sensor(k).name for k in range(model.nsensor)],
    }
