"""What is tried: every command, every kind of fault; how each try ends is counted by `Count`."""

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import harms
import hostile
import inputs
import numpy as np
from attempts import Attempt, attempt
from count import Count
from inputs import Target
from leftovers import contents, files, half_written

from boom_mj.files import locked

SIGNALS = signal.SIGKILL, signal.SIGTERM, signal.SIGINT
SLOW = ("track", "gap blind run")  # start processes of their own
GRAPHICS = ("disabled", "glfw", "osmesa", "nonsense")
RESUMABLE = (
    ("render", "machine.toml --experiment experiment.toml -o out --scale 0.05 --every 4 --workers 1"),
    ("gap blind make", "--cases 1 --seed-file seed --seal out.seal -o out --machine machine.toml --mix none=1 --short"),
)


class Campaign:
    """Tries in fresh folders below one that is removed afterwards.

    Args:
        folder: empty.
        tell: is called with a line now and then.
        chosen: which targets are tried.
    """

    def __init__(
        self,
        folder: Path,
        seed: int = 1,
        tell: Callable[[str], None] = lambda line: None,
        chosen: Callable[[Target], bool] = lambda target: True,
    ) -> None:
        self.folder, self.whole, self.count, self.tell = folder, folder / "whole", Count(tell=tell), tell
        self.chosen = chosen
        self.rng, self.number = np.random.default_rng(seed), 0
        self.whole.mkdir()
        inputs.make_whole(self.whole)

    def targets(self, *names: str) -> Iterator[Target]:
        """The chosen targets, or those of some files."""
        yield from (t for t in inputs.TARGETS if self.chosen(t) and (not names or Path(t.file).name in names))

    @contextmanager
    def fresh(self) -> Iterator[Path]:
        """A copy of the whole inputs, removed afterwards."""
        self.number += 1
        here = inputs.place(self.whole, self.folder / str(self.number))
        yield here
        shutil.rmtree(here.parent)

    def content(self, target: Target) -> bytes:
        return (self.whole / target.file).read_bytes()

    def harmed(self, target: Target, kind: str, label: str, harm: Callable[[Path], object]) -> None:
        """Call a target's command with its file harmed."""
        with self.fresh() as here:
            harm(here / target.file)
            before = files(here)
            done = attempt(target.arguments, here)
            self.judge(target, kind, label, done, here, before)

    def judge(self, target: Target, kind: str, label: str, done: Attempt, here: Path, before: set[str]) -> None:
        passed = bool(target.passed) and target.passed in done.told and "Traceback" not in done.told
        given = [Path(word) for word in (target.file, *target.arguments) if "." in word]
        culprits = (*(path.name for path in given), Path(target.file).stem, "film", "ca5e", "boom36")
        outcome = "accepted" if passed and done.status in (1, 2) else done.outcome(*culprits)
        half = half_written(here, before, done.status == 0)
        if any(here.rglob(hostile.CANARY)):
            outcome = "crash"
        self.count.take(target.command, kind, label, outcome, half, done.story)

    # kinds of faults, one method each

    def run_broken(self, each: int) -> None:
        """Every file cut and corrupted `each` times."""
        for target in self.targets():
            self.tell(f"{target.command} {target.file}")
            content = self.content(target)
            for k in range(each if target.command not in SLOW else each // 3):
                harm = harms.HARMS[k % len(harms.HARMS)]
                data = harms.broken(content, harm, self.rng)
                kind = "cut" if harm == "cut" else "corrupted"
                self.harmed(target, kind, f"{target.file} {harm} {k}", lambda p, data=data: p.write_bytes(data))

    def run_hostile(self) -> None:
        """Every file replaced by what is none, by huge ones, and by those made to do harm."""
        made: dict[str, list[tuple[str, bytes]]] = {}
        for target in self.targets():
            self.tell(f"{target.command} {target.file}")
            for label, data in [*hostile.nothing()][:: 4 if target.command in SLOW else 1]:
                kind = "empty" if label == "empty" else "hostile"
                self.harmed(target, kind, f"{target.file} {label}", lambda p, data=data: p.write_bytes(data))
            self.harmed(target, "huge", f"{target.file} of {harms.SPARSE} bytes", harms.enlarge)
            self.harmed(target, "huge", f"{target.file}, whole and {harms.SPARSE} bytes", harms.extend)
            self.harmed(target, "hostile", f"{target.file} is a folder", harms.make_folder)
            self.harmed(target, "hostile", f"{target.file} is a loop of links", harms.make_loop)
            for label, data in self._special(target, made):
                self.harmed(target, "hostile", f"{target.file} {label}", lambda p, data=data: self._plant(p, data))

    def _special(self, target: Target, made: dict[str, list[tuple[str, bytes]]]) -> list[tuple[str, bytes]]:
        name = Path(target.file).name
        text = self.content(target)
        if name.endswith(".toml"):
            return [*hostile.tomls(text.decode())]
        makers = {
            ".mcap": hostile.mcaps,
            ".csv": hostile.tables,
            ".gz": hostile.packed_tables,
            ".bag": hostile.bags,
            ".mat": hostile.matlab,
            ".xml": hostile.xmls,
        }
        if name == "dataset.json":
            return [*hostile.datasets(json.loads(text))]
        if name == "a.png":
            return [("png bomb", hostile.png_bomb())]
        if name.endswith(".json"):
            return [*hostile.jsons(json.loads(text))]
        suffix = Path(name).suffix
        if suffix in makers and suffix not in made:
            made[suffix] = [*makers[suffix]()]
        return made.get(suffix, [])

    def _plant(self, path: Path, data: bytes) -> None:
        path.write_bytes(data)
        if path.name == "seal.json":
            inputs.seal(path.parent, data)
        if b"bomb.png" in data:
            path.with_name("bomb.png").write_bytes(hostile.png_bomb())

    def run_not_a_number(self) -> None:
        """Machine files, experiments and maps with nan, inf and extreme values; logs of NaN."""
        for target in self.targets("machine.toml", "experiment.toml", "robot.toml", "csv_map.toml"):
            lines = self.content(target).decode().splitlines()
            numbers = [k for k, line in enumerate(lines) if "=" in line and any(c.isdigit() for c in line)]
            self.tell(f"{target.command} {target.file}")
            for k, value in enumerate(("nan", "inf", "-inf", "1e308", "1e-308", "-1.0", "0.0", "1e15", "1e-9")):
                for line in self.rng.choice(numbers, min(len(numbers), 3), replace=False):
                    text = "\n".join((*lines[:line], harms.with_value(lines[line], value), *lines[line + 1 :]))
                    label = f"{target.file} {value} {k}: {lines[line]}"
                    self.harmed(target, "not a number", label, lambda p, text=text: p.write_text(text))
        for target in self.targets("log.mcap"):
            for which in ("joint/position", "markers", "all"):
                self.harmed(target, "not a number", f"log of NaN in {which}", lambda p, w=which: harms.write_nan(p, w))

    def run_places(self) -> None:
        """Outputs where there is no folder, in place of one, without permission; stdout that is full or closed."""
        for target in self._with_output():
            option = target.arguments.index(_output(target))
            suffix = Path(target.arguments[option]).suffix
            for label, path in (
                ("no folder", f"no/where/out{suffix}"),
                ("a folder", f"film{suffix}"),
                ("below a file", f"machine.toml/out{suffix}"),
                ("no permission", f"/proc/out{suffix}"),
                ("no permission in a folder", f"/sys/out{suffix}"),
                ("loop of links", f"loop{suffix}"),
                ("long name", "x" * 300 + suffix),
            ):
                with self.fresh() as here:
                    (here / f"film{suffix}").mkdir(exist_ok=True)
                    if suffix:
                        (here / f"loop{suffix}").symlink_to(f"loop{suffix}")
                    before = files(here)
                    arguments = (*target.arguments[:option], path, *target.arguments[option + 1 :])
                    done = attempt(arguments, here)
                    outcome = done.outcome(path, Path(path).name[:60], target.passed or path)
                    half = half_written(here, before, False)
                    self.count.take(target.command, "place", f"{label} {path}", outcome, half, done.story)

    def run_full_disk(self, sizes: Sequence[int] = (2500,)) -> None:
        """Files that cannot grow; an old output stays. Results to a stdout that is full."""
        for target in self._writing():
            for size in sizes:
                for old in (False, True):
                    with self.fresh() as here:
                        out = here / _output(target)
                        if old:
                            out.write_bytes(b"old")
                        before = files(here)
                        done = attempt(target.arguments, here, file_size=size)
                        lost = ["old output lost"] * (old and done.status != 0 and out.read_bytes() != b"old")
                        half = half_written(here, before, done.status == 0) + lost
                        outcome = done.outcome("out", "stdout")
                        self.count.take(target.command, "disk full", f"{size} bytes", outcome, half, done.story)
        for command in (
            ("generate", "machine.toml"),
            ("gap", "effects"),
            ("logs", "inspect", "log.mcap"),
            ("validate", "machine.toml", "--poses", "1"),
        ):
            with self.fresh() as here:
                done = attempt(command, here, before=_full_stdout)
                name = " ".join(command[:2]) if command[0] in ("gap", "logs") else command[0]
                self.count.take(name, "disk full", "stdout", done.outcome("stdout"), [], done.story)

    def run_killed(self, each: int) -> None:
        """Calls killed at random moments: the output is whole or not there, and the same call then succeeds."""
        for target in self._writing():
            with self.fresh() as here:
                whole = attempt(target.arguments, here)
                assert whole.status == 0, whole.told
                wanted = (here / _output(target)).read_bytes()
            self.tell(f"{target.command}: {whole.wall:.1f} s, killed {each} times")
            for k in range(each):
                with self.fresh() as here:
                    number = SIGNALS[k % 3]
                    late = k % 2 == 0  # most of the writing is at the end
                    moment = float(self.rng.uniform(0.6 if late else 0.0, 1.0)) * whole.wall
                    done = attempt(target.arguments, here, kill=(number, moment))
                    out = here / _output(target)
                    half = ["half-written"] if out.exists() and out.read_bytes() != wanted else []
                    if number != signal.SIGKILL:
                        half += [p.name for p in here.rglob(".*.part")]
                    outcome = "clear error" if done.status == -signal.SIGKILL else done.outcome("interrupted")
                    again = attempt(target.arguments, here)
                    half += [] if again.status == 0 and out.read_bytes() == wanted else [f"not finished: {again.told}"]
                    half += [p.name for p in here.rglob(".*.part")]
                    self.count.take(
                        target.command, "killed", f"{number.name} {moment:.2f} s", outcome, half, done.story
                    )

    def run_killed_within(self, calls: Sequence[tuple[str, str]], each: int) -> None:
        """Resumable calls killed on their way: the same call finishes, to the same bytes."""
        for command, arguments in calls:
            words = (*command.split(), *arguments.split())
            with self.fresh() as here:
                whole = attempt(words, here, seconds=300)
                assert whole.status == 0, whole.told
                wanted = contents(here / "out")
            self.tell(f"{command}: {whole.wall:.1f} s, killed {each} times and finished")
            for k in range(each):
                with self.fresh() as here:
                    number = SIGNALS[k % 3]
                    done = attempt(
                        words, here, kill=(number, float(self.rng.uniform(0.3, 0.9)) * whole.wall), seconds=300
                    )
                    torn = {n for n, b in contents(here / "out").items() if ".part" not in n and wanted.get(n, b) != b}
                    again = attempt(words, here, seconds=300)
                    same = again.status == 0 and contents(here / "out") == wanted
                    half = [*torn, *([] if same else [f"not finished: {again.told}"])]
                    outcome = "clear error" if done.status == -signal.SIGKILL else done.outcome("interrupted")
                    self.count.take(command, "killed", number.name, outcome, half, done.story)

    def run_two(self) -> None:
        """Two calls at once: into one file the last one wins, whole; into one folder the second is refused."""
        target = next(t for t in inputs.TARGETS if t.command == "simulate")
        with self.fresh() as here:
            wanted = attempt(target.arguments, here)
            content = (here / "out.mcap").read_bytes()
            (here / "out.mcap").unlink()
            other = os.fork()
            if other == 0:
                os._exit(attempt(target.arguments, _below(here, "second")).status)
            done = attempt(target.arguments, _below(here, "first"))
            _, end = os.waitpid(other, 0)
            whole = wanted.status == done.status == os.waitstatus_to_exitcode(end) == 0
            half = [p.name for p in here.rglob(".*.part")]
            half += [] if whole and (here / "out.mcap").read_bytes() == content else ["out.mcap"]
            self.count.take("simulate", "two at once", "one file", "accepted" if whole else "crash", half, done.told)
        for command, arguments in (
            ("render", "machine.toml --experiment experiment.toml -o out --scale 0.05"),
            ("gap blind make", "--cases 1 --seed-file seed --seal out.seal -o out --machine machine.toml --mix none=1"),
            ("gap blind run", "campaign -o out"),
        ):
            with self.fresh() as here:
                with locked(here / "out"):
                    done = attempt((*command.split(), *arguments.split()), here)
                outcome = done.outcome("written by another process")
                self.count.take(command, "two at once", "one folder", outcome, [], done.story)

    def run_environments(self) -> None:
        """No OpenGL, no optional packages, no screen."""
        film = "render machine.toml --experiment experiment.toml -o out --scale 0.05 --workers 1"
        for name, call, culprit, change in (
            *(("render", film, f"MUJOCO_GL={gl}", {"MUJOCO_GL": gl}) for gl in GRAPHICS),
            ("gap blind run", "gap blind run campaign -o out --cluster tcp://a:1", "boom_mj[cluster]", ("dask",)),
            ("view", "view machine.toml --experiment experiment.toml --web", "viewer cannot run", ("mujoco.studio",)),
        ):
            with self.fresh() as here:
                done = attempt(call.split(), here, before=lambda c=change: _without(c))
                self.count.take(name, "environment", culprit, done.outcome(culprit), [], done.story)
        for gl in ("nonsense", "osmesa", "disabled"):  # read when MuJoCo is imported
            done = subprocess.run(
                [sys.executable, "-m", "boom_mj", "generate", "boom36"],
                capture_output=True,
                text=True,
                check=False,
                env={**os.environ, "MUJOCO_GL": gl},
                cwd=inputs.ROOT,
            )
            outcome = "accepted" if done.returncode == 0 and "<mujoco" in done.stdout else "crash"
            self.count.take("generate", "environment", f"MUJOCO_GL={gl}", outcome, [], done.stderr)

    def _writing(self) -> Iterator[Target]:
        """Those with outputs that succeed, of few kinds of inputs."""
        few = ("machine.toml", "log.mcap", "seal.json")
        yield from (t for t in self._with_output() if not t.passed and t.file in few)

    def _with_output(self) -> Iterator[Target]:
        seen = set()
        for target in self.targets():
            key = (target.command, _output(target))
            if _output(target) and key not in seen:
                seen.add(key)
                yield target


def _output(target: Target) -> str:
    return next((a for a in target.arguments if a.startswith("out")), "")


def _below(here: Path, name: str) -> Path:
    """A folder of its own for what a call says, whose inputs and output are those of `here`."""
    (here / name).mkdir()
    for path in here.glob("*.toml"):
        (here / name / path.name).symlink_to(path)
    (here / name / "out.mcap").symlink_to(here / "out.mcap")
    return here / name


def _without(change: dict[str, str] | tuple[str, ...]) -> None:
    """Variables set, or packages missing."""
    for key in ("DISPLAY", "WAYLAND_DISPLAY"):
        os.environ.pop(key, None)
    if isinstance(change, dict):
        os.environ.update(change)
    else:
        sys.modules.update(dict.fromkeys(change))  # type: ignore[arg-type]


def _full_stdout() -> None:
    os.dup2(os.open("/dev/full", os.O_WRONLY), 1)
