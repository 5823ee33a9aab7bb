"""What the cameras look for: plates on the boom and on the truck, and their pictures.

A marker plate is centred on a marker and stands beside its link: p_plate = p_marker + p_off with p_off along +z of the
link frame on the right side and -z on the left (the offsets of eq. 33). A plate's own frame: u right, v up as its
picture is seen, n out of it; the picture's first row is at the top.
"""

import zlib
from dataclasses import dataclass

import numpy as np

from boom_mj.machine import Machine

Array = np.ndarray
SIDES = {"right": 1.0, "left": -1.0}
CELLS = 10  # features along a plate's longer side: some 4 px each where a boom of 30 m fills 1920 px
TEXELS = 26  # per cell
CONTRAST = (22, 235)  # grey levels


@dataclass(frozen=True, eq=False)
class Plate:
    """A textured rectangle on a body.

    Attributes:
        name: such as marker1_right or reference3.
        body: that carries it; "world" for the truck.
        marker: number of its marker; 0 for a reference plate.
        center: in the body's frame, (3,), m.
        axes: u, v, n of the plate in its columns, body frame, (3, 3).
        size: along u and v, m.
        offset: p_off of eq. (33) along the link's z axis, m; 0 for a reference plate.
    """

    name: str
    body: str
    marker: int
    center: Array
    axes: Array
    size: tuple[float, float]
    offset: float = 0.0

    @property
    def corners(self) -> Array:
        """Upper left, upper right, lower right, lower left, in the body's frame, (4, 3), m."""
        u, v = np.array([(-0.5, 0.5), (0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)]).T * np.array(self.size)[:, None]
        return self.center + np.outer(u, self.axes[:, 0]) + np.outer(v, self.axes[:, 1])


def marker_offset(machine: Machine, link: int) -> float:
    """Distance of the plates of a link (0 to 3) from its neutral axis, m: clear of the pin at its tip."""
    return 0.65 * machine.links[link].width[0] + machine.targets.plates.standoff


def marker_plates(machine: Machine, places: list[tuple[str, Array]]) -> tuple[Plate, ...]:
    """Both plates of every marker, marker1_right, marker1_left, ...

    Args:
        places: body and position in its frame of every marker, root outward.
    """
    plates, per_link = [], len(machine.sensors.markers_x)
    for number, (body, position) in enumerate(places):
        offset = marker_offset(machine, number // per_link)
        for side, sign in SIDES.items():
            axes = np.array([[sign, 0, 0], [0, 1, 0], [0, 0, sign]])
            center = position + np.array([0, 0, sign * offset])
            name, size = f"marker{number + 1}_{side}", machine.targets.plates.size
            plates.append(Plate(name, body, number + 1, center, axes, size, sign * offset))
    return tuple(plates)


def reference_plates(machine: Machine) -> tuple[Plate, ...]:
    """The plates on the truck, in the world frame."""
    plates = []
    for number, plate in enumerate(machine.targets.reference):
        angle = np.radians(plate.facing_deg)
        normal = np.array([np.cos(angle), np.sin(angle), 0])
        up = np.array([0.0, 0.0, 1.0])
        axes = np.column_stack([np.cross(up, normal), up, normal])
        center = np.array(plate.position)
        plates.append(Plate(f"reference{number + 1}", "world", 0, center, axes, machine.targets.reference_size))
    return tuple(plates)


def plate_picture(name: str, size: tuple[float, float]) -> Array:
    """The picture of a plate, (rows, columns) uint8: random blobs that no other plate has, with a light rim.

    Blobs of about one cell, thresholded softly: corners and edges at several scales for KAZE (and nothing finer than a
    far camera resolves). The same name gives the same picture.
    """
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    cells = np.maximum(2, np.round(CELLS * np.array(size[::-1]) / max(size)).astype(int))  # rows, columns
    shape = cells * TEXELS
    row, column = (np.fft.fftfreq(n)[:, None] if k == 0 else np.fft.rfftfreq(n)[None] for k, n in enumerate(shape))
    cycles = np.hypot(row, column) * TEXELS  # per cell
    band = np.exp(-(((cycles - 0.35) / 0.2) ** 2))
    field = np.fft.irfft2(np.fft.rfft2(rng.normal(size=shape)) * band, s=shape)
    blobs = 0.5 + 0.5 * np.tanh(2.2 * field / field.std())
    rim = max(2, TEXELS // 3)
    blobs[:rim], blobs[-rim:], blobs[:, :rim], blobs[:, -rim:] = 1, 1, 1, 1
    return np.round(CONTRAST[0] + (CONTRAST[1] - CONTRAST[0]) * blobs).astype(np.uint8)
