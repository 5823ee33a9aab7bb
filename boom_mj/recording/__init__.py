"""Recordings: signals with time, unit and frame, measured or simulated alike; nothing downstream can tell which."""

from boom_mj.recording.names import QUANTITIES as QUANTITIES
from boom_mj.recording.names import Quantity as Quantity
from boom_mj.recording.names import named_signal as named_signal
from boom_mj.recording.names import point_channels as point_channels
from boom_mj.recording.recording import Recording as Recording
from boom_mj.recording.scene import Scene as Scene
from boom_mj.recording.signal import Signal as Signal
from boom_mj.recording.signal import Spectrum as Spectrum
from boom_mj.recording.signal import align as align
from boom_mj.recording.signal import resample as resample
from boom_mj.recording.signal import sample as sample
from boom_mj.recording.signal import spectrum as spectrum
from boom_mj.recording.signal import window as window
from boom_mj.recording.units import UNITS as UNITS
