"""track: pictures of a boom to marker positions."""

import json
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from boom_mj.cli.arguments import AsJson, output_path
from boom_mj.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from boom_mj.cameras.chain import Tracking


def command(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Folder of pictures with its dataset.json.")],
    output: Annotated[
        Path | None, typer.Option("-o", metavar="OUT.mcap", help="Recording of the marker positions (m) to write.")
    ] = None,
    picture: Annotated[
        Path | None, typer.Option("--overlay", metavar="PNG", help="Picture to draw: plates and positions.")
    ] = None,
    at: Annotated[float | None, typer.Option(help="Time of the overlay, s; the middle if left out.")] = None,
    film: Annotated[Path | None, typer.Option("--video", metavar="WEBM", help="Video to draw, of the same.")] = None,
    camera: Annotated[str | None, typer.Option(help="Camera of the video; the first if left out.")] = None,
    workers: Annotated[
        int, typer.Option("--jobs", "--workers", min=1, max=64, help="Processes, one per camera at most.")
    ] = 2,
    as_json: AsJson = False,
) -> None:
    """Find the markers in pictures: calibrate lenses and places, follow the plates, give positions where cameras agree.

    Example: python -m boom_mj track film -o markers.mcap --overlay film.png
    """
    for path, suffix in ((output, ".mcap"), (picture, ".png"), (film, ".webm")):
        if path is not None:
            output_path(path, suffix)
    import numpy as np

    from boom_mj.cameras.chain import track

    tracking = track(folder, workers, lambda text: print(text, file=sys.stderr, flush=True))
    if camera is not None and camera not in tracking.tracks:
        raise InputError(f"there is no camera {camera!r}; {folder} has {', '.join(tracking.tracks)}")
    if output is not None:
        from boom_mj.logs import write_mcap
        from boom_mj.logs.pictures import covariance_messages

        covariance = covariance_messages(tracking.time, tracking.positions.covariance)
        write_mcap(tracking.recording, output, also=covariance)
    if picture is not None:
        from boom_mj.cameras.pictures import overlay

        overlay(folder, tracking, float(np.median(tracking.time)) if at is None else at, picture)
    if film is not None:
        from boom_mj.cameras.pictures import video

        video(folder, tracking, camera or next(iter(tracking.tracks)), film)
    print(json.dumps(_document(tracking), indent=1) if as_json else _table(tracking))
    for path in (output, picture, film):
        if path is not None:
            print(f"wrote {path}", file=sys.stderr)


def _deviations(tracking: "Tracking") -> "np.ndarray":
    """Mean standard deviation of every marker along x, y, z, (m, 3), m; NaN for one that was never seen."""
    import numpy as np

    variance = np.einsum("nmaa->nma", tracking.positions.covariance)
    there = np.isfinite(variance)
    with np.errstate(invalid="ignore"):
        mean = np.where(there, variance, 0).sum(axis=0) / there.sum(axis=0)
    return np.asarray(np.sqrt(mean))


def _document(tracking: "Tracking") -> dict:
    deviations = [[None if math.isnan(v) else float(v) for v in row] for row in _deviations(tracking)]
    cameras = {
        name: {
            "lens_rms_px": tracking.lenses[name].rms,
            "focal_px": list(tracking.lenses[name].intrinsics.focal),
            "center_px": list(tracking.lenses[name].intrinsics.center),
            "distortion": list(tracking.lenses[name].intrinsics.distortion),
            "position_m": tracking.places[name].view.position.tolist(),
            "reference_rms_px": tracking.places[name].rms,
            "reference_plates": list(tracking.places[name].plates),
        }
        for name in tracking.tracks
    }
    markers = [
        {"marker": k + 1, "share": float(share), "deviation_m": deviation}
        for k, (share, deviation) in enumerate(zip(tracking.share, deviations))
    ]
    contradictory = tracking.positions.contradictory
    return {"frames": len(tracking.time), "cameras": cameras, "markers": markers, "contradictory": contradictory}


def _table(tracking: "Tracking") -> str:
    lines = [f"{tracking.dataset.name}: {len(tracking.time)} frames; standard deviations in mm"]
    lines.append("marker   share      x      y      z")
    for k, (share, row) in enumerate(zip(tracking.share, 1000 * _deviations(tracking))):
        lines.append(f"{k + 1:6d}{100 * share:7.1f}%" + "".join(f"{v:7.1f}" for v in row))
    return "\n".join(lines)
