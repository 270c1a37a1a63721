"""The package gives what the command gives: the same tables, the same errors, for every library of tables."""

import ast
import json
import os
import runpy
import signal
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
import robhaz

ROOT = Path(__file__).resolve().parents[3]
SHORT = {"terrain.kind": "flat", "record.duration": 3, "sensors.grade": "typical"}

SETTINGS = [f"--set={key}={value}" for key, value in SHORT.items()]


def _command(folder, *arguments):
    """Runs the command that the variable ROBHAZ names. Returns its standard output."""
    command = os.environ.get("ROBHAZ")
    if not command:
        pytest.skip("the variable ROBHAZ does not name the command")
    return subprocess.run([command, *arguments], cwd=folder, check=True, capture_output=True).stdout


@pytest.fixture(scope="module")
def scene():
    return robhaz.Scene(SHORT)


@pytest.fixture(scope="module")
def run(scene):
    return scene.run()


def test_static_forces_on_level_ground():
    """Closed form: the static loads of robot A, 1e-4 N for what settles."""
    estimate = robhaz.Estimator("true-mass").update(0.0, [0] * 3, [0] * 3, [0, 0], [0, 0], [0] * 3)
    assert estimate.normal_force == pytest.approx((43.5835, 48.0458, 45.7107), abs=1e-3)
    assert sum(estimate.normal_force) == pytest.approx(14 * 9.81, abs=1e-9)
    assert estimate.covariance is None and estimate.flags == []


OSR = ROOT / "robots" / "open-source-rover.toml"
# Closed form of the Open Source Rover at rest on a cross slope of 10 deg, left side up, N.
ON_10_DEG = (15.8275, 20.8107, 16.2938, 20.0988, 28.7239, 20.9395)


def _at_rest(rows):
    """Readings of both sides at rest on that slope, 5 ms apart, by the default names."""
    wheels = [f"{side}_wheel{i}" for side in ("left", "right") for i in (1, 2, 3)]
    zero = [f"{wheel}_{what}" for wheel in wheels for what in ("angle", "motor_torque")]
    zero += ["left_pin_angle", "right_pin_angle", "differential_angle", "body_inclination"]
    zero += ["body_roll_rate", "body_rate", "body_yaw_rate"]
    readings = {name: np.zeros(rows) for name in zero}
    return readings | {"time": 0.005 * np.arange(rows), "body_roll": np.full(rows, np.radians(10))}


@pytest.mark.filterwarnings("ignore:budget.body_cg")
def test_six_wheels_at_rest_on_a_cross_slope():
    """Closed form, and equivalence of frames with a table, to the bit."""
    estimator = robhaz.WholeEstimator(OSR)
    zero = ([0] * 6, [0] * 6, [0, 0], 0, 0)
    for k in range(3):
        found = estimator.update(0.005 * k, *zero, np.radians(10), [0, 0, 0])
    # 1e-3: the closed form has four decimals; no reading errs, and rest needs no weights.
    assert found.normal_force == pytest.approx(ON_10_DEG, abs=1e-3)
    assert sum(found.traction) == pytest.approx(0, abs=1e-6) and found.flags == []
    # Closed form: W sin(phi) to the left, up the slope of the left side; A/N = tan(phi).
    assert found.lateral_force == pytest.approx(124.587 * np.sin(np.radians(10)), abs=1e-3)
    assert found.tip_line == "right" and 0 < found.tip_margin < 1 and not found.dragged
    table = robhaz.WholeEstimator(OSR).estimate(_at_rest(3))
    assert table.units["left_wheel1_normal_force"] == "N" and len(table) == 3
    for k, name in enumerate(f"{side}_wheel{i}" for side in ("left", "right") for i in (1, 2, 3)):
        assert table[f"{name}_normal_force"][2] == found.normal_force[k]
        assert table[f"{name}_normal_force_sigma"][2] == found.normal_force_sigma[k]
    assert table["right_wheel3_contacts"][2] == 1 and table["left_flags"][2] == 0
    assert table["tip_line"][2] == 1 and table["tip_margin"][2] == found.tip_margin


