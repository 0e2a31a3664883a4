"""Calls from several threads at once, with and without Python's lock; needs nothing but pytest."""

import multiprocessing
import os
import sys
import sysconfig
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import borescope as bs

ROOT = Path(os.environ.get("BORESCOPE_ROOT", Path(__file__).parents[2]))
TANKS = str(ROOT / "fixtures/two_tanks/rig.toml")
CLOGGED = {"upper_outlet.diameter": "6.5 mm"}


@pytest.mark.skipif(not sysconfig.get_config_var("Py_GIL_DISABLED"), reason="this Python has its lock: a free-threaded one was not tried")
def test_a_free_threaded_python_stays_without_lock():
    assert not sys._is_gil_enabled()


def test_threads_share_a_rig():
    rig = bs.Rig(TANKS)
    records = [rig.simulate(set=CLOGGED if seed % 2 else None, seed=seed) for seed in range(8)]
    alone = [rig.diagnose(record).json for record in records]
    with ThreadPoolExecutor(4) as pool:
        for _ in range(3):
            assert list(pool.map(lambda record: rig.diagnose(record).json, records)) == alone


def left_behind(_):
    """Calls that leave threads in a process behind, with their number."""
    rig = bs.Rig(TANKS)
    healthy = [rig.simulate(seed=seed) for seed in (1, 2)]
    clogged = rig.simulate(set=CLOGGED, seed=1)
    calls = {
        "diagnose": lambda: rig.diagnose(clogged),
        "compare": lambda: rig.compare(clogged),
        "suggest": lambda: rig.suggest(clogged),
        "improve": lambda: rig.improve(clogged, healthy[0]),
        "calibrate": lambda: rig.calibrate(healthy),
        "isolability": rig.isolability,
        "campaign": lambda: rig.campaign(2, rigs=1),
    }
    left = {}
    for name, call in calls.items():
        call()
        # Threads of a call end after it, of themselves.
        until = time.monotonic() + 60
        while (count := len(os.listdir("/proc/self/task")) - 1) and time.monotonic() < until:
            time.sleep(0.01)
        if count:
            left[name] = count
    return left


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="threads cannot be counted here")
def test_a_call_leaves_no_threads_that_a_fork_would_lose():
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.map(left_behind, [None]) == [{}]
