"""The JSON Schemas against every file that is shipped, and against wrong files. What a schema refuses the reader must
refuse, too: otherwise an editor would mark a file that runs."""

import json
import os
import subprocess
import tomllib
from pathlib import Path

import pytest
import robhaz

jsonschema = pytest.importorskip("jsonschema")
ROOT = Path(__file__).resolve().parents[3]
COMMAND = os.environ.get("ROBHAZ")
pytestmark = pytest.mark.skipif(not COMMAND, reason="the variable ROBHAZ does not name the command")


def _validator(kind):
    """A schema that is valid itself."""
    printed = subprocess.run([COMMAND, "schema", kind], check=True, capture_output=True).stdout
    schema = json.loads(printed)
    of_draft = jsonschema.validators.validator_for(schema)
    of_draft.check_schema(schema)
    return of_draft(schema)


@pytest.fixture(scope="module")
def scenes():
    return _validator("scene")


def _problems(validator, text):
    return [error.message for error in validator.iter_errors(tomllib.loads(text))]


@pytest.mark.parametrize(
    ("kind", "pattern", "least"),
    [
        ("scene", "scenes/*.toml", 12),
        ("scene", "examples/weigh/real.toml", 1),
        ("study", "studies/*.toml", 3),
        ("geometry", "robots/geometry*.toml", 2),
        ("mass", "robots/mass*.toml", 2),
        ("sensors", "examples/logs/*.toml", 2),
    ],
)
def test_shipped_files_are_valid(kind, pattern, least):
    validator = _validator(kind)
    files = sorted(ROOT.glob(pattern))
    assert len(files) >= least
    for file in files:
        assert _problems(validator, file.read_text()) == [], file


@pytest.mark.parametrize(
    "terrain", ["flat", "smooth", "cosbump", "ramp", "step", "stairs", "sine", "ditch", "rough"]
)
def test_a_resolved_scene_is_valid(scenes, terrain):
    scene = robhaz.Scene(
        {
            "terrain.kind": terrain,
            "drive.kind": "friction-test",
            "drive.friction_test.start": 2,
            "sensors.grade": "poor",
        }
    )
    assert _problems(scenes, scene.to_toml()) == []


def test_a_resolved_description_of_a_log_is_valid(tmp_path):
    flat = ["--set=terrain.kind=flat", "--set=record.duration=3", "--engine=direct"]
    for command in (["run", ROOT / "scenes/smooth.toml", "--out=run", *flat], ["estimate", "run", "--out=log"]):
        subprocess.run([COMMAND, *command], cwd=tmp_path, check=True, capture_output=True)
    assert _problems(_validator("sensors"), (tmp_path / "log/log.toml").read_text()) == []


