"""What is left in recordings that the calibration has not seen, by channel group."""

from collections import defaultdict

import numpy as np

from boom_mj.calibration import Validation
from boom_mj.report.section import Section

CLOSE = 1.5  # times the noise


def section(shown: Validation) -> Section | None:
    held_out = range(shown.training, len(shown.logs))
    if not held_out:
        return None
    rows = []
    for index in held_out:
        sensors: dict[str, list[tuple[float, float]]] = defaultdict(list)
        for before, after in zip(*(twin.groups for twin in shown.twins[index])):
            sensors[_sensor(after.name)].append((before.ratio, after.ratio))
        for sensor, ratios in sensors.items():
            before, after = np.array(ratios).T
            rows.append(
                (
                    shown.logs[index].log.name.replace("_", " "),
                    sensor,
                    f"{np.nanmax(before):.2f}",
                    f"{np.nanmax(after):.2f}",
                    f"{int(np.sum(after <= CLOSE))} of {len(after)}",
                )
            )
    return Section("left", "What is left in recordings not seen", {"rows": rows, "close": CLOSE})


def _sensor(group: str) -> str:
    if group.startswith("imu/"):
        return {"specific_force": "accelerometers", "angular_rate": "gyroscopes"}[group.split("/")[2]]
    return "markers" if group.startswith("markers") else "cylinders"
