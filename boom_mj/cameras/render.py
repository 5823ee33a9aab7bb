"""A data set from beginning to end: description, plates, chequerboards, frames, and the layouts that people load."""

from collections.abc import Callable, Set
from pathlib import Path

from boom_mj.cameras.dataset import Dataset, claim_folder
from boom_mj.cameras.describe import write_plates
from boom_mj.cameras.film import Film
from boom_mj.cameras.formats import write_bop, write_coco, write_nerfstudio
from boom_mj.cameras.shooting import Frame, Look, missing_frames, render_boards, render_frames
from boom_mj.errors import DatasetError
from boom_mj.files import locked

Report = Callable[[str, int, int], None]
"""Told the stage, and how much of how much of it is done."""
LAYOUTS = ("coco", "nerfstudio", "bop")


def render_dataset(
    film: Film,
    frames: list[Frame],
    look: Look,
    dataset: Dataset,
    folder: Path,
    layouts: Set[str] = frozenset(("coco", "nerfstudio")),
    report: Report = lambda stage, done, total: None,
    jobs: int = 1,
    cluster: str | None = None,
) -> None:
    """Fill a folder with a data set, or finish one that was begun with the same arguments.

    The result is the same to the byte however often it was interrupted, and whoever did the work; for
    `jobs` and `cluster` see `spread`.

    Raises:
        DatasetError: the folder holds something else.
        OutputError: a full disk, or another process fills the folder.
        RenderError: no OpenGL.
        WorkerError: frames that no process survives, when all others are done. What is done stays.
    """
    if folder.exists() and not folder.is_dir():
        raise DatasetError(f"{folder} is a file; a data set needs a folder")
    with locked(folder):
        claim_folder(folder, dataset)
        _fill(film, frames, look, dataset, folder, layouts, report, jobs, cluster)


def _fill(
    film: Film,
    frames: list[Frame],
    look: Look,
    dataset: Dataset,
    folder: Path,
    layouts: Set[str],
    report: Report,
    jobs: int,
    cluster: str | None,
) -> None:
    report("frames", len(frames) - len(missing_frames(frames, folder)), len(frames))
    write_plates(film, folder)
    boards: dict[str, list[Path]] = {}
    for picture in dataset.calibration:
        boards.setdefault(picture.camera, []).append(folder / picture.file)
    report("chequerboards", 0, len(boards))
    render_boards(film, dataset.chequerboard, boards, jobs, cluster)
    report("chequerboards", len(boards), len(boards))
    render_frames(film, frames, look, folder, lambda done, total: report("frames", done, total), jobs, cluster)
    report("layouts", 0, len(layouts))
    if "coco" in layouts:
        write_coco(folder, dataset, [film.model.body(k).name for k in range(film.model.nbody)])
    if "nerfstudio" in layouts:
        write_nerfstudio(folder, dataset)
    if "bop" in layouts:
        write_bop(folder, dataset, film.model)
    report("layouts", len(layouts), len(layouts))
