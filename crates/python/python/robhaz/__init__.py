"""Simulate ROBHAZ-6WHEEL over rough ground and estimate its wheel forces. Everything is in SI units.

    >>> import robhaz
    >>> scene = robhaz.Scene.load("scenes/smooth.toml", {"sensors.grade": "typical"})
    >>> run = scene.run()
    >>> print(run)                                    # the table of `robhaz run`
    >>> run.estimates["kalman"]["wheel1_normal_force"]  # a NumPy array; run.estimates["kalman"].units has its unit

A `Table` goes as it is into `pyarrow.table`, `polars.DataFrame` and other libraries that take Arrow.
"""

from ._robhaz import (
    Estimate,
    EstimateError,
    Estimator,
    Run,
    RunError,
    Scene,
    SceneError,
    Study,
    Table,
    WholeEstimate,
    WholeEstimator,
    __version__,
    study,
)

__all__ = [
    "Estimate",
    "EstimateError",
    "Estimator",
    "Run",
    "RunError",
    "Scene",
    "SceneError",
    "Study",
    "Table",
    "WholeEstimate",
    "WholeEstimator",
    "__version__",
    "study",
]