@pytest.mark.filterwarnings("ignore:budget.body_cg")
def test_faults_of_six_wheels_are_named(tmp_path):
    with pytest.raises(ValueError, match="one-side.toml without .robot.across., allowed: "):
        one_side = tmp_path / "one-side.toml"
        one_side.write_text('[robot]\ngeometry = "A"\n')
        robhaz.WholeEstimator(one_side)
    readings = _at_rest(2)
    del readings["right_pin_angle"]
    with pytest.raises(KeyError, match='no column "right_pin_angle", found: left_wheel1_angle, '):
        robhaz.WholeEstimator(OSR).estimate(readings)
    readings = _at_rest(2) | {"time": np.zeros(2), "body_roll": np.zeros(2)}
    with pytest.raises(robhaz.EstimateError, match="row 1: time must increase"):
        robhaz.WholeEstimator(OSR).estimate(readings)
    with pytest.raises(ValueError, match='column "differential_angle" of 3 rows, allowed: 2'):
        robhaz.WholeEstimator(OSR).estimate(_at_rest(2) | {"differential_angle": np.zeros(3)})
    with pytest.raises(robhaz.EstimateError, match="no frame so far has the reading"):
        robhaz.WholeEstimator(OSR).update(0.0, [None] * 6, [0] * 6, [0, 0], 0, 0, 0, [0, 0, 0])
    with pytest.raises(robhaz.EstimateError, match="no row has an estimate; row 1: no frame so far has the reading"):
        robhaz.WholeEstimator(OSR).estimate(_at_rest(2) | {"differential_angle": np.full(2, np.nan)})
    # A row without an estimate is empty.
    late = _at_rest(2) | {"left_pin_angle": np.array([np.nan, 0.0])}
    table = robhaz.WholeEstimator(OSR).estimate(late)
    assert np.isnan(table["right_wheel3_normal_force"][0]) and table["time"][0] == 0.0
    # What is masked is missing.
    masked = late | {"left_pin_angle": np.ma.masked_array([5.0, 0.0], mask=[True, False])}
    found = robhaz.WholeEstimator(OSR).estimate(masked)["right_wheel3_normal_force"]
    assert np.array_equal(found, table["right_wheel3_normal_force"], equal_nan=True)


@pytest.mark.filterwarnings("ignore:budget.body_cg")
def test_the_robot_says_which_coupling_it_has():
    """Equivalence: the column of the other coupling does not count, whatever it holds, and does not stand for its own."""
    readings = _at_rest(3)
    table = robhaz.WholeEstimator(OSR).estimate(readings)
    assert table.name == "estimate-kalman"
    for other in (np.full(3, 0.2), np.full(3, np.nan)):
        found = robhaz.WholeEstimator(OSR).estimate(readings | {"rear_bogie_angle": other})
        np.testing.assert_array_equal(found["left_wheel1_normal_force"], table["left_wheel1_normal_force"])
    with pytest.raises(KeyError, match='no column "rear_bogie_angle"'):
        robhaz.WholeEstimator(ROOT / "robots" / "marta.toml").estimate(readings)


@pytest.mark.filterwarnings("ignore:.*budget.body_cg")
def test_sides_that_an_estimator_is_not_of_are_refused(tmp_path):
    """As the command does, with the place of the key."""
    sensors = tmp_path / "x.toml"
    sensors.write_text('sides = "both"\n')
    with pytest.raises(robhaz.SceneError, match='x.toml:1: sides: found "both", allowed: "one of two", "plane"'):
        robhaz.Estimator(sensors=sensors)
    robhaz.WholeEstimator(OSR, sensors=sensors)
    sensors.write_text('\nsides = "plane"\n')
    with pytest.raises(robhaz.SceneError, match='x.toml:2: sides: found "plane", allowed: "both"'):
        robhaz.WholeEstimator(OSR, sensors=sensors)
    robhaz.Estimator(sensors=sensors)


