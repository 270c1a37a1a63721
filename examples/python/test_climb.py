"""The design search: its constraints against closed forms and the simulator, its drives, and a search of few designs.

    PYTHONPATH=target/python pytest examples/python    (docs/python.md says how to build target/python)
"""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
robhaz = pytest.importorskip("robhaz", reason="the package robhaz is not installed: docs/python.md")
pytest.importorskip("scipy", reason="pip install scipy")
import climb

# Geometry C as a point of the search.
C = [0.390, 0.406, 0.375, 0.112, 0.025, 0.116, -0.303, 0.111, -0.144, 0.230, -0.016, 0.345]


def test_a_point_of_the_search_is_the_geometry_of_its_file():
    """On whole millimetres, with wheels, carriers and stops of A: equal to the built-in C in every number."""
    found = climb.resolved(climb.design(np.array(C) + 0.0004))["geometry"]
    expected = climb.resolved("C")["geometry"]
    assert {**found, "name": "C"} == expected


@pytest.mark.parametrize("name", ["A", "C"])
def test_static_loads_are_those_of_the_simulator(name):
    """At rest on level ground. Wheels of the simulator are pressed 0.55 to 0.58 mm into the ground: the difference of
    0.03 mm turns the links by 1e-4 rad, which changes the loads by a few mN. Measured: 1.7 mN at most."""
    keys = {"robot.geometry": name, "terrain.kind": "flat", "engine.kind": "direct", "record.duration": 0.7,
            "record.compare_from": 0.5, "drive.start_time": 0.8}
    truth = robhaz.Scene(keys).run().truth
    simulated = [truth[f"wheel{i}_normal_force"][-1] for i in (1, 2, 3)]
    np.testing.assert_allclose(climb.static_loads(climb.resolved(name)["geometry"]), simulated, atol=0.01)


def test_constraints():
    """A and C meet all; a search step that breaks one costs more than every design that breaks none."""
    assert climb.violation(climb.design(C)) == climb.violation(climb.A["geometry"]) == 0
    assert climb.reach(climb.design(C)) == pytest.approx(0.212, abs=5e-4)
    # In the nominal pose the sine at pin S follows from the pins.
    geometry = climb.design(C) | {"stop": {"lower": 0.0, "upper": 0.0}}
    body, link3 = complex(-0.144 - 0.375, 0.230 - 0.112), complex(-0.144 + 0.303, 0.230 - 0.111)
    expected = abs(climb.cross(body, link3)) / abs(body * link3)
    assert climb.sines(geometry) == pytest.approx(np.full(16, expected))
    # Unequal loads, a bar of 5 mm, little reach, body and link3 nearly in line.
    for place, value in ((10, 0.1), (6, 0.03), (4, 0.25), (9, 0.13)):
        changed = [*C]
        changed[place] = value
        assert climb.violation(climb.design(changed)) > 0 and climb.cost(changed) > 1
    # P above Q above the front axle: the loads are not determined, or the loop has no length.
    assert climb.violation(climb.design([0.22, *C[1:4], 0.22, *C[5:]])) > 0
    assert climb.violation(climb.design([*C[:4], 0.375, 0.112, *C[6:]])) == climb.UNDETERMINED


def test_drives():
    """Acceptance: C climbs 80 mm at mu_s 0.8 under each control and not at 0.4, A does not at 0.8; C passes eleven of
    the trials, as docs/climbing.md says."""
    geometry = climb.design(C)
    for control in climb.CONTROLS:
        assert climb.passes(geometry, control, 0.8, 0.08, 0.3), control
    end, share, stop, clear, truth = climb.drive(geometry, "speed, PI", 0.4, 0.08, 0.3)
    assert end == "stuck" and 0 < share < 1 and stop > climb.LEAST_STOP_MARGIN and clear > climb.LEAST_CLEARANCE
    assert climb.drive(climb.A["geometry"], "speed, PI", 0.8, 0.08, 0.3)[0] == "stuck"
    assert -12 < climb.cost(C) <= -11
    # A clearance of 5 mm is demanded: with a body that reaches down to 4 mm the same drive does not count.
    low = climb.resolved("C")["geometry"]["outline"] | {"body_lower": [-0.28, 0.004]}
    assert climb.drive(geometry | {"outline": low}, "speed, PI", 0.8, 0.08, 0.3)[0] == "no margin"


def test_a_search_gives_the_same_design_on_any_number_of_processes(tmp_path, monkeypatch, capsys):
    """Its file is a geometry that meets the constraints, and the best design does not get worse."""
    monkeypatch.chdir(tmp_path)
    texts = []
    for jobs in ("1", "2"):
        out = f"{jobs}.toml"
        climb.main(["search", "--population", "5", "--generations", "2", "--jobs", jobs, "--out", out])
        texts.append(Path(out).read_text())
    assert texts[0] == texts[1]
    assert climb.violation(climb.resolved(out)["geometry"]) == 0
    printed = capsys.readouterr().out
    best = [float(line.split()[2]) for line in printed.splitlines() if line.startswith("generation")]
    assert best[0] <= best[1] and "15 designs" in printed
    # A mistake has the message of the command.
    with pytest.raises(SystemExit):
        climb.main(["table", "nowhere.toml"])
    assert "robot.geometry" in capsys.readouterr().err
