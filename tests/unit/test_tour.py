"""Ten minutes as a newcomer spends them: every command of the tutorial in an empty folder, and what it prints."""

import os
import re
import subprocess
import sys
from pathlib import Path

from opengl import can_render

ROOT = Path(__file__).parents[2]
TOUR = (ROOT / "docs" / "tutorials" / "ten_minutes.md").read_text()
BLOCK = re.compile(r'^(<!-- needs EGL -->\n)?```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.M | re.S)
TOKEN = re.compile(r"(?:(\d+(?:\.\d+)?(?:e[+-]?\d+)?)|\S)")
CLOSE = 0.02  # relative, and two units of the last digit shown: other processors round and stop fits elsewhere


def calls(block: str) -> list[tuple[str, str]]:
    """Commands of a console block, each with the output that is shown for it."""
    found = [part.partition("\n") for part in re.split(r"^\$ ", block, flags=re.M)[1:]]
    return [(command, shown) for command, _, shown in found]


def words(line: str) -> list[str]:
    """Numbers, and what else there is letter by letter."""
    return [match[0] for match in TOKEN.finditer(line)]


def same(shown: str, printed: str) -> bool:
    """Whether a line is the shown one, up to where that breaks off, but for spaces and small differences of numbers."""
    ours, theirs = words(shown.removesuffix("...")), words(printed)
    if shown.endswith("..."):
        theirs = theirs[: len(ours)]
    return len(ours) == len(theirs) and all(a == b or close(a, b) for a, b in zip(ours, theirs))


def close(shown: str, printed: str) -> bool:
    """Whether both are numbers, and nearly the same one."""
    if not (TOKEN.fullmatch(shown)[1] and TOKEN.fullmatch(printed)[1]):
        return False
    last = 10.0 ** -len(shown.partition(".")[2]) if "." in shown else 0.0
    return abs(float(shown) - float(printed)) <= max(CLOSE * abs(float(shown)), 2 * last)


def missing(shown: str, printed: str) -> str | None:
    """The first shown line that was not printed where it should be; "..." stands for any lines."""
    lines, free = iter(printed.splitlines()), False
    for line in shown.splitlines():
        if line == "...":
            free = True
        elif free:
            if not any(same(line, other) for other in lines):
                return line
            free = False
        elif not same(line, next(lines, "")):
            return line
    return None if free else next(lines, None)


def test_the_comparison_can_fail() -> None:
    assert missing("tip 1.00 m\n", "tip 1.01 m\n") is None
    assert missing("tip 1.00 m\n", "tip 1.30 m\n") == "tip 1.00 m"
    assert missing("tip 1.00 m\n", "tip 1.00 m\nand more\n") == "and more"
    assert missing("...\nb\n", "a\nb\n") is None
    assert missing("...\nc\n", "a\nb\n") == "c"
    assert missing("the 3 ...\n", "the 3 wise men of 7\n") is None
    assert missing("the 3 wild ...\n", "the 3 wise men of 7\n") == "the 3 wild ..."


def test_the_tour(tmp_path: Path) -> None:
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    walked = 0
    for needs_egl, language, title, text in BLOCK.findall(TOUR):
        if title:
            (tmp_path / title).write_text(text)
        for command, shown in calls(text) if language == "console" and (not needs_egl or can_render()) else ():
            done = subprocess.run(
                ["bash", "-c", command], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300
            )
            assert done.returncode == 0, f"{command}\n{done.stderr}"
            assert "Traceback" not in done.stderr, f"{command}\n{done.stderr}"
            assert missing(shown, done.stdout) is None, f"{command}\n{missing(shown, done.stdout)}\n{done.stdout}"
            walked += 1
    assert walked >= 12
    made = {path.name for path in tmp_path.iterdir()}
    assert {"boom.xml", "replay.png", "gap.html", "answer.html", "corrected.toml", "calibrated.toml"} <= made
