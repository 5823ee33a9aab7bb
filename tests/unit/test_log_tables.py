"""Logs of any machine as they come: rows out of order, samples that are missing, jump away and back, or end early."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from cart import MAP, MODEL

from boom_mj.cli.gap_data import load_gap_data
from boom_mj.errors import LogError, LogWarning
from boom_mj.logs import write_mcap
from boom_mj.recording import Recording
from boom_mj.recording.names import named_signal
from boom_mj.systems.mjcf.channel_map import parse_channel_map
from boom_mj.systems.mjcf.log_table import LogTable, glitches, read_table
from boom_mj.systems.mjcf.segments import smoothed, stretches_of

HANDS_OFF = MAP.replace('"drive"', '"compare"').replace('"compare"\nactuator', '"control"\nactuator')
TIME = np.arange(0, 10, 0.01)


def columns() -> dict[str, np.ndarray]:
    """A motion and a force with noise."""
    rng = np.random.default_rng(0)
    noise = rng.normal(size=(2, len(TIME)))
    return {"t": TIME.copy(), "q": np.sin(TIME) + 1e-4 * noise[0], "f": np.cos(3 * TIME) + 0.01 * noise[1]}


def written(folder: Path, table: dict[str, np.ndarray]) -> Path:
    rows = [",".join(table), *(",".join(f"{x:.9g}" for x in row) for row in zip(*table.values()))]
    (folder / "log.csv").write_text("\n".join(rows).replace("nan", "") + "\n")
    return folder / "log.csv"


def read(folder: Path, table: dict[str, np.ndarray], text: str = MAP) -> LogTable:
    return read_table(written(folder, table), parse_channel_map(text))


def spans(parts: list[Recording]) -> list[tuple[float, float]]:
    """First and last compared moment of stretches."""
    return [(float(p["force"].time[0]), float(p["force"].time[-1])) for p in parts]


def test_a_sound_log_is_what_it_says(tmp_path: Path) -> None:
    log, given = read(tmp_path, columns()), columns()
    assert not log.findings and not log.gaps
    np.testing.assert_allclose(log.values["force"], given["f"], atol=1e-8)
    np.testing.assert_allclose(log.time, given["t"])


def test_rows_get_their_places(tmp_path: Path) -> None:
    """A row that is late, one that comes twice, two of one time, one without a time."""
    table = columns()
    order = np.concatenate([np.arange(500), [502, 501, 500], np.arange(503, 1000), [999]])
    table = {name: column[order] for name, column in table.items()}
    table["t"][700] = table["t"][699]
    table["t"][800] = np.nan
    with pytest.warns(LogWarning) as heard:
        log = read(tmp_path, table)
    said = " ".join(str(one.message) for one in heard)
    assert (
        "put in their place" in said
        and "1 rows without a time" in said
        and "1 of 998 times have several rows that differ" in said
    )
    assert len(log.time) == 998 and (np.diff(log.time) > 0).all()
    at = int(np.searchsorted(log.time, TIME[699] - 1e-9))
    assert log.values["force"][at] == pytest.approx(np.mean(columns()["f"][699:701]))


def test_a_table_of_several_topics_is_one(tmp_path: Path) -> None:
    """Each row has what one of them said; no row contradicts another."""
    given, empty = columns(), np.full(len(TIME), np.nan)
    rows = [{"q": given["q"], "f": empty}, {"q": empty, "f": given["f"]}, {"q": empty, "f": given["f"]}]
    table = {name: np.stack([{"t": TIME, **row}[name] for row in rows], axis=1).ravel() for name in given}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        log = read(tmp_path, table)
    assert not log.findings and len(log.time) == len(TIME)
    for name, field in (("motion", "q"), ("force", "f")):
        np.testing.assert_allclose(log.values[name], given[field], atol=1e-8)


def test_clocks_that_make_no_order_are_refused(tmp_path: Path) -> None:
    back, coarse, empty = columns(), columns(), columns()
    back["t"][600:] -= 3.0
    coarse["t"] = np.floor(coarse["t"] * 10) / 10
    empty["t"][5:] = np.nan
    for table, says in ((back, "set back.*another field as time"), (coarse, "must increase"), (empty, "995 are empty")):
        with pytest.raises(LogError, match=f"log.csv: .*{says}"), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            read(tmp_path, table)


def test_samples_that_are_missing_are_bridged_where_the_model_follows_and_left_out_where_it_is_judged(
    tmp_path: Path,
) -> None:
    table = columns()
    table["q"][[300, 301, 640]] = np.nan
    table["f"][[200, 450]] = np.nan
    log = read(tmp_path, table)
    assert [(f.channel, f.kind, str(f.action)) for f in log.findings] == [
        ("motion", "dropped", "repaired"),
        ("force", "dropped", "left out"),
    ]
    assert "no value in 3 of 1000 samples" in log.findings[0].sentence
    parts, sound = stretches_of(log), stretches_of(read(tmp_path, columns()))
    assert spans(parts) == spans(sound)
    for part, same in zip(parts, sound):
        np.testing.assert_allclose(part["motion"].values, same["motion"].values, atol=1e-3)
    force = np.concatenate([part["force"].values[:, 0] for part in parts])
    assert np.isnan(force).sum() == 2


def test_no_stretch_goes_across_what_the_model_cannot_follow(tmp_path: Path) -> None:
    for hole in ("samples", "rows"):
        table = columns()
        if hole == "samples":
            table["q"][400:460] = np.nan
        else:
            table = {name: np.delete(column, np.s_[400:460]) for name, column in table.items()}
        log = read(tmp_path, table)
        assert log.gaps == [pytest.approx((3.99, 4.60))]
        assert "motion has no value from 3.99 to 4.60 s, which moves the model: left out" in log.findings[0].sentence
        found = spans(stretches_of(log))
        assert any(begin < 3.5 for begin, _ in found) and any(end > 8 for _, end in found)
        assert all(end < 3.99 - 0.2 + 0.011 or begin > 4.6 + 0.2 - 0.011 for begin, end in found)


def test_near_a_hole_of_what_is_judged_nothing_is_judged_that_was_smoothed_across_it(tmp_path: Path) -> None:
    table = columns()
    table["f"][500:540] = np.nan
    log = read(tmp_path, table)
    assert not log.gaps and log.holes["force"] == (pytest.approx((4.99, 5.40)),)
    time, force = (np.concatenate([p["force"].time for p in stretches_of(log)]) for _ in range(2))
    force = np.concatenate([p["force"].values[:, 0] for p in stretches_of(log)])
    lost = time[np.isnan(force)]
    assert (lost.min(), lost.max()) == pytest.approx((4.99 - 0.2, 5.40 + 0.2), abs=0.02)


def test_a_command_holds_and_a_motion_that_is_judged_tells_where_to_begin(tmp_path: Path) -> None:
    table = columns()
    table["f"][np.arange(1000) % 4 != 0] = np.nan  # sent every fourth row
    table["q"][::7] = np.nan
    log = read(tmp_path, table, HANDS_OFF)
    assert [finding.channel for finding in log.findings] == ["motion"]
    force = next(entry for entry in log.channels.channel if entry.name == "force")
    held = log.bridged(force, log.values["force"])
    np.testing.assert_array_equal(held[:996], np.repeat(log.values["force"][::4], 4)[:996])
    for part in stretches_of(log):
        begin = float(part["start"].time[0])
        assert part["start/slide"].values[0] == pytest.approx((np.sin(begin), np.cos(begin)), abs=0.02)
        assert np.isnan(part["motion"].values).mean() == pytest.approx(1 / 7, abs=0.01)
        assert np.isfinite(part["motion/slide"].values).all()


def test_channels_with_clocks_of_their_own(tmp_path: Path) -> None:
    """A force that is measured 2.5 times as often, in a file beside the log."""
    beside = tmp_path / "force.csv"
    often = np.arange(0.3, 9.0, 0.004)
    np.savetxt(beside, np.stack([often, np.cos(3 * often)], axis=1), delimiter=",", header="at,f", comments="")
    text = MAP.replace('field = "f"', 'field = "force.csv:f"\ntime = "force.csv:at"')
    table = columns()
    del table["f"]
    log = read(tmp_path, table, text)
    assert not log.gaps and [f.sentence.partition(": ")[2] for f in log.findings] == [
        "force has no value from 0.00 to 0.30 s: left out",
        "force has no value from 9.00 to 9.99 s: left out",
    ]
    known = np.isfinite(log.values["force"])
    np.testing.assert_allclose(log.time[known], often)
    parts, sound = stretches_of(log), stretches_of(read(tmp_path, columns()))
    for part, same in zip(parts, sound):
        at = same["motion"].time[(same["motion"].time > 0.5) & (same["motion"].time < 8.5)]
        moved, would = (np.interp(at, p["motion"].time, p["motion"].values[:, 0]) for p in (part, same))
        np.testing.assert_allclose(moved, would, atol=2e-3)
        force = part["force"]
        some = np.isfinite(force.values[:, 0])
        np.testing.assert_allclose(force.values[some, 0], np.cos(3 * force.time[some]), atol=0.02)


def test_a_topic_has_its_own_clock(tmp_path: Path) -> None:
    """Of a log of messages channels go by their topics' times, recorded or of the headers, as the map's time does."""
    time = np.arange(0, 10, 0.02)
    angles, every = np.zeros((len(time), 5)), np.arange(0, len(time), 3)
    angles[:, 0] = np.sin(time)
    felt = np.stack([np.cos(time), 0 * time, 0 * time], axis=1)[every]
    signals = {
        "joint/position": named_signal("joint/position", time, angles),
        "imu/link5/specific_force": named_signal("imu/link5/specific_force", time[every] + 0.005, felt),
    }
    write_mcap(Recording("two", "boom36", "", signals), tmp_path / "log.mcap")
    for clock in ("log_time", "header_time"):
        text = f"""
