"""Cameras that watch a boom: rig, pictures with labels, data sets, and the way back from pictures to markers."""
