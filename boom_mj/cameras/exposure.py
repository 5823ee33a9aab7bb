"""What time and silicon do to a picture: motion blur, rolling shutter, noise."""

from collections.abc import Callable

import numpy as np

from boom_mj.machine import Camera

Array = np.ndarray
WHITE = 255.0


def instants(camera: Camera, blur: int, bands: int) -> Array:
    """Times relative to the stamp at which a frame is rendered, (bands, blur), s.

    Args:
        blur: instants within the exposure; 1 for a sharp picture.
        bands: of rows read out together; 1 for a global shutter.
    """
    read = camera.readout * ((np.arange(bands) + 0.5) / bands - 0.5)
    open_ = camera.exposure * ((np.arange(blur) + 0.5) / blur - 0.5)
    return read[:, None] + open_[None, :]


def expose(picture_at: Callable[[float], Array], times: Array) -> Array:
    """A frame (h, w, 3) uint8 composed of pictures at the times of its row bands, (bands, blur), s."""
    if times.size == 1:
        return picture_at(float(times[0, 0]))
    frame = None
    for band, within in enumerate(times):
        mean = np.mean([picture_at(float(t)) for t in within], axis=0)
        if frame is None:
            frame = np.empty_like(mean)
        start, stop = (len(mean) * (band + k) // len(times) for k in (0, 1))
        frame[start:stop] = mean[start:stop]
    assert frame is not None
    return np.round(frame).astype(np.uint8)


def noisy(picture: Array, camera: Camera, rng: np.random.Generator) -> Array:
    """A picture with read and shot noise, variance read^2 + shot^2 value / 255 in grey levels."""
    value = picture.astype(np.float32)
    deviation = np.sqrt(camera.noise.read**2 + camera.noise.shot**2 * value / WHITE)
    drawn = rng.standard_normal(value.shape, dtype=np.float32)
    return np.clip(np.round(value + deviation * drawn), 0, 255).astype(np.uint8)
