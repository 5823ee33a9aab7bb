"""Every kind of finding is found at its channel; sound recordings give none and stay the same objects."""

import json
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from boom_mj.effects import parse_effect
from boom_mj.errors import LogError
from boom_mj.machine import load_machine
from boom_mj.recording import Recording, Signal
from boom_mj.replay.quality import Action, check_recordings
from boom_mj.replay.quality.check import Check, all_checks
from boom_mj.replay.quality.kinds.states import groups_of
from boom_mj.sensors import record
from boom_mj.simulation import CATALOGUE, make_plant, run_experiment

sys.path.append(str(Path(__file__).parents[2] / "scripts"))
import log_faults

MACHINE = load_machine("boom36")
EXPERIMENTS = ("release_bow_vertical", "mixed", "release_stretched_horizontal", "sweep")
TRAINING = 2
OFFSETS = tuple(
    f"joint_zero_offset:joint={joint},offset={offset}"
    for joint, offset in zip(range(1, 6), (0.004, -0.003, 0.005, -0.004, 0.002))
)


@cache
def simulated(*effects: str) -> tuple[Recording, ...]:
    plant = make_plant(MACHINE, 2, [parse_effect(text) for text in effects])
    rng = np.random.default_rng(len(effects))
    return tuple(record(run_experiment(plant, CATALOGUE[name]), CATALOGUE[name], rng) for name in EXPERIMENTS)


def found_in(logs: list[Recording]) -> set[tuple[str, str]]:
    return {(f.kind, f.channel) for f in check_recordings(MACHINE, logs, TRAINING).findings}


@pytest.mark.parametrize(
    "effects",
    [
        (),
        (*OFFSETS, "tip_payload:mass=100"),
        (*OFFSETS, "pressure_scale:cylinder=2,factor=4"),  # a factor below OFF is a cause
        (*OFFSETS, "imu_misalignment:link=3,rotation_x=0.3,rotation_y=0.4"),
        (*OFFSETS, "imu_bias:link=4,accelerometer_x=4,gyroscope_z=0.3"),
        (*OFFSETS, "clock_offset:stream=imu,delay=0.9"),  # turns gyroscopes that swing at 0.5 Hz
        (*OFFSETS, "joint_sensor_nonlinearity:joint=3,amplitude=0.02,periods=3"),
        (*OFFSETS, "marker_slip:marker=7,offset_x=0.5"),
        (*OFFSETS, "joint_play:joint=4,half_gap=0.005"),
        (
            "joint_zero_offset:joint=1,offset=0.004",
            "thermal_bending:link=2,axis=w,displacement=0.1",
        ),  # turns y of markers
    ],
)
def test_sound_recordings_stay_the_same_objects(effects: tuple[str, ...]) -> None:
    logs = simulated(*effects)
    checked = check_recordings(MACHINE, logs, TRAINING)
    assert [f.sentence for f in checked.findings] == []
    assert all(a is b for a, b in zip(checked.recordings, logs, strict=True))
    assert (checked.training, checked.kept) == (TRAINING, (0, 1, 2, 3))
    checked.refuse(all_of_them=True)


@pytest.mark.parametrize("fault", log_faults.FAULTS, ids=lambda fault: fault.__name__)
def test_every_fault_is_named_at_its_channel_and_inputs_stay(fault: object) -> None:
    rng = np.random.default_rng(5)
    spoiled = log_faults.Set(list(simulated(*OFFSETS)), TRAINING)
    done = fault(rng, spoiled)
    before = [{name: (s.time.copy(), s.values.copy()) for name, s in log.signals.items()} for log in spoiled.logs]
    checked = check_recordings(MACHINE, spoiled.logs, TRAINING, [str(k) for k in range(len(spoiled.logs))])
    mine = [f for f in checked.findings if f.kind in done.kinds and log_faults.at(f.channel, done)]
    assert {int(f.log) for f in mine} & set(done.logs), [f.sentence for f in checked.findings]
    for log, signals in zip(spoiled.logs, before, strict=True):
        assert {name: s.values.shape for name, s in log.signals.items()} == {
            n: v.shape for n, (_, v) in signals.items()
        }
        for name, (time, values) in signals.items():
            assert np.array_equal(log[name].time, time)
            assert np.array_equal(log[name].values, values, equal_nan=True)
    for finding in checked.findings:
        document = json.loads(json.dumps(finding.document()))
        assert set(document) >= {"log", "channel", "finding", "from_s", "to_s", "used"}
        assert document["from_s"] <= document["to_s"]


def test_joints_that_follow_late_do_not_stand_still() -> None:
    logs = [
        log.with_signals({log_faults.DRIVE: replace(log[log_faults.DRIVE], time=log[log_faults.DRIVE].time + 0.39)})
        for log in simulated(*OFFSETS)
    ]
    assert found_in(logs) == {("clock", log_faults.DRIVE)}


