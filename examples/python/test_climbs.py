"""What a robot climbs: against closed forms and the judgement of each size. Needs the command `robhaz` (variable ROBHAZ)."""

import math
import shutil
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
import climbs

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.skipif(shutil.which(climbs.ROBHAZ) is None, reason="no command robhaz")


@pytest.fixture(scope="module")
def rover():
    return climbs.Rover.load(ROOT / "robots/exomy.toml")


def test_the_search_ends_below_the_first_size_that_fails():
    assert climbs.largest(lambda size: size < 1.23, 0.02, 6.0) == pytest.approx(1.22)
    assert climbs.largest(lambda size: True, 0.02, 6.0) > 5.8
    assert climbs.largest(lambda size: False, 0.02, 6.0) == 0.0


def test_a_slope_at_rest_is_that_of_the_friction(rover):
    """tan(slope) = mu for a robot at rest, to the finest step; beyond it friction fails."""
    at_rest, why, driven = climbs.row(rover, "slope", 1, 0.4)
    bound = math.degrees(math.atan(0.4))
    assert bound - climbs.FINEST["slope"] < at_rest <= bound and why.startswith("friction")
    # Driven, the speed control needs some more.
    assert at_rest - 2.0 < driven <= at_rest


def test_a_kerb_is_the_last_that_passes(rover):
    at_rest, why, driven = climbs.row(rover, "kerb", 1, 0.4)
    assert climbs.judged(rover, "kerb", at_rest, 0.4) is None
    assert climbs.judged(rover, "kerb", at_rest + climbs.FINEST["kerb"], 0.4) == why
    assert 0.3 < at_rest < 1.0 and 0.3 < driven < 1.0
