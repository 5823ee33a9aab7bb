"""What cameras add to a log: pictures, camera models, and how sure tracked positions are."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from boom_mj.cameras.dataset import Dataset
from boom_mj.errors import DatasetError
from boom_mj.files import read_bytes, read_json
from boom_mj.logs.messages import make

Array = np.ndarray
COVARIANCE = "/markers/covariance"


def picture_messages(folder: Path, dataset: Dataset) -> Iterator[tuple[int, str, Any]]:
    """Stamp in ns, topic and message: /camera/K/image/compressed and /camera/K/camera_info of a rendered data set.

    K counts the cameras from 1, in the order of the description.
    """
    numbers = {camera.name: k + 1 for k, camera in enumerate(dataset.cameras)}
    for frame in sorted(dataset.frames, key=lambda frame: (frame.stamp, numbers[frame.camera])):
        stamp, place = round(frame.stamp * 1e9), f"/camera/{numbers[frame.camera]}"
        path = folder / frame.file
        header = _header(stamp, frame.camera)
        kind = "jpeg" if path.suffix == ".jpg" else path.suffix[1:]
        data = np.frombuffer(read_bytes(path, DatasetError), np.uint8)
        picture = make("sensor_msgs/msg/CompressedImage", header=header, format=kind, data=data)
        yield stamp, f"{place}/image/compressed", picture
        label = folder / Path(frame.file.replace("images/", "labels/", 1)).with_suffix(".json")
        yield stamp, f"{place}/camera_info", _camera_info(header, read_json(label, DatasetError))


def covariance_messages(time: Array, covariance: Array) -> Iterator[tuple[int, str, Any]]:
    """Covariances of marker positions, (n, m, 3, 3) m^2, as std_msgs/msg/Float64MultiArray; NaN where hidden."""
    names, shape = ("marker", "row", "column"), covariance.shape[1:]
    sizes = [int(np.prod(shape[k:])) for k in range(len(shape))]
    dims = [
        make("std_msgs/msg/MultiArrayDimension", label=name, size=size, stride=stride)
        for name, size, stride in zip(names, shape, sizes)
    ]
    layout = make("std_msgs/msg/MultiArrayLayout", dim=dims, data_offset=0)
    for stamp, values in zip(np.round(time * 1e9).astype(np.int64), covariance):
        yield int(stamp), COVARIANCE, make("std_msgs/msg/Float64MultiArray", layout=layout, data=values.ravel())


def _header(stamp: int, frame: str) -> Any:
    time = make("builtin_interfaces/msg/Time", *divmod(stamp, 10**9))
    return make("std_msgs/msg/Header", stamp=time, frame_id=frame)


def _camera_info(header: Any, label: dict[str, Any]) -> Any:
    matrix = np.array(label["K"])
    region = make("sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
    return make(
        "sensor_msgs/msg/CameraInfo",
        header=header,
        height=label["height"],
        width=label["width"],
        distortion_model="plumb_bob",
        d=np.array(label["distortion"]),
        k=matrix.ravel(),
        r=np.eye(3).ravel(),
        p=np.column_stack([matrix, np.zeros(3)]).ravel(),
        binning_x=0,
        binning_y=0,
        roi=region,
    )