name = "boom"
time = "/joint_states.{clock}"
[[channel]]
name = "slewing"
role = "drive"
joint = "slew"
field = "/joint_states.position[0]"
[[channel]]
name = "tip"
role = "compare"
sensor = "tip"
field = "/imu/link5.linear_acceleration.x"
"""
        log = read_table(tmp_path / "log.mcap", parse_channel_map(text))
        assert not log.findings and not log.gaps
        slewing, tip = (log.time[np.isfinite(log.values[name])] for name in ("slewing", "tip"))
        np.testing.assert_allclose(slewing, time, atol=1e-6)
        np.testing.assert_allclose(tip, time[every] + 0.005, atol=1e-6)
        assert np.interp(3.005, tip, log.values["tip"][np.isfinite(log.values["tip"])]) == pytest.approx(
            np.cos(3.0), abs=0.01
        )


def test_a_channel_that_says_nothing_is_refused(tmp_path: Path) -> None:
    table = columns()
    table["f"][:] = np.nan
    with pytest.raises(LogError, match="force has no value at all"):
        read(tmp_path, table)


def test_glitches_are_found_and_motion_is_none() -> None:
    rng, time = np.random.default_rng(1), np.arange(0, 20, 0.01)
    for hertz in (0.2, 1.0, 5.0, 12.0):
        clean = np.sin(2 * np.pi * hertz * time) + 1e-3 * rng.normal(size=len(time))
        assert not glitches(clean, 1e-3).any()
        assert not glitches(np.sign(clean) + 1e-3 * rng.normal(size=len(time)), 1e-3).any()
    clean = np.sin(time) + 1e-3 * rng.normal(size=len(time))
    spoiled = clean.copy()
    at = np.array([100, 555, 556, 900, 1500])
    spoiled[at] += [5.0, -2.0, -2.0, 0.5, -40.0]
    spoiled[333] = np.nan
    assert np.flatnonzero(glitches(spoiled, 1e-3)).tolist() == at.tolist()


def test_a_blow_is_no_glitch(tmp_path: Path) -> None:
    """What a joint does within two samples no joint can do; a force can, unless it is beyond all that it ever was."""
    table = columns()
    table["q"][[200, 700]] += 0.5
    table["f"][[250, 610]] += [1.5, 40.0]
    log = read(tmp_path, table)
    assert np.flatnonzero(np.isnan(log.values["motion"])).tolist() == [200, 700]
    assert np.flatnonzero(np.isnan(log.values["force"])).tolist() == [610]
    assert [f.kind for f in log.findings] == ["spiky", "spiky"]
    assert "motion jumps away and back in 2 of 1000 samples" in log.findings[0].sentence


def test_a_turn_with_holes_is_unwound(tmp_path: Path) -> None:
    table, text = columns(), MAP.replace('field = "q"', 'field = "q"\nwrap = 1.0')
    turns = 0.7 * TIME
    table["q"] = turns % 1.0
    table["q"][::50] = np.nan
    log = read(tmp_path, table, text)
    known = np.isfinite(log.values["motion"])
    assert known.mean() == pytest.approx(0.98) and not log.gaps
    np.testing.assert_allclose(log.values["motion"][known], turns[known], atol=1e-6)


def test_stamps_that_are_not_even_are_smoothed_in_time() -> None:
    rng = np.random.default_rng(2)
    time = np.cumsum(rng.uniform(0.002, 0.03, 2000))
    slow = np.sin(2 * np.pi * 0.5 * time)
    inside = (time > 2) & (time < time[-1] - 2)
    assert np.abs(smoothed(time, slow, 5.0) - slow)[inside].max() < 0.02


def test_what_is_wrong_goes_with_the_machine_and_strictly_it_is_refused(tmp_path: Path) -> None:
    """Of healthy logs, too."""
    (tmp_path / "map.toml").write_text(MAP)
    (tmp_path / "cart.xml").write_text(MODEL.format(kind="slide"))
    table = columns()
    table["q"][640] = np.nan
    log, where = written(tmp_path, table), tmp_path / "map.toml"
    given = load_gap_data([log], [], channels=where)
    assert [finding.sentence for finding in given.findings] == [
        f"{log}: motion has no value in 1 of 1000 samples: repaired"
    ]
    assert given.names == tuple(part.name for part in given.data.recordings)
    with pytest.raises(LogError, match="motion has no value"):
        load_gap_data([log], [], channels=where, strict=True)