def test_what_is_repaired_is_found_no_more() -> None:
    spoiled = log_faults.Set(list(simulated(*OFFSETS)), TRAINING)
    for fault in (log_faults.swapped, log_faults.unit, log_faults.joint_unit, log_faults.frozen):
        fault(np.random.default_rng(2), spoiled)
    checked = check_recordings(MACHINE, spoiled.logs, TRAINING)
    assert {f.action for f in checked.findings} == {Action.REPAIRED}
    assert found_in(list(checked.recordings)) == set()


def test_logs_of_another_state_are_left_out_together_with_the_call_that_diagnoses_them() -> None:
    logs = [*simulated(*OFFSETS)[:TRAINING], *simulated(*OFFSETS, "tip_payload:mass=60")[TRAINING:]]
    checked = check_recordings(MACHINE, logs, TRAINING, [f"{k}.mcap" for k in range(4)])
    told = {f.log: f for f in checked.findings if f.kind == "state"}
    assert set(told) == {"2.mcap", "3.mcap"} and checked.kept == (0, 1) and checked.training == TRAINING
    assert all(f.action is Action.LEFT_OUT and "gap diagnose 2.mcap 3.mcap" in f.sentence for f in told.values())
    assert "than 0.mcap: in the same pose" in told["3.mcap"].sentence
    assert "with 3.mcap" in told["2.mcap"].sentence  # in a pose that no other log shows
    with pytest.raises(LogError, match="gap diagnose 2"):
        checked.refuse(all_of_them=True)


@pytest.mark.parametrize(
    ("apart", "groups"),
    [
        ({}, [(0, 1, 2, 3)]),
        ({(0, 2): 2.0, (1, 3): 2.0}, [(0, 1, 2, 3)]),
        ({(0, 1): 2.0, (0, 2): 9.0, (2, 3): 2.0}, [(0, 1), (2, 3)]),
        ({(0, 1): 9.0, (1, 2): 2.0}, [(1, 2, 3), (0,)]),  # as many train: the larger one
        ({(0, 1): 2.0, (0, 2): 9.0}, [(0, 1), (2, 3)]),  # 3 tells nothing and is with the other one held out
        ({(0, 2): 9.0, (0, 3): 9.0, (2, 3): 9.0}, [(0, 1), (2,), (3,)]),
    ],
)
def test_which_logs_belong_together(apart: dict, groups: list) -> None:
    assert groups_of(range(4), 2, {frozenset(pair): far for pair, far in apart.items()}) == groups


def test_a_joint_zeroed_anew_is_mended_in_logs_that_cannot_be_compared_if_all_others_of_their_part_were() -> None:
    rng = np.random.default_rng(3)
    names = ("release_bow_vertical", "slew_t", "fold_in", "mixed", "release_bow_horizontal")
    plant = make_plant(MACHINE, 1)
    logs = [record(run_experiment(plant, CATALOGUE[name]), CATALOGUE[name], rng) for name in names]

    def anew(which: tuple[int, ...]) -> list[str]:
        done = [_turned(log, 2, 0.007) if k in which else log for k, log in enumerate(logs)]
        found = check_recordings(MACHINE, done, 2, list("01234")).findings
        return [f.log for f in found if f.kind == "zero offset" and f.channel.endswith("joint3")]

    assert anew(()) == []
    assert anew((2, 3, 4)) == ["2", "3", "4"]  # no log but the fourth is at its angles
    assert anew((2, 3)) == ["2"]  # one held out is as it was: nothing is known of the fourth
    assert anew((4,)) == ["4"]


def _turned(log: Recording, column: int, shift: float) -> Recording:
    joints = log["joint/position"]
    return log.with_signals(
        {"joint/position": replace(joints, values=joints.values + shift * (np.arange(5) == column))}
    )


def test_a_load_in_another_unit_shows_beside_late_imus_and_markers_in_another_unit_do_not_look_like_it() -> None:
    late = simulated(*OFFSETS, "clock_offset:stream=imu,delay=0.16")
    loads = [log.with_signals({"load": replace(log["load"], values=log["load"].values / 1000)}) for log in late]
    assert found_in(loads) == {("load", "load")}
    assert found_in([_scaled(log, "markers", [100] * 36) for log in late]) == {("unit", "markers")}


