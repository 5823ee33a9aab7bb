"""A campaign: which recordings are learnt from, and what is simulated."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from boom_mj.gap import Campaign
from boom_mj.logs import read_log
from boom_mj.machine import load_machine
from boom_mj.recording import window

ROOT = Path(__file__).parents[2]


def test_the_first_part_of_a_borrowed_recording_is_learnt_from_and_nothing_is_simulated_again() -> None:
    log = read_log(ROOT / "logs" / "independent_release_stretched_vertical.mcap")
    short = replace(log, signals={name: window(signal, 7.0, 9.0) for name, signal in log.signals.items()})
    campaign = Campaign(load_machine(ROOT / "models" / "boom36.toml"), [short] * 3, 1, threads=1)
    level = campaign.subject.fidelity.rough
    (whole,), before = campaign.predict([()], level), campaign.simulated_s
    other = campaign.borrowing(2)
    (part,) = other.predict([()], level, training_only=True)
    assert other.simulated_s == before > 0
    own = campaign.recording_of
    assert np.isnan(part[own == 1]).all() and np.array_equal(part[own != 1], whole[own != 1], equal_nan=True)
    assert set(own[campaign.train]) == {0} and set(own[other.train]) == {0, 2}
    assert set(own[other.held_out]) == {1, 2}
    assert campaign.time[other.train & (own == 2)].max() < 1.2 <= campaign.time[other.held_out & (own == 2)].min()