def test_a_table_has_the_columns_and_units_of_a_run(run):
    assert list(run.tables)[:2] == ["truth", "sensors"]
    assert list(run.estimates) == ["paper-body", "paper-wheels", "true-mass", "kalman", "kalman-no-angles"]
    assert set(run.ground) == {"kalman", "kalman-no-angles"}
    truth = run.truth
    assert truth.units["wheel1_normal_force"] == "N" and truth.units["time"] == "s"
    assert len(truth) == len(truth["time"]) == 3001
    assert truth["wheel1_contacts"].dtype == np.uint32
    assert list(truth) == truth.columns and "time" in truth and "no" not in truth
    with pytest.raises(KeyError, match='no column "no", allowed: time, '):
        truth["no"]


def test_the_summary_is_that_of_the_tables(run):
    """Equivalence: RMS error of N of `kalman` from the tables against the summary. 1e-9: another order of summation."""
    counted = run.truth["time"] >= 2.0 - 1e-9
    estimate = run.estimates["kalman"]
    names = [f"wheel{i}_normal_force" for i in (1, 2, 3)]
    errors = np.array([(estimate[n] - run.truth[n])[counted] for n in names])
    expected = run.summary["estimators"]["kalman"]["normal_force"]["rmse_all"]
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(expected, rel=1e-9)
    assert "kalman-no-angles" in str(run)


def test_the_table_is_that_of_the_command(run, tmp_path):
    """Equivalence with `robhaz run`, as CSV with all digits: the same values to the bit."""
    (tmp_path / "scene.toml").write_text("")
    _command(tmp_path, "run", "scene.toml", *SETTINGS, "--out", "out", "--format", "csv", "--rerun", "off")
    for name, table in run.tables.items():
        read = np.genfromtxt(tmp_path / "out" / f"{name}.csv", delimiter=",", names=True)
        assert list(read.dtype.names) == table.columns
        for column in table.columns:
            assert np.array_equal(read[column], table[column], equal_nan=True), (name, column)


def _sources(table):
    """The same readings as every kind of table."""
    yield table
    yield dict(table)
    pyarrow = pytest.importorskip("pyarrow")
    yield pyarrow.table(table)
    pandas = pytest.importorskip("pandas")
    yield pandas.DataFrame(dict(table))
    polars = pytest.importorskip("polars")
    yield polars.DataFrame(table)


@pytest.mark.parametrize("name", ["kalman", "kalman-no-angles", "paper-wheels"])
def test_a_whole_table_gives_the_estimates_of_the_run(scene, run, name):
    """Equivalence: the estimator on the readings of the run, to the bit, whatever library holds them."""
    expected = run.estimates[name]
    for readings in _sources(run.sensors):
        found = scene.estimator(name).estimate(readings)
        assert found.columns == expected.columns and found.units == expected.units
        for column in found.columns:
            assert np.array_equal(found[column], expected[column], equal_nan=True), column


def test_frame_by_frame_gives_the_same(scene, run):
    """Equivalence: one frame at a time against the whole table, to the bit; NaN and None are both a missing reading."""
    readings = {name: run.sensors[name].copy() for name in run.sensors}
    readings["wheel2_motor_torque"][500:520] = np.nan
    table = scene.estimator("kalman").estimate(readings)
    estimator = scene.estimator("kalman")
    wheels = [[readings[f"wheel{i}_{r}"] for i in (1, 2, 3)] for r in ("angle", "motor_torque", "contact_angle")]
    links = [[readings[f"link{i}_{r}"] for i in (1, 2)] for r in ("inclination", "rate")]
    for row in range(1000):
        angle, torque, contact = ([c[row] for c in columns] for columns in wheels)
        if row % 2 and np.isnan(torque[1]):
            torque[1] = None
        estimate = estimator.update(
            readings["time"][row], angle, torque, *([c[row] for c in link] for link in links), contact
        )
        assert estimate.normal_force == tuple(table[f"wheel{i}_normal_force"][row] for i in (1, 2, 3))
        assert ("reading missing" in estimate.flags) == (500 <= row < 520)
    sigma = np.sqrt(np.diag(estimate.covariance))
    assert sigma[1::2] == pytest.approx(estimate.normal_force_sigma)
    assert sigma[0::2] == pytest.approx(estimate.traction_sigma)