# Texts with units, numbers for switches, and lists are as valid as for the reader.
RIGHT = [
    '[drive]\nspeed = "20 cm/s"',
    '[drive]\nspeed = " -1.5e-1   m/s "',
    '[drive]\nviscous_damping = "150 mN  m s"',
    '[robot.mass]\nbody = "5000 g"\nlinks = [1.8, 2.2, "500 g"]\nwheel = 1.5\nbody_inertia = 0.076\n'
    'link_inertias = [0.018, "225 kg cm^2", 0.0004]\nwheel_inertia = 0.0075\nrotor_inertia = 0.0864',
    '[terrain]\nkind = "sine"\namplitude = "5 mm"\nperiods = 3',
    '[terrain]\nkind = "bumps"\nbumps = [{ height = "5 cm", centre = 1, width = 0.2 }]',
    '[terrain]\nkind = "heights"\npoints = [[-1, 0], [1, "5 cm"], [2, 0]]\ninterpolation = "corners"',
    '[terrain]\nkind = "parts"\n[[terrain.part]]\nkind = "ramp"\nangle = "10 deg"\nstart = 1\nlength = 1',
    '[[terrain.stretch]]\nfrom = 0\nto = "50 cm"\nmu_s = 0.5\nmu_d = 0.4',
    '[[estimator]]\nname = "kalman"\nlabel = "mine"\nparity = false\n[[estimator]]\nname = "kalman"',
    '[drive]\nscaling = [{ wheels = [1, 3], from = 2, to = "3 s", factor = 0 }]',
    'estimator = []\nseed = 7\nname = "a-b_c"',
]
WRONG = [
    "[drive]\nsped = 0.2",
    "[drives]\nspeed = 0.2",
    "[drive]\nspeed = 11",
    '[drive]\nspeed = "20 cm"',
    '[drive]\nspeed = "fast"',
    "[drive]\nspeed = [0.2]",
    "[drive]\ntorque_limit = 0",
    '[drive]\nkind = "torque"',
    "[drive]\nscaling = [{ wheels = [4], from = 2, to = 3, factor = 0 }]",
    "[drive]\nscaling = [{ wheels = [1], from = 2, factor = 0 }]",
    '[sensors]\ngrade = "good"',
    '[terrain]\nkind = "hill"',
    '[terrain]\nkind = "ramp"\nrise = 0.1',
    "[terrain]\nangle = 0.1",
    '[terrain]\nkind = "bumps"',
    '[terrain]\nkind = "sine"\nperiods = 2.5',
    '[terrain]\nkind = "parts"\npart = [{ kind = "flat" }]',
    '[terrain]\nkind = "heights"\npoints = [[0, 0]]',
    '[robot]\ngeometry = "D"',
    "[robot.mass]\nbody = 5",
    '[[estimator]]\nlabel = "mine"',
    '[[estimator]]\nname = "worst"',
    '[estimator]\nname = "kalman"',
    "[record]\nduration = 0",
    "seed = -1",
    'name = "My Scene"',
]
RIGHT_STUDIES = [
    '[[axis]]\nkey = "terrain.part.0.height"\nvalues = [1]',
    '[[axis]]\nkey = "estimator[0].observer_pole"\nlog_uniform = [1, 100]\n[draw]\ncount = 3\n'
    'method = "random"',
    '[[axis]]\nkeys = ["drive.kp", "drive.ki"]\nnames = ["soft"]\nvalues = [[2, 0]]',
    'tables = [0]\n[[axis]]\nkey = "sensors"\nvalues = [{ grade = "poor" }]\n[[axis]]\nkey = "seed"\n'
    "first = 2\ncount = 3",
]
WRONG_STUDIES = [
    "",
    "axis = []\nkey = 3",
    '[[axis]]\nkey = "seed"',
    '[[axis]]\nkey = "seed"\ncount = 0',
    '[[axis]]\nkey = "seed"\ncount = 2\nvalues = [1]',
    '[[axis]]\nkey = "seed"\nkeys = ["seed"]\nvalues = [1]',
    "[[axis]]\ncount = 2",
    '[[axis]]\nkey = "drive.kp"\nuniform = [1]\n[draw]\ncount = 3',
    '[[axis]]\nkey = "drive.kp"\nuniform = [1, 2]\n[draw]\nmethod = "random"',
    '[[axis]]\nkey = "drive.kp"\nuniform = [1, 2]\n[draw]\ncount = 3\nmethod = "grid"',
    '[[axis]]\nkey = "seed"\ncount = 2\nnames = ["a", "a"]',
    'axes = 3\n[[axis]]\nkey = "seed"\ncount = 2',
    'set = "drive.kp=2"\n[[axis]]\nkey = "seed"\ncount = 2',
    'tables = "some"\n[[axis]]\nkey = "seed"\ncount = 2',
]


@pytest.mark.parametrize("text", RIGHT)
def test_what_the_reader_takes_is_valid(scenes, text):
    robhaz.Scene(text=text)
    assert _problems(scenes, text) == []


@pytest.mark.parametrize("text", WRONG)
def test_a_wrong_scene_is_invalid_and_refused(scenes, text):
    assert _problems(scenes, text) != []
    with pytest.raises(robhaz.SceneError):
        robhaz.Scene(text=text)


def _reads(folder, text):
    """Whether the command reads a study of a scene."""
    (folder / "a.toml").write_text('name = "a"\n')
    (folder / "study.toml").write_text(text)
    done = subprocess.run([COMMAND, "study", "study.toml", "--dry-run"], cwd=folder, capture_output=True)
    return done.returncode == 0


@pytest.mark.parametrize("rest", RIGHT_STUDIES)
def test_a_study_that_the_reader_takes_is_valid(tmp_path, rest):
    text = f'scene = "a.toml"\n{rest}'
    assert _problems(_validator("study"), text) == []


@pytest.mark.parametrize("rest", [*WRONG_STUDIES, '[[axis]]\nkey = "drive.sped"\nvalues = [1]'])
def test_a_wrong_study_is_invalid_and_refused(tmp_path, rest):
    text = f'scene = "a.toml"\n{rest}'
    assert _problems(_validator("study"), text) != []
    assert not _reads(tmp_path, text)
