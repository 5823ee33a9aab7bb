"""Machine files: from TOML to a machine of its kind, and what is wrong with those that are none."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from boom_mj.errors import MachineFileError, shown
from boom_mj.files import parse_toml, read_text
from boom_mj.machine.beam import Beam
from boom_mj.machine.fields import Frozen
from boom_mj.machine.model import Machine

MODELS = tuple(folder / "models" for folder in Path(__file__).parents[1:3])  # of the wheel, of the repository
Kind = TypeVar("Kind", bound=Frozen)


def machine_file(name: Path | str) -> Path:
    """The file of a machine that comes with the package, by a name such as "boom36"; any other path as it is."""
    shipped = (folder / f"{name}.toml" for folder in MODELS if not Path(name).suffix)
    return next((path for path in shipped if path.is_file()), Path(name))


def load_machine(path: Path | str) -> Machine:
    """Read the machine file of a boom, or one that comes with the package by its name.

    Raises:
        MachineFileError: the file is missing, is no TOML, or holds bad values; every one of them is listed with its
            place, the value and what is allowed.
    """
    return parse_machine(read_text(machine_file(path), MachineFileError), str(path))


def parse_machine(text: str, source: str = "machine file") -> Machine:
    """The boom that a TOML text describes; see `load_machine`."""
    return _parse(Machine, text, source)


def load_model(path: Path | str) -> Machine | Beam:
    """Read a machine file of any kind: `kind = "beam"` is a beam, all others are booms.

    Raises:
        MachineFileError: see `load_machine`.
    """
    text = read_text(machine_file(path), MachineFileError)
    beam = parse_toml(text, path, MachineFileError).get("kind") == "beam"
    return _parse(Beam, text, str(path)) if beam else _parse(Machine, text, str(path))


def _parse(kind: type[Kind], text: str, source: str) -> Kind:
    """A machine of some kind from a TOML text; see `load_machine`."""
    content = parse_toml(text, source, MachineFileError)
    try:
        return kind.model_validate(content)
    except ValidationError as error:
        raise MachineFileError("\n".join(f"{source}: {line}" for line in _sentences(kind, error))) from error


def with_values(machine: Machine, values: Mapping[str, float]) -> Machine:
    """The machine with other numbers at places of its file: "link3.mass", "damping.bending", "link2.wall.0".

    Raises:
        MachineFileError: there is no such number, with what there is; or a value that is not allowed.
    """
    content: dict[str, Any] = machine.model_dump(mode="json")
    content |= {link["name"]: link for link in content.pop("link")}
    for place, value in values.items():
        node: Any = content
        parts = place.split(".")
        for k, part in enumerate(parts):
            keys = {str(key): key for key in (range(len(node)) if isinstance(node, list) else node)}
            if part not in keys or isinstance(node[keys[part]], dict | list) != (k + 1 < len(parts)):
                within = f"in {'.'.join(parts[:k])}" if k else "at its top"
                raise MachineFileError(f"the machine file has no number {place}; {within} there are {', '.join(keys)}")
            holder, key, node = node, keys[part], node[keys[part]]
        if not isinstance(node, int | float):
            raise MachineFileError(f"the machine file has no number {place}: it is {node!r}")
        holder[key] = value
    content["link"] = [content.pop(link.name) for link in machine.link]
    try:
        return Machine.model_validate(content)
    except ValidationError as error:
        raise MachineFileError("; ".join(_sentences(Machine, error))) from error


def _sentences(machine: type[Frozen], error: ValidationError) -> list[str]:
    """One line per bad value: its place, the value, what is allowed; of a machine of another kind, that alone."""
    lines, errors = [], error.errors()
    for item in [item for item in errors if item["loc"] == ("kind",)] or errors:
        place, kind, value = _place(machine, item["loc"]), item["type"], item["input"]
        if kind == "missing":
            lines.append(f"{place} is missing")
        elif kind == "extra_forbidden":
            known = ", ".join(_known(machine, item["loc"][:-1]))
            lines.append(f"{place} = {shown(value)}: unknown key; known here: {known}")
        elif kind == "value_error":
            message = item["msg"].removeprefix("Value error, ")
            after = "" if isinstance(value, dict) else f" = {shown(value)}"
            lines.append(f"{place}{after}: {message}" if place else message)
        else:
            lines.append(f"{place} = {shown(value)}: {item['msg'][0].lower()}{item['msg'][1:]}")
    return lines


def _place(machine: type[Frozen], location: tuple[int | str, ...]) -> str:
    """Where in the file, as its reader would say it: link3.wall.1 of a boom rather than link.1.wall.1."""
    match location:
        case ("link", int(index), *rest) if machine is Machine:
            location = (f"link{index + 2}", *rest)
    return ".".join(str(part) for part in location)


def _known(machine: type[Frozen], location: tuple[int | str, ...]) -> list[str]:
    """The keys that the machine file knows at a place."""
    model: type[BaseModel] = machine
    for part in location:
        if isinstance(part, str):
            annotation = model.model_fields[part].annotation
            kinds = (annotation, *get_args(annotation))
            model = next(kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel))
    return sorted(model.model_fields)
