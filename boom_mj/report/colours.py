"""Colours that mean the same in every picture."""

MEASURED, NOMINAL, CORRECTED = "#222222", "#d55e00", "#0072b2"
QUIET, FAINT = "#5b6270", "#d9dce1"  # axes and captions; grid and what is not there