def test_arrow_carries_units(run):
    pyarrow = pytest.importorskip("pyarrow")
    for table in run.tables.values():
        arrow = pyarrow.table(table)
        assert arrow.num_rows == len(table)
        for field in arrow.schema:
            assert field.metadata[b"unit"].decode() == table.units[field.name]
            assert field.metadata[b"description"].decode() == table.descriptions[field.name]
            column = arrow[field.name].to_numpy()
            assert np.array_equal(column, table[field.name], equal_nan=True)


def test_arrow_outlives_the_table():
    """A consumer keeps the data when the table is gone, and a capsule without a consumer is freed."""
    pyarrow = pytest.importorskip("pyarrow")
    run = robhaz.Scene({**SHORT, "record.duration": 2.5}).run()
    arrow, expected = pyarrow.table(run.truth), run.truth["body_x"]
    run.truth.__arrow_c_stream__()
    del run
    assert np.array_equal(arrow["body_x"].to_numpy(), expected)


def test_overrides_take_python_values():
    values = {
        "seed": 7,
        "drive.speed": "30 cm/s",
        "sensors.torque_noise": np.float64(0.25),
        "drive.scaling": [{"wheels": [1, 3], "from": 1, "to": 2.5, "factor": 0.5}],
    }
    scene = robhaz.Scene(values)
    text = scene.to_toml()
    assert scene.seed == 7 and "speed = 0.3" in text and "torque_noise = 0.25" in text and "factor = 0.5" in text
    assert robhaz.Scene(text=text).to_toml() == text
    assert robhaz.Scene(["seed=7"]).seed == 7
    with pytest.raises(TypeError, match="seed: found <object object at"):
        robhaz.Scene({"seed": object()})


def test_values_within_values_and_parts_of_keys_are_limited():
    """An error in place of the end of the process."""
    itself, deep = [], 0.0
    itself.append(itself)
    for _ in range(100_000):
        deep = [deep]
    for value in (itself, deep):
        with pytest.raises(
            ValueError, match="terrain.points: found more than 16 lists or dictionaries within each other"
        ):
            robhaz.Scene({"terrain.points": value})
    with pytest.raises(robhaz.SceneError, match="found a key of 60001 parts, allowed: at most 32"):
        robhaz.Scene(["a." * 60_000 + "a=1"])


def test_errors_have_the_text_of_the_command(tmp_path):
    path = tmp_path / "x.toml"
    path.write_text("[drive]\ntorque_limit = -3\nsped = 1\n")
    with pytest.raises(robhaz.SceneError) as error:
        robhaz.Scene.load(path)
    lines = str(error.value).splitlines()
    assert lines[0] == f"{path}:2: drive.torque_limit: found -3, allowed: a number above 0 and at most 1e6, in N m"
    assert lines[1].startswith(f"{path}:3: drive.sped: unknown key, allowed: ") and lines[1].endswith(
        "did you mean speed?"
    )
    assert issubclass(robhaz.SceneError, ValueError)
    with pytest.raises(ValueError, match='^estimator: found "klaman", allowed: .*did you mean kalman'):
        robhaz.Estimator("klaman")
    with pytest.raises(ValueError, match='contact_angles: found "no", allowed: "given", "none"'):
        robhaz.Estimator(contact_angles="no")
    with pytest.raises(ValueError, match="paper-body cannot estimate without contact angles"):
        robhaz.Estimator("paper-body", contact_angles="none")
    with pytest.raises(robhaz.SceneError, match="no.toml"):
        robhaz.Estimator(sensors=tmp_path / "no.toml")
    steep = {"terrain.kind": "ramp", "terrain.start": -5, "terrain.angle": "60 deg", "terrain.length": 20}
    with pytest.raises(robhaz.RunError, match="^cannot start scene: the robot cannot stand at its start: "):
        robhaz.Scene(steep).run()