def test_a_load_that_is_turned_or_not_logged() -> None:
    logs = simulated(*OFFSETS)
    turned = [log.with_signals({"load": replace(log["load"], values=-log["load"].values)}) for log in logs]
    told = check_recordings(MACHINE, turned, TRAINING).findings
    assert {(f.kind, f.repair.line) for f in told} == {("load", 'signal = "load": sign = -1')}
    checked = check_recordings(MACHINE, [log_faults.without(log, "load") for log in logs], TRAINING)
    assert {f.log for f in checked.findings} == {log.name for log in logs if log.name.startswith("release")}
    assert all("as if a rope had been cut" in f.sentence and f.action is Action.LEFT_OUT for f in checked.findings)
    force = logs[0]["load"]
    one = [logs[0].with_signals({"load": replace(force, values=force.values / 1000)}), *logs[1:]]
    assert [f.log for f in check_recordings(MACHINE, one, TRAINING).findings] == [logs[0].name]
    still = [log_faults.without(log, "load") for log in logs if not log.name.startswith("release")]
    assert check_recordings(MACHINE, still, 1).findings == ()


def test_noise_that_is_found_is_raised_for_its_log_and_signal() -> None:
    logs = list(simulated(*OFFSETS))
    markers, level = logs[1]["markers"], log_faults.noise_levels(MACHINE)["markers"]
    more = np.random.default_rng(2).normal(size=markers.values.shape) * 5 * level
    logs[1] = logs[1].with_signals({"markers": replace(markers, values=markers.values + more)})
    checked = check_recordings(MACHINE, logs, TRAINING)
    assert {f.log for f in checked.findings} == {logs[1].name} and not checked.noise[0]
    raised = checked.noise[1]["markers"] / level
    assert raised.min() > 3


@pytest.mark.parametrize("pace", [1.003, 0.997])
def test_a_clock_that_drifts_is_brought_back(pace: float) -> None:
    logs = simulated(*OFFSETS)
    names = [name for name in logs[0].signals if name.startswith("imu/link3")]
    fast = [log.with_signals({n: replace(log[n], time=log[n].time * pace) for n in names}) for log in logs]
    checked = check_recordings(MACHINE, fast, TRAINING)
    assert {(f.kind, f.channel) for f in checked.findings} == {("clock", "imu/link3")}
    for log, mended in zip(logs, checked.recordings, strict=True):
        assert np.abs(mended[names[0]].time - log[names[0]].time).max() < 0.01


def test_nothing_moves() -> None:
    cut = [log_faults.replace(log, signals=_first(log, 1.0)) for log in simulated(*OFFSETS)]
    assert {("at rest", ""), ("too short", "")} == found_in(cut)


def test_what_no_work_may_begin_with_is_refused_in_a_sentence() -> None:
    logs = list(simulated(*OFFSETS))
    away = logs[0]["imu/link3/angular_rate"]
    both = {n: replace(logs[0][n], time=away.time + 1.7e9) for n in logs[0].signals if n.startswith("imu/link3")}
    with pytest.raises(
        LogError, match=r"imu/link3 \(17000.* no time in common with joint/position \(0.000 to 30.000 s"
    ):
        check_recordings(MACHINE, [logs[0].with_signals(both), *logs[1:]], TRAINING).refuse()
    with pytest.raises(LogError, match=r"held out and shares 100% of its samples with mixed"):
        check_recordings(MACHINE, [*logs, replace(logs[1], name="again")], TRAINING).refuse()


def test_wiring_that_a_log_does_not_show_is_that_of_the_others() -> None:
    logs = [_scaled(log, "imu/link5/specific_force", [1, 1, -1]) for log in simulated(*OFFSETS)]
    findings = check_recordings(MACHINE, logs, TRAINING).findings
    assert len([f for f in findings if f.kind == "sign"]) == len(logs)
    one = [logs[0], *simulated(*OFFSETS)[1:]]
    assert len([f for f in check_recordings(MACHINE, one, TRAINING).findings if f.kind == "sign"]) <= 1


def test_noise_and_resolution_are_handed_on() -> None:
    step = np.radians(0.1)
    logs = list(simulated(*OFFSETS))
    joints = logs[1]["joint/position"]
    logs[1] = logs[1].with_signals({"joint/position": replace(joints, values=step * np.round(joints.values / step))})
    checked = check_recordings(MACHINE, logs, TRAINING)
    assert np.allclose(checked.noise[1]["joint/position"], np.hypot(np.radians(0.02), step / np.sqrt(12)))
    assert checked.noise[0] == {}


def test_every_check_says_what_it_is() -> None:
    assert len(all_checks()) > 15
    for check in all_checks():
        assert isinstance(check, Check) and type(check).__doc__ and check.kind
    assert [c.turn for c in all_checks()] == sorted(c.turn for c in all_checks())


def _first(log: Recording, seconds: float) -> dict[str, Signal]:
    return {n: log_faults.picked(s, s.time < s.time[0] + seconds) for n, s in log.signals.items()}


def _scaled(log: Recording, name: str, factor: list[int]) -> Recording:
    return log.with_signals({name: replace(log[name], values=log[name].values * factor)})
