"""MJCF files of other people's: what they name lies in their folder, and they are as large as they look.

MuJoCo opens whatever a file names, and builds as much as it says; so it is looked through before.
"""

import math
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import mujoco

from boom_mj.errors import InputError
from boom_mj.files import PNG_HEAD, inside, png_pixels, read_text

LONGEST = 2**24  # bytes of an MJCF file
MOST_FILES, MOST_ELEMENTS, MOST_TEXELS, MOST_FREEDOM = 100, 100_000, 2**26, 2000
COUNTS = ("count",)  # of replicate, flexcomp and the like: copies of what is within
SIZES = (("width", "height"), ("nrow", "ncol"), ("nsample",), ("nuserdata",))
FOLDERS = {"mesh": "meshdir", "hfield": "meshdir", "skin": "meshdir", "texture": "texturedir"}


def load_model(path: Path) -> mujoco.MjSpec:
    """A model that compiles; bodies and joints without a name get one by their number, such as "body 3".

    Raises:
        InputError: no MJCF file; one that names files outside its folder, or is huge; one that MuJoCo does not take.
    """
    _look_through(path, path.parent, [path])
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        freedom = spec.copy().compile().nv
    except (ValueError, mujoco.FatalError, mujoco.UnexpectedError) as error:
        raise InputError(f"{path} is no MJCF model: {error}") from error
    if not 0 < freedom <= MOST_FREEDOM:
        raise InputError(f"{path} has {freedom} degrees of freedom; a machine has 1 to {MOST_FREEDOM}")
    for kind, elements in (("body", spec.bodies), ("joint", spec.joints)):
        for number, element in enumerate(elements):
            element.name = element.name or f"{kind} {number}"
    return spec


def _look_through(path: Path, folder: Path, seen: list[Path]) -> None:
    """Refuse what a file must not say; the files that it includes likewise."""
    text = read_text(path, InputError, LONGEST)
    if "<!ENTITY" in text:
        raise InputError(f"{path} defines entities; MJCF knows none")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, RecursionError, ValueError) as error:
        raise InputError(f"{path} is no MJCF model: {error}") from error
    compiler = {key: value for element in root.iter("compiler") for key, value in element.attrib.items()}
    copies = 0.0
    for element, times in _with_copies(root):
        copies += times
        if copies > MOST_ELEMENTS:
            raise InputError(f"{path} has more than {MOST_ELEMENTS} elements, the copies of <{element.tag}> counted")
        for names in SIZES:
            if math.prod(_number(element.get(name, "1")) for name in names) > MOST_TEXELS:
                raise InputError(f"{path}: <{element.tag}> is larger than {' x '.join(names)} = {MOST_TEXELS}")
        own = FOLDERS.get(element.tag)
        within = compiler.get(own, compiler.get("assetdir", "")) if own else ""
        for key, name in element.attrib.items():
            if not key.startswith("file") or not name:
                continue
            file = inside(folder, str(Path(within, name)), InputError, path)
            if element.tag in ("include", "model") and file not in seen:
                if len(seen) == MOST_FILES:
                    raise InputError(f"{path} leads to more than {MOST_FILES} files")
                seen.append(file)
                if not file.is_file():
                    raise InputError(f"{path} names {file}, but there is no such file")
                _look_through(file, folder, seen)
            elif file.is_file() and (texels := png_pixels(_head(file))) > MOST_TEXELS:
                raise InputError(f"{path} names {file}, which has {texels} pixels; up to {MOST_TEXELS} are loaded")


def _with_copies(root: ElementTree.Element) -> Iterator[tuple[ElementTree.Element, float]]:
    """All elements, and how many of each there will be."""
    waiting = [(root, 1.0)]
    while waiting:
        element, times = waiting.pop()
        times *= math.prod(max(_number(element.get(name, "1")), 1.0) for name in COUNTS)
        yield element, times
        waiting += [(child, times) for child in element]


def _number(text: str) -> float:
    """The product of the numbers in an attribute; 1 if there are none."""
    try:
        return math.prod(float(word) for word in text.split())
    except ValueError:
        return 1.0


def _head(path: Path) -> bytes:
    with path.open("rb") as stream:
        return stream.read(PNG_HEAD)
