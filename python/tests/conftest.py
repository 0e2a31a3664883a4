"""What several files of tests begin with."""

import os
from pathlib import Path

import pytest

import borescope as bs

ROOT = Path(os.environ.get("BORESCOPE_ROOT", Path(__file__).parents[2]))


@pytest.fixture(scope="module")
def tanks():
    return bs.Rig(ROOT / "fixtures/two_tanks/rig.toml")


@pytest.fixture(scope="module")
def clogged(tanks):
    return tanks.simulate(set={"upper_outlet.diameter": "6.5 mm"}, seed=1)
