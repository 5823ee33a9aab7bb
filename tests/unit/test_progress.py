"""Progress away from a terminal: seldom enough to be read, often enough to be believed."""

import time

from pytest import CaptureFixture, MonkeyPatch

from boom_mj.cli.progress import progress


def test_lines_come_with_the_first_estimate_once_a_minute_and_at_the_end(
    monkeypatch: MonkeyPatch, capsys: CaptureFixture[str]
) -> None:
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    with progress() as report:
        for done in range(41):  # ten seconds each
            report("cases", done, 40)
            now[0] += 10.0
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "cases: 2 of 40, about 380 s left"
    assert lines[1] == "cases: 8 of 40, about 320 s left"
    assert lines[-2:] == ["cases: 38 of 40, about 20 s left", "cases: 40 in 400 s"]
    assert len(lines) == 8


def test_a_call_says_whether_it_goes_on_or_begins_afresh(capsys: CaptureFixture[str]) -> None:
    for done in (0, 3):
        with progress("frames") as report:
            report("boards", 0, 1)
            report("frames", done, 4)
            report("frames", 4, 4)
    first, again = capsys.readouterr().err.split("frames: 4 in 0 s\n")[:2]
    assert first == "frames: begins afresh\n" and again == "frames: goes on, 3 of 4 are done\n"