def test_a_robot_whose_errors_are_not_stated_counts_as_people_build_them(run, tmp_path):
    """The same default as that of the command on a log: the same deviations. A stated budget is silent.

    The command measures the torques' noise in the log where none is stated; an estimator on a robot cannot.
    """
    (tmp_path / "mine.toml").write_text("[budget]\ntorque_noise = 0.1\n")
    with pytest.warns(
        UserWarning, match="^kalman: budget.body_cg and budget.link_masses are not stated, .* parts to 3 %"
    ):
        found = robhaz.Estimator("kalman", sensors=tmp_path / "mine.toml").estimate(run.sensors)
    names = run.sensors.columns
    rows = zip(*(run.sensors[name] for name in names))
    lines = [",".join(repr(float(value)) for value in row) for row in rows]
    (tmp_path / "log.csv").write_text("\n".join([",".join(names), *lines]) + "\n")
    arguments = ["--estimator", "kalman", "--format", "csv", "--rerun", "off", "--out", "out"]
    _command(tmp_path, "estimate", "log.csv", "--sensors", "mine.toml", *arguments)
    table = np.genfromtxt(tmp_path / "out" / "estimate-kalman.csv", delimiter=",", names=True)
    for column in ("wheel1_normal_force", "wheel1_normal_force_sigma", "wheel3_traction_sigma"):
        np.testing.assert_array_equal(found[column], table[column])
    (tmp_path / "stated.toml").write_text("[budget]\nbody_cg = 0.001\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        robhaz.Estimator("kalman", sensors=tmp_path / "stated.toml")


def test_readings_that_cannot_be_taken(run):
    readings = dict(run.sensors)
    estimator = robhaz.Estimator("kalman", contact_angles="none")
    with pytest.raises(KeyError, match='no column "link2_rate", found: time, '):
        estimator.estimate({k: v for k, v in readings.items() if k != "link2_rate"})
    with pytest.raises(ValueError, match="of 10 rows, allowed: 3001"):
        estimator.estimate({**readings, "link2_rate": np.zeros(10)})
    with pytest.raises(ValueError, match="has 2 axes, allowed: 1"):
        estimator.estimate({**readings, "link2_rate": np.zeros((3001, 2))})
    twice = {**readings, "time": np.where(np.arange(3001) == 17, 0.016, readings["time"])}
    with pytest.raises(robhaz.EstimateError, match="^row 17: time must increase by at least 0.5 us"):
        estimator.estimate(twice)
    without = {k: v for k, v in readings.items() if "contact" not in k}
    assert len(robhaz.Estimator("kalman", contact_angles="none").estimate(without)) == 3001
    with pytest.raises(robhaz.EstimateError, match="no frame so far has the reading wheel_angle"):
        robhaz.Estimator("kalman").update(0, [None] * 3, [0] * 3, [0, 0], [0, 0], [0] * 3)


def test_a_study_is_that_of_the_command(scene, tmp_path):
    study = robhaz.study(scene, 2)
    result = study.as_dict()
    assert result["seeds"] == [0, 1]
    assert [line["name"] for line in result["estimators"]] == scene.estimators
    assert "within" in str(study)
    with pytest.raises(ValueError, match="seeds: found 0, allowed: 1 to 10000"):
        robhaz.study(scene, 0)
    (tmp_path / "scene.toml").write_text("")
    said = _command(tmp_path, "study", "scene.toml", *SETTINGS, "--seeds", "2", "--json")
    document = json.loads(said)
    assert result == {key: document[key] for key in result}


def test_other_threads_go_on(run):
    """Python's lock is released: a thread counts while a table is estimated, and two tables give the same as one."""
    count, done = 0, threading.Event()

    def count_up():
        nonlocal count
        while not done.is_set():
            count += 1
            time.sleep(1e-4)

    thread = threading.Thread(target=count_up)
    thread.start()
    before = count
    robhaz.Estimator("kalman").estimate(run.sensors)
    during = count - before
    done.set()
    thread.join()
    assert during > 1


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_stops_a_run():
    # A job in the background of a shell starts with SIGINT ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            robhaz.Scene({"record.duration": 500}).run()
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)


