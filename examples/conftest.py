"""What the tests of several examples share."""

import pytest

SCENE = """
[terrain]
kind = "flat"
[record]
duration = 1
compare_from = 0.5
[[estimator]]
name = "kalman"
"""
STUDY = """
scene = "scene.toml"
[[axis]]
key = "drive.kp"
values = [2, 5]
[[axis]]
key = "seed"
count = 30
"""


@pytest.fixture
def study(tmp_path):
    """A study of 60 short runs, in the folder of the test."""
    (tmp_path / "scene.toml").write_text(SCENE)
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    return path
