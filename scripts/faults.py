"""Every command against broken files, bad places, full disks and kills; prints a table of docs/results/robustness.md.

    python scripts/faults.py [--each 12] [--seed 1]

Calls run one by one in processes with limited memory and time. What should not be - a traceback, a signal, memory or
time without bound, a half-written file - is printed with its story, and the exit status is 1. About a quarter of an
hour.
"""

import argparse
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "faults"))

import campaign as faults


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--each", type=int, default=6, help="times that every file is cut or corrupted")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--only",
        nargs="*",
        default=(),
        help="kinds: broken, hostile, numbers, places, disk, killed, resumed, two, environment",
    )
    parser.add_argument("--command", default="", help='only what begins so: "gap diagnose model.xml"')
    given = parser.parse_args()
    began = time.monotonic()

    def tell(line: str) -> None:
        print(f"{time.monotonic() - began:6.0f} s  {campaign.count.bad} bad  {line}", file=sys.stderr, flush=True)

    def chosen(target: faults.Target) -> bool:
        return f"{target.command} {target.file}".startswith(given.command)

    with tempfile.TemporaryDirectory() as folder:
        campaign = faults.Campaign(Path(folder), given.seed, tell, chosen)
        for name, part in (
            ("broken", lambda: campaign.run_broken(given.each)),
            ("hostile", campaign.run_hostile),
            ("numbers", campaign.run_not_a_number),
            ("places", campaign.run_places),
            ("disk", campaign.run_full_disk),
            ("killed", lambda: campaign.run_killed(4 * given.each)),
            ("resumed", lambda: campaign.run_killed_within(faults.RESUMABLE, 3)),
            ("two", campaign.run_two),
            ("environment", campaign.run_environments),
        ):
            if not given.only or name in given.only:
                part()
    print(campaign.count.table())
    return 1 if campaign.count.bad else 0


if __name__ == "__main__":
    sys.exit(main())
