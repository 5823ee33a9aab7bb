"""The cameras that watch a machine, and what they look for: marker plates, reference plates, a chequerboard.

Every section has defaults, so that a machine file without cameras is a machine file. Pixels are OpenCV's: the centre of
the upper left pixel is (0, 0), u runs right, v down.
"""

from typing import Annotated, Self

from pydantic import Field, model_validator

from boom_mj.machine.fields import Frozen, NonNegative, Number, Pair, Point2, Point3, Positive


class ImageNoise(Frozen):
    """Standard deviations in grey levels of 255: `read` everywhere, `shot` at full white, as its root below."""

    read: NonNegative = 1.0
    shot: NonNegative = 3.0


class Camera(Frozen):
    """A camera on a tripod.

    Attributes:
        position, look_at: world, m; the image's horizon is level.
        resolution: width and height, px.
        focal_length: px.
        principal_point: px; the middle of the image if left out.
        distortion: Brown's k1, k2, p1, p2, k3, in OpenCV's order.
        exposure: s, centred on the stamp.
        readout: s from the first row to the last, centred on the stamp (rolling shutter).
        frame_rate_hz: exposures at 0, 1 / rate, .. on the camera's own clock.
        clock_offset: s by which that clock is ahead of the machine's.
    """

    name: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
    position: Point3
    look_at: Point3
    resolution: tuple[Annotated[int, Field(ge=16, le=16384)], Annotated[int, Field(ge=16, le=16384)]] = (1920, 1080)
    focal_length: Pair
    principal_point: Point2 | None = None
    distortion: tuple[Number, Number, Number, Number, Number] = (0.0, 0.0, 0.0, 0.0, 0.0)
    exposure: NonNegative = 0.0
    readout: NonNegative = 0.0
    frame_rate_hz: Positive = 20.0
    clock_offset: Number = 0.0
    noise: ImageNoise = ImageNoise()

    @model_validator(mode="after")
    def _looks_somewhere(self) -> Self:
        away = sum((a - b) ** 2 for a, b in zip(self.position[:2], self.look_at[:2]))
        if away < 1e-6:
            raise ValueError(
                f"{self.name} looks straight up or down from {self.position} to {self.look_at}: it has no horizon"
            )
        if self.exposure + self.readout > 1 / self.frame_rate_hz:
            raise ValueError(f"{self.name}: exposure and readout together are longer than a frame")
        return self


class MarkerPlates(Frozen):
    """Textured plates on both sides of every link, centred on its markers.

    Attributes:
        size: along the link and across, m.
        standoff: from the outermost part of the link to the plate, m.
    """

    size: Pair = (0.8, 0.4)
    standoff: NonNegative = 0.03


class ReferencePlate(Frozen):
    """A plate on the truck with a known place: its centre and the horizontal direction it faces, world."""

    position: Point3
    facing_deg: Number
    """From the x axis to the left: 0 forward, 90 left, -90 right."""


class Chequerboard(Frozen):
    """Inner corners across and down, and the side of a square, m."""

    corners: tuple[Annotated[int, Field(ge=3, le=100)], Annotated[int, Field(ge=3, le=100)]] = (10, 7)
    square: Positive = 0.12


def _on_the_truck() -> tuple[ReferencePlate, ...]:
    """Along both flanks, on the outrigger posts, and on the front."""
    flanks = [(x, side * 1.26, z, side * 90.0) for side in (-1, 1) for x, z in ((-6.2, 1.6), (-4.2, 1.6), (-2.4, 1.6))]
    doors = [(1.9, side * 1.26, 1.5, side * 90.0) for side in (-1, 1)]
    feet = [(x, side * y, side) for side in (-1, 1) for x, y in ((0.9, 3.4), (-6.0, 2.6))]
    posts = [(x, y + 0.15 * side, 1.25, side * 90.0) for x, y, side in feet]
    posts += [(x + 0.15, y, 1.95, 0.0) for x, y, _ in feet]
    front = [(2.96, y, 1.55, 0.0) for y in (-0.6, 0.6)]
    return tuple(
        ReferencePlate(position=(x, y, z), facing_deg=facing) for x, y, z, facing in (*flanks, *doors, *posts, *front)
    )


class Targets(Frozen):
    """What the cameras look for."""

    plates: MarkerPlates = MarkerPlates()
    reference_size: Pair = (0.8, 0.5)
    reference: tuple[ReferencePlate, ...] = Field(default_factory=_on_the_truck)
    chequerboard: Chequerboard = Chequerboard()
