"""The paper's validation repeated on a virtual machine: page with pictures and JSON, by one command.

python scripts/paper_page.py -o PAGE.html [--json PAGE.json] [--machine 0]   (about five minutes)

A machine of the campaign of scripts/calibration.py (stiffness, masses and damping off, zero offsets of joints, six
hinges per elastic coordinate, sensor noise) does the paper's seven experiments and the T-shaped pose. It is calibrated
from those, and validated with them and with the 300 s fold-in, from which nothing is learnt.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np
from calibration import HINGES, NOMINAL, Order, draw, recordings

from boom_mj.calibration import calibrate, document, validate, validation_document
from boom_mj.calibration.parameters import make_parameterisation
from boom_mj.files import write_text
from boom_mj.report import write_calibration
from boom_mj.sensors import record
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment

FOLD_IN = CATALOGUE["fold_in_300"]


def main() -> None:
    """Simulate, calibrate, validate, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", dest="page", type=Path, required=True)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--machine", type=int, default=0)
    given = parser.parse_args()
    began = time.perf_counter()

    def tell(line: str) -> None:
        print(f"{time.perf_counter() - began:6.1f} s  {line}", file=sys.stderr, flush=True)

    truth = make_parameterisation(NOMINAL).at(
        draw(make_parameterisation(NOMINAL), np.random.default_rng(given.machine))
    )
    logs = recordings(truth, Order(Path(), given.machine))
    tell("the paper's experiments are recorded")
    motion = run_experiment(make_plant(truth.machine, HINGES, truth.sensor), FOLD_IN)
    fold_in = record(motion, FOLD_IN, np.random.default_rng([given.machine, len(logs)]))
    found = calibrate(NOMINAL, logs, tell=tell)
    shown, names = validate(found, [fold_in]), [log.name for log in logs]
    write_calibration(shown, names, given.page)
    if given.json:
        answer = {**document(found, names), "validation": validation_document(shown)}
        write_text(given.json, json.dumps(answer, indent=1))
    tell(f"wrote {given.page}")


if __name__ == "__main__":
    main()
