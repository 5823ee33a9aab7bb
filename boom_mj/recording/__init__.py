"""Signals and recordings: the one vocabulary for measured and simulated data."""

from boom_mj.recording.names import KINDS as KINDS
from boom_mj.recording.recording import Recording as Recording
from boom_mj.recording.recording import signal_of_kind as signal_of_kind
from boom_mj.recording.signal import Signal as Signal
from boom_mj.recording.signal import align as align
from boom_mj.recording.signal import resample as resample
from boom_mj.recording.signal import spectrum as spectrum
