"""Estimation from recordings: numpy, scipy and recordings, no machine, no effect, no simulator."""