def test_stub_and_module_have_the_same_names():
    """Every class, method and property has a type and a docstring in the stub, and nothing else is there."""
    stub = ast.parse((Path(robhaz.__file__).parent / "_robhaz.pyi").read_text())
    classes = {
        node.name: node for node in stub.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    }
    assert set(classes) | {"study", "__version__"} == set(robhaz.__all__)
    for name, node in classes.items():
        found = {n for n in vars(getattr(robhaz, name)) if not n.startswith("_")}
        stated = {n.name for n in node.body if isinstance(n, ast.FunctionDef) and not n.name.startswith("_")}
        assert found == stated, name
        assert ast.get_docstring(node), name


def test_the_example_draws_fig_8(tmp_path, monkeypatch):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    example = ROOT / "examples" / "python" / "fig8.py"
    monkeypatch.chdir(tmp_path)
    names = runpy.run_path(str(example))
    assert (tmp_path / "fig8.png").stat().st_size > 10_000
    error = names["run"].summary["estimators"]["paper-wheels"]["normal_force"]["nrmse"]
    assert 0.05 < error < 0.12  # the paper's estimator of Fig. 8 on this course: 7.6 %
    json.dumps(names["run"].summary)


def _stamped(run):
    """The time of a run as stamps, of every library and kind: a name, and the readings with it."""
    import datetime

    pandas, polars, arrow = (pytest.importorskip(name) for name in ("pandas", "polars", "pyarrow"))
    table = arrow.table(run.sensors)
    frame = table.to_pandas()
    since = pandas.to_timedelta(frame["time"], unit="s").dt.round("us")
    utc = pandas.to_datetime("2024-05-01T10:00:00") + since
    zoned = utc.dt.tz_localize("UTC").dt.tz_convert("Europe/Berlin")
    arrays = {name: run.sensors[name] for name in run.sensors}
    for name, time in (
        ("pandas", utc),
        ("pandas with a zone", zoned),
        ("pandas, us", utc.astype("datetime64[us]")),
        ("pandas, time since", since),
        ("pandas, Arrow", zoned.astype(pandas.ArrowDtype(arrow.timestamp("us", "Europe/Berlin")))),
        ("pandas, objects", pandas.Series(list(zoned.dt.to_pydatetime()), dtype=object)),
    ):
        stamped = frame.assign(time=time)
        yield name, stamped
        if name != "pandas, objects":
            yield f"polars of {name}", polars.from_pandas(stamped)
            yield f"arrow of {name}", arrow.Table.from_pandas(stamped)
    stamps = utc.to_numpy()
    yield "numpy", arrays | {"time": stamps}
    yield "numpy, us", arrays | {"time": stamps.astype("datetime64[us]")}
    yield "lists of datetime", arrays | {"time": list(zoned.dt.to_pydatetime())}
    naive = [t.replace(tzinfo=None) for t in utc.dt.tz_localize("UTC").dt.to_pydatetime()]
    yield "lists of datetime without a zone", arrays | {"time": naive}
    assert isinstance(naive[0], datetime.datetime)


def test_time_stamps_are_times(scene, run):
    """Equivalence: stamps of every library and unit give the estimates of the seconds since the first, to the bit."""
    arrays = {name: run.sensors[name] for name in run.sensors}
    # The stamps have whole microseconds.
    seconds = np.round(arrays["time"] * 1e6) * 1e3 / 1e9
    expected = scene.estimator("kalman-no-angles").estimate(arrays | {"time": seconds})
    found = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for name, readings in _stamped(run):
            table = scene.estimator("kalman-no-angles").estimate(readings)
            for column in ("time", "wheel1_normal_force", "wheel2_traction", "wheel3_normal_force_sigma"):
                assert np.array_equal(table[column], expected[column], equal_nan=True), (name, column)
            found += 1
    assert found > 12


