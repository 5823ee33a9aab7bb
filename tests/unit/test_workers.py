"""Processes and what they hold."""

import os
import subprocess
import sys

import pytest

SCRIPT = """
import numpy as np
from boom_mj.workers import return_memory
return_memory()
np.ones(2**21)  # 16 MB, freed: from then on glibc takes smaller ones from its heap
pairs = [(np.ones(2**18), np.ones(2**10)) for _ in range(200)]
kept = [small for large, small in pairs]  # 2 MB go, 8 kB stay
del pairs
print(int(open("/proc/self/statm").read().split()[1]) * 4 // 1024)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="glibc")
def test_memory_of_large_arrays_goes_back() -> None:
    """Without asking for it 400 MB mostly stay."""
    plain = {name: value for name, value in os.environ.items() if not name.startswith("MALLOC_")}  # Dask leaves some
    done = subprocess.run([sys.executable, "-c", SCRIPT], env=plain, capture_output=True, text=True, check=True)
    assert int(done.stdout) < 150
