"""The script draws what the dataset of a real study holds, and the commands of the documents draw.

    pip install pytest pandas pyarrow "matplotlib>=3.10"
    ROBHAZ=target/release/robhaz pytest examples/python/test_plot_study.py
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

sys.path.insert(0, str(Path(__file__).parent))
import plot_study

ROOT = Path(__file__).resolve().parents[2]
ROBHAZ = shutil.which(os.environ.get("ROBHAZ", "robhaz"))
SCENE = """
engine.kind = "direct"
sensors.grade = "typical"
estimator = [{ name = "paper-body" }, { name = "kalman" }]
[terrain]
kind = "flat"
[record]
duration = 1
compare_from = 0.5
"""
LISTED = """
scene = "scene.toml"
[[axis]]
keys = ["drive.speed", "drive.kp"]
values = [[0.1, 2], [0.2, 3], [0.3, 5]]
[[axis]]
key = "terrain.kind"
values = ["flat", "cosbump"]
[[axis]]
key = "seed"
count = 3
"""
# With its centre of mass far ahead the robot cannot stand.
DRAWN = """
scene = "scene.toml"
[draw]
count = 40
[[axis]]
key = "drive.kp"
log_uniform = [1, 20]
[[axis]]
key = "robot.geometry.body_cg.0"
uniform = [-0.1, 1.0]
"""


@pytest.fixture(scope="module")
def studies(tmp_path_factory):
    """The folder of two finished studies: of listed values and of drawn ones, of which some fail."""
    folder = tmp_path_factory.mktemp("studies")
    (folder / "scene.toml").write_text(SCENE)
    for name, study in (("listed", LISTED), ("drawn", DRAWN)):
        (folder / f"{name}.toml").write_text(study)
        command = [ROBHAZ, "study", folder / f"{name}.toml", "--out", folder / name, "--quiet"]
        subprocess.run(command, check=True)
    return folder


def draw(study, *options, suffix="svg"):
    return plot_study.main([str(study), *options, "--out", str(study / f"figure.{suffix}")])


def dataset(study):
    return pd.read_parquet(study / "study.parquet")


def caption(figure):
    return " ".join(figure.get_supxlabel().split())


def test_bands_have_the_quantiles_of_the_runs(studies):
    """Each point of a line is the median of the six runs at a speed; the bands have the four other quantiles."""
    figure = draw(studies / "listed")
    (axis,) = figure.axes
    scores = dataset(studies / "listed").groupby(["estimator", "drive.speed"]).nrmse
    assert [line.get_label() for line in axis.lines] == ["paper-body", "kalman"]
    bands = iter(axis.collections)
    for line in axis.lines:
        speeds, medians = line.get_data()
        expected = scores.median()[line.get_label()]
        np.testing.assert_array_equal(speeds, [0.1, 0.2, 0.3])
        np.testing.assert_allclose(medians, expected)
        for low, high in ((0.05, 0.95), (0.25, 0.75)):
            corners = next(bands).get_paths()[0].vertices[:, 1]
            found = scores.quantile([low, high])[line.get_label()]
            assert set(np.round(corners, 12)) == set(np.round(found, 12))
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("drive.speed (m/s)", "nrmse (% of the mean N)")
    assert "5 to 95 % of 6 runs of each drive.speed" in caption(figure)
    assert "18 runs, seed 0 to 2; none failed" in caption(figure)


def test_the_lowest_chart_of_each_column_has_numbers():
    _, axes = plot_study.sheet(5, 2, 2, sharex=True, sharey=True)
    shown = [axis.xaxis.get_tick_params()["labelbottom"] for axis in axes]
    assert shown == [False, False, False, True, True]


def test_drawn_values_are_in_groups_and_failures_are_counted(studies):
    """Each run is in one group; the axis of a logarithm that was drawn is logarithmic."""
    runs = dataset(studies / "drawn")
    failed, complete = runs.error.notna().sum(), runs[runs.estimator == "kalman"].nrmse.count()
    assert failed > 0 and complete >= 20
    figure = draw(studies / "drawn", "--estimator", "kalman")
    (axis,) = figure.axes
    assert len(axis.lines[0].get_xdata()) == complete // 10 and axis.get_xscale() == "log"
    assert f"40 runs, one seed; {failed} of them failed and are not drawn" in caption(figure)
    assert "runs of each group of neighbouring drive.kp" in caption(figure)
    # Every run is in a cell of the map, and the map has a median wherever a run is.
    map_ = draw(studies / "drawn", "--kind", "heat", "--estimator", "kalman").axes[0].collections[0].get_array()
    assert map_.shape == (3, 3) and 0 < map_.count() <= complete


def test_a_map_has_the_medians(studies):
    """A map for each estimator over speed and ground, from the same scale of colours. Linked keys count once."""
    figure = draw(studies / "listed", "--kind", "heat")
    medians = dataset(studies / "listed").groupby(["estimator", "terrain.kind", "drive.speed"]).nrmse.median()
    meshes = {axis.get_title("left"): axis.collections[0] for axis in figure.axes[:2]}
    for axis in figure.axes[:2]:
        assert (axis.get_xlabel(), axis.get_ylabel()) == ("drive.speed", "terrain.kind")
        assert [label.get_text() for label in axis.get_xticklabels()] == ["0.1", "0.2", "0.3"]
        assert [label.get_text() for label in axis.get_yticklabels()] == ["flat", "cosbump"]
    for estimator, mesh in meshes.items():
        expected = medians[estimator].unstack().loc[["flat", "cosbump"]]
        np.testing.assert_allclose(mesh.get_array(), expected)
    assert {mesh.norm.vmin for mesh in meshes.values()} == {medians.min()}
    assert "no run, 0 of 12 cells" in caption(figure)


def test_a_ladder_has_boxes_and_points(studies):
    """Estimators from the top down, each with its median over all runs and at each speed; then grounds."""
    runs = dataset(studies / "listed")
    figure = draw(studies / "listed", "--kind", "ladder")
    (axis,) = figure.axes
    for place, name in enumerate(["paper-body", "kalman"]):
        scores = runs[runs.estimator == name].nrmse
        assert axis.get_yticklabels()[place].get_text() == f"{name}  {100 * scores.median():.3g} %"
    medians = runs.groupby(["estimator", "drive.speed"]).nrmse.median()
    points = axis.lines[-1].get_xdata()
    np.testing.assert_allclose(points, [*medians["paper-body"], *medians["kalman"]])
    grounds = draw(studies / "listed", "--kind", "ladder", "--x2", "terrain.kind")
    assert [axis.get_title("left") for axis in grounds.axes] == ["paper-body", "kalman"]
    median = runs[(runs.estimator == "kalman") & (runs["terrain.kind"] == "cosbump")].nrmse.median()
    assert grounds.axes[1].get_yticklabels()[1].get_text() == f"cosbump  {100 * median:.3g} %"
    # Bands over words are the same figure.
    same = draw(studies / "listed", "--x", "terrain.kind")
    assert [axis.get_title("left") for axis in same.axes] == ["paper-body", "kalman"]


def test_calibration_has_each_stated_deviation(studies):
    """A point for each run of an estimator that states a standard deviation; the other one is named."""
    figure = draw(studies / "listed", "--kind", "calibration")
    runs = dataset(studies / "listed")
    best = runs[runs.estimator == "kalman"]
    (points,) = figure.axes[0].collections
    np.testing.assert_allclose(points.get_offsets(), best[["stated", "nrmse"]])
    assert "state no standard deviation: paper-body." in caption(figure)
    with pytest.raises(SystemExit):
        draw(studies / "listed", "--kind", "calibration", "--estimator", "paper-body")


def test_a_histogram_counts_all_runs(studies):
    """Conservation: the bars of each estimator have as many runs as the dataset."""
    figure = draw(studies / "listed", "--kind", "histogram", "--y", "rmse")
    assert len(figure.axes) == 2 and figure.axes[1].get_xlabel() == "rmse (N)"
    for axis in figure.axes:
        assert sum(bar.get_height() for bar in axis.patches) == 18


def test_files_are_whole_and_equal(studies):
    """The ending chooses the format; the same dataset gives the same bytes, with its text as text."""
    files = {suffix: studies / "listed" / f"figure.{suffix}" for suffix in ("svg", "png", "pdf")}
    for suffix, start in (("svg", b"<?xml"), ("png", b"\x89PNG"), ("pdf", b"%PDF-")):
        draw(studies / "listed", suffix=suffix)
        first = files[suffix].read_bytes()
        draw(studies / "listed", suffix=suffix)
        assert first.startswith(start) and files[suffix].read_bytes() == first
    assert "RMS error of N over wheels and samples" in files["svg"].read_text()
    plot_study.main([str(studies / "listed")])
    assert (studies / "listed" / "bands.svg").is_file()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--x", "speed"], "no column speed; nearest: drive.speed"),
        (["--y", "nrms"], "no column nrms; nearest: nrmse"),
        (["--y", "terrain.kind"], "the column terrain.kind holds words; a score needs numbers"),
        (["--estimator", "kalmn"], "no estimator kalmn; nearest: kalman"),
        (["--estimator", "xyz"], "no estimator xyz; allowed: paper-body, kalman"),
        (["--x", "duration"], "duration is 1.0 in all rows; these keys vary: drive.speed, terrain.kind, seed"),
        (["--x", "seed", "--scale-x", "log"], "seed has the value 0; a logarithmic axis needs values above zero"),
        (["--y", "friction_test_mu_max"], "no row has a value of friction_test_mu_max; 0 runs failed"),
        (["--out", "figure.jpg"], "found figure.jpg; allowed: a name that ends in .svg, .pdf, .png"),
        (["--out", "nowhere/figure.svg"], "nowhere/figure.svg"),
    ],
)
def test_mistakes_name_what_is_allowed(studies, capsys, options, message):
    with pytest.raises(SystemExit) as stopped:
        plot_study.main([str(studies / "listed"), *options])
    assert stopped.value.code == 1
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1


def test_what_is_no_dataset_is_refused(studies, tmp_path, capsys):
    """A folder without one, a stopped study, a text, a Parquet file of something else, a study without scores."""
    text, other = tmp_path / "text.parquet", tmp_path / "other.parquet"
    text.write_text("time,force\n")
    pd.DataFrame({"time": [0.0]}).to_parquet(other)
    cases = [(tmp_path, "there is no"), (text, "not the dataset of a study"), (other, "robhaz.study")]
    stopped = tmp_path / "stopped"
    stopped.mkdir()
    (stopped / "runs.jsonl").touch()
    # The failed runs of a study alone.
    parquet = pq.ParquetFile(studies / "drawn" / "study.parquet")
    notes = {key: value for key, value in parquet.metadata.metadata.items() if key != b"ARROW:schema"}
    table = parquet.read()
    failed = table.filter(table["error"].is_valid()).replace_schema_metadata(notes)
    pq.write_table(failed, tmp_path / "failed.parquet")
    cases.append((stopped, "not complete, robhaz study continues it"))
    cases.append((tmp_path / "failed.parquet", "runs failed, such as: robot.geometry.body_cg: the linkage folds"))
    for path, message in cases:
        with pytest.raises(SystemExit):
            plot_study.main([str(path)])
        assert message in capsys.readouterr().err


def shortened(study):
    """A shipped study with one seed, 30 draws, and runs of 2.1 s: errors count from 2 s on."""
    study = re.sub(r"^count = 2450", "count = 30", study, flags=re.MULTILINE)
    study = re.sub(r'(key = "seed"\ncount =) \d+', r"\1 1", study)
    study = re.sub(r"^(  \[[^\]]*), [\d.]+\]", r"\1, 2.1]", study, flags=re.MULTILINE)
    if '"record.duration"]' in study:  # varied by an axis
        return study
    return study.replace("set = [", 'set = [\n  "record.duration=2.1",').replace('  "record.duration=8",\n', "")


def test_the_documents_commands_draw(tmp_path, monkeypatch):
    """Every command of docs/ that draws a study runs on that study, shortened."""
    pages = [page.read_text() for page in sorted((ROOT / "docs").glob("*.md"))]
    commands = re.findall(r"^python examples/python/plot_study.py (.*)$", "\n".join(pages), flags=re.MULTILINE)
    assert len(commands) >= 5
    (tmp_path / "studies").mkdir()
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    monkeypatch.chdir(tmp_path)
    for command in commands:
        folder, *options = shlex.split(command)
        study = Path("studies", Path(folder).name).with_suffix(".toml")
        if not study.exists():
            study.write_text(shortened((ROOT / study).read_text()))
            subprocess.run([ROBHAZ, "study", study, "--out", folder, "--quiet"], check=True)
        assert plot_study.main([folder, *options]).axes, command