def test_what_is_no_number_is_refused(scene, run):
    arrays = {name: run.sensors[name] for name in run.sensors}
    estimator = scene.estimator("kalman-no-angles")
    rows = len(arrays["time"])
    stamps = np.datetime64("2024-05-01", "ns") + np.arange(rows)
    for column, values, error, match in (
        ("link1_rate", stamps, TypeError, "holds time stamps, allowed: numbers"),
        ("wheel1_angle", np.zeros(rows, bool), TypeError, "holds truth values"),
        ("wheel1_angle", np.zeros(rows, complex), TypeError, "holds complex numbers"),
        ("time", np.full(rows, "2024-05-01"), TypeError, "holds text"),
        ("time", np.full(rows, "2024-05-01", dtype=object), TypeError, 'column "time": .*could not convert'),
        ("time", np.full(rows, np.datetime64("NaT", "ns")), ValueError, "no time in row 0"),
        ("time", np.arange(rows) * 1_000_000, ValueError, "a row every 1.000e6 s, .*; as ns it is 1000.0 Hz"),
        (
            "time",
            np.arange(rows) * 1e-9,
            ValueError,
            "a row every 1.000e-9 s, .*, allowed: numbers in s, or time stamps",
        ),
        ("wheel1_angle", None, ValueError, 'column "wheel1_angle", of type NoneType, has 0 axes, allowed: 1'),
    ):
        with pytest.raises(error, match=match):
            estimator.estimate(arrays | {column: values})
    with pytest.raises(TypeError, match="found a time stamp"):
        estimator.update(stamps[0], [0] * 3, [0] * 3, [0, 0], [0, 0])
    with pytest.raises(ValueError, match="time: found 1.7e18, allowed: a number of s, at most 1e10"):
        estimator.update(1_700_000_000_000_000_000, [0] * 3, [0] * 3, [0, 0], [0, 0])
    for other in (None, [1, 2], "abc", np.zeros((3, 3)), np.rec.fromarrays(list(arrays.values()), names=list(arrays))):
        found = type(other).__name__
        with pytest.raises(TypeError, match=f"readings: found {found}, allowed: a dictionary of arrays, or a table of"):
            estimator.estimate(other)
    with pytest.raises(robhaz.EstimateError, match=f"no row has an estimate; row {rows - 1}: no frame so far has"):
        estimator.estimate(arrays | {"link1_rate": np.full(rows, np.nan)})
    # A column of another name does not count, whatever name and content it has.
    assert len(scene.estimator("kalman-no-angles").estimate(arrays | {3: None, "foo": "bar"})) == rows


def test_columns_of_arrow_are_checked(scene, run):
    """Units in the metadata, as the command does. Decimals are numbers."""
    arrow = pytest.importorskip("pyarrow")
    estimator, table = scene.estimator("kalman-no-angles"), arrow.table(run.sensors)
    place = table.column_names.index("link1_inclination")

    def with_column(values, key, unit):
        return table.set_column(place, arrow.field("link1_inclination", values.type, metadata={key: unit}), values)

    inclination = table["link1_inclination"]
    for key in ("unit", "units"):
        with pytest.raises(ValueError, match='column "link1_inclination" has the unit deg, allowed: rad'):
            estimator.estimate(with_column(inclination, key, "deg"))
    assert len(estimator.estimate(with_column(inclination, "unit", "radians"))) == table.num_rows
    decimals = arrow.array([0] * table.num_rows).cast(arrow.decimal128(21, 2))
    assert len(estimator.estimate(with_column(decimals, "unit", "rad"))) == table.num_rows
