"""Cameras that watch a boom: rig, pictures with labels, data sets, and the way back from pictures to markers."""

import os

MOST_PIXELS = 2**28  # as many as the largest camera has; OpenCV heeds it only if told before it is imported

os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(MOST_PIXELS))
