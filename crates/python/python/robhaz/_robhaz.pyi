"""The compiled part of `robhaz`. Wheels are ordered front, middle, rear; x points forward, y up; angles turn
counter-clockwise, so that nose up is positive. SI units."""

from collections.abc import Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, Protocol, TypeAlias, final

import numpy as np
import numpy.typing as npt

__version__: str

_Path: TypeAlias = str | PathLike[str]
_Three: TypeAlias = tuple[float, float, float]
_Six: TypeAlias = tuple[float, float, float, float, float, float]
_Reading: TypeAlias = float | None
_Array: TypeAlias = npt.NDArray[np.floating[Any]]
_Readings: TypeAlias = Sequence[_Reading] | _Array
_Angles: TypeAlias = Literal["given", "none"]
_Overrides: TypeAlias = Mapping[str, Any] | Sequence[str]

class _Columns(Protocol):
    """A dictionary of arrays, or a table of robhaz, pandas, polars or pyarrow. The column `time` has numbers in s, or time
    stamps of any of these libraries: of stamps, times are those since the first row. Rows come at 2 Hz to 100 kHz, else
    the time has another unit. A unit in the metadata of an Arrow field must be that of the reading."""

    def __getitem__(self, name: str, /) -> Any: ...

class SceneError(ValueError):
    """Problems of a scene, of a description of sensors or of a robot file, a line each: file, line, key, what was
    found and what is allowed."""

class RunError(RuntimeError):
    """A run or a study that cannot start or has stopped, with its causes."""

class EstimateError(ValueError):
    """There is no estimate for a frame: a reading that was never there, a time that does not increase, a linkage that
    cannot close."""

@final
class Scene:
    """Everything that a run depends on: robot, ground, contact, drive, sensors, estimators, engine, records.

    docs/scenes.md lists the keys, with their units and limits.
    """

    def __init__(self, overrides: _Overrides | None = None, *, text: str = "", base_dir: _Path = ".") -> None:
        """The scene of a text in TOML; without one the main scene, `scenes/smooth.toml`.

        `overrides`: a dictionary of keys and values, `{"drive.speed": 0.3, "sensors.grade": "typical"}`, or a list of
        texts `key=value` as of `--set`. A value that is a text is read as `--set` reads it: `"30 cm/s"`. Paths in the
        text are relative to `base_dir`.

        Raises `SceneError` with all problems.
        """

    @staticmethod
    def load(path: _Path, overrides: _Overrides | None = None) -> Scene:
        """The scene of a file, with overrides. Raises `SceneError` with all problems."""

    @property
    def name(self) -> str:
        """Name of the scene."""

    @property
    def seed(self) -> int:
        """Seed of everything random."""

    @property
    def estimators(self) -> list[str]:
        """Labels of the estimators, in the order of the scene."""

    @property
    def warnings(self) -> list[str]:
        """What may not be as wanted, a sentence each. `run` and `study` raise them as Python warnings."""

    def to_toml(self) -> str:
        """The resolved scene: every key with its value, as `scene.toml` in the folder of a run."""

    def run(self) -> Run:
        """Runs the scene to its end and keeps all results in memory: 8 bytes a value, about 3.5 kB a record
        with the five default estimators.

        Other Python threads go on meanwhile; Ctrl-C stops it. Raises `RunError`.
        """

    def estimator(self, name: str = "kalman", *, contact_angles: _Angles | None = None) -> Estimator:
        """An estimator of the scene or a preset, with the nominal robot and the noise budget of the scene."""

@final
class Run:
    """A run and its results. `print(run)` shows the errors of each estimator."""

    @property
    def name(self) -> str:
        """Name of the scene."""

    @property
    def tables(self) -> dict[str, Table]:
        """All tables by the names that their files have in the folder of a run: `truth`, `sensors`, `estimate-NAME`,
        `terrain`, `ground-NAME`."""

    @property
    def truth(self) -> Table:
        """Motion and forces of the simulation, a row a record."""

    @property
    def sensors(self) -> Table:
        """The readings, a row a record; NaN where one is lost."""

    @property
    def estimates(self) -> dict[str, Table]:
        """Estimated forces with standard deviations, by the estimator's label, a row a record."""

    @property
    def terrain(self) -> Table:
        """The ground: x, height, slope, curvature."""

    @property
    def ground(self) -> dict[str, Table]:
        """The ground that each estimator found, by its label; without those that find none."""

    @property
    def summary(self) -> dict[str, Any]:
        """Errors of each estimator and what was run: the content of `summary.json`."""

@final
class Table:
    """Columns of equal length, with units. Any library that takes Arrow takes a table: `pyarrow.table(table)`,
    `polars.DataFrame(table)`, `pyarrow.table(table).to_pandas()`. Unit and description are in the metadata of each
    field."""

    @property
    def name(self) -> str:
        """Name of the table, such as `truth`."""

    @property
    def columns(self) -> list[str]:
        """Names of the columns, in order; `keys()` is the same."""

    @property
    def units(self) -> dict[str, str]:
        """Unit of each column: SI, `1` for a number without."""

    @property
    def descriptions(self) -> dict[str, str]:
        """Content of each column, in a few words."""

    def keys(self) -> list[str]: ...
    def __len__(self) -> int:
        """Number of rows."""

    def __contains__(self, column: str) -> bool: ...
    def __iter__(self) -> Iterator[str]: ...
    def __getitem__(self, column: str) -> npt.NDArray[np.float64] | npt.NDArray[np.uint32]:
        """A copy of a column, shape (rows,): NaN where it is empty; uint32 where it counts."""

    def __arrow_c_schema__(self) -> object: ...
    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object: ...

@final
class Estimator:
    """Wheel forces from readings, one frame at a time or a whole table. It remembers the frames that it has seen."""

    def __init__(
        self,
        name: str = "kalman",
        *,
        robot: _Path | None = None,
        sensors: _Path | None = None,
        contact_angles: _Angles | None = None,
    ) -> None:
        """As `robhaz estimate --estimator NAME --robot ROBOT.toml --sensors SENSORS.toml --contact-angles ...`.

        `name`: a preset (`paper-body`, `paper-wheels`, `true-mass`, `kalman`) or an estimator that `sensors` lists.
        `sensors` states the noise budget, the damping and whether the readings are of one side of two, the default, or of
        a robot in the plane (`sides`, docs/logs.md; of both sides there is `WholeEstimator`); its columns have no effect here: leave `[reading]`, `missing` and `[[channel]]` out. Without
        `robot` it is robot A. A robot whose errors neither file states (`body_cg`, `link_masses`, `load_covariance`) counts
        as people build them: masses to 3 %, centres of mass to 5 mm, pins to 1 mm; a warning says so. With `contact_angles="none"` the estimator finds the contact angles itself.

        Raises `SceneError` for a file, `ValueError` for an argument.
        """

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def needs_contact_angles(self) -> bool:
        """Whether every frame must have the contact angles."""

    def update(
        self,
        time: float,
        wheel_angle: _Readings,
        motor_torque: _Readings,
        inclination: _Readings,
        rate: _Readings,
        contact_angle: _Readings | None = None,
        rate_error: Sequence[float] | _Array | None = None,
    ) -> Estimate:
        """The estimate of the next frame.

        `time`: s, increasing, at most 1e10. `wheel_angle`: 3, rad, turn of each wheel relative to its link, forward positive.
        `motor_torque`: 3, N m at the wheel after the gear, forward positive. `inclination`, `rate`: 2, links 1 and 2,
        rad and rad/s, nose up positive. `contact_angle`: 3, rad. `rate_error`: 2, rad/s, what rates that follow from
        the angle of a joint err by beyond a gyroscope's noise. `None` or NaN is a missing reading: the last one is held.

        Raises `EstimateError`; the next frame may have an estimate again. Where the time jumps back by more than 0.5 s, the
        filters start anew.
        """

    def estimate(self, readings: _Columns) -> Table:
        """The estimates of all rows of a table of readings: the table `estimate-NAME` of a run.

        `readings`: arrays of shape (rows,) by the names of the table `sensors`: `time`, `wheel1_angle`,
        `wheel1_motor_torque`, `wheel1_contact_angle` (rad; not needed if `needs_contact_angles` is false), the same
        for wheels 2 and 3, `link1_inclination`, `link1_rate`, the same for link 2. NaN is a missing reading. A row
        without an estimate is empty. Other Python threads go on meanwhile.

        Raises `EstimateError` with the row where the time does not increase, and if no row has an estimate; `KeyError` for a
        missing column, `TypeError` or `ValueError` for one that cannot be taken. Where the time jumps back by more than
        0.5 s, the filters start anew.
        """

@final
class Estimate:
    """Wheel forces of one frame."""

    @property
    def time(self) -> float:
        """Time of the readings, s."""

    @property
    def normal_force(self) -> _Three:
        """Normal force N of each wheel, N."""

    @property
    def traction(self) -> _Three:
        """Traction T of each wheel, N, driving forward positive."""

    @property
    def normal_force_sigma(self) -> _Three | None:
        """Standard deviations of N, N. `None` from the paper's filters, which state none."""

    @property
    def traction_sigma(self) -> _Three | None:
        """Standard deviations of T, N. `None` as above."""

    @property
    def covariance(self) -> list[list[float]] | None:
        """Covariance of (T1, N1, T2, N2, T3, N3), 6 x 6, N^2. `None` as above."""

    @property
    def contact_angle(self) -> _Three:
        """Contact angle of each wheel, rad."""

    @property
    def contact_angle_sigma(self) -> _Three | None:
        """Standard deviations of the contact angles, rad. `None` as above."""

    @property
    def body_pitch(self) -> float:
        """Pitch of the body from the nominal pose, rad."""

    @property
    def link_angle(self) -> _Three:
        """Angles of links 1 to 3 from the nominal pose, rad."""

    @property
    def flags(self) -> list[str]:
        """Warnings, such as `wheel 1 unloaded`."""

    @property
    def weight(self) -> str | None:
        """Whether the torques confirm the described weight: `confirmed`, `unconfirmed` or `contradicts`. The stated
        deviations hold if they do. `None` from the paper's filters, and for one side of two."""

@final
class WholeEstimator:
    """Forces of the six wheels of a rover with both sides (docs/whole-rover.md), one frame at a time or a whole table. It
    remembers the frames that it has seen. Wheels are left 1 to 3, then right 1 to 3."""

    def __init__(self, robot: _Path, *, sensors: _Path | None = None) -> None:
        """`robot`: a robot file with `[robot.across]`. `sensors`: noise budget and damping, as of `Estimator`; inclination
        and rate of the budget are those of the body's sensor, `pin_noise` and `pin_bias` those of every joint.

        Raises `SceneError` for a file, `ValueError` for a robot of one side. Warns as `Estimator`.
        """

    def update(
        self,
        time: float,
        wheel_angle: _Readings,
        motor_torque: _Readings,
        pins: _Readings,
        coupling: _Reading,
        inclination: _Reading,
        roll: _Reading,
        rates: _Readings,
        steering: _Readings | None = None,
    ) -> WholeEstimate:
        """The estimate of the next frame.

        `time`: s, increasing, at most 1e10. `wheel_angle`: 6, rad, turn of each wheel relative to its link, forward positive.
        `motor_torque`: 6, N m at the wheel after the gear, forward positive. `pins`: 2, rad, left and right bogie against
        its link, nose up. `coupling`: rad, left rocker against the body, nose up, or the rear bogie's roll against the
        body, left side up. `inclination`, `roll`: rad, of the body, nose up and left side up: `atan2(f_x, hypot(f_y, f_z))`
        and `atan2(f_y, f_z)` of an accelerometer at rest. `rates`: 3, rad/s: roll, pitch (nose up), yaw (to the left).
        `steering`: 6, rad, to the left. `None` or NaN is a missing reading: the last one is held.

        Raises `EstimateError`; the next frame may have an estimate again. Where the time jumps back by more than 0.5 s, the
        filters start anew.
        """

    def estimate(self, readings: _Columns) -> Table:
        """The estimates of all rows of a table of readings, with the columns of the table `estimate-kalman` of a log of both
        sides, of each wheel (`left_wheel1_normal_force`, ..., `left_wheel1_slip`) and of the rover (`tip_margin`, ...).

        `readings`: arrays of shape (rows,), named `time`; `left_wheel1_angle`, `left_wheel1_motor_torque`, where it steers
        `left_wheel1_steering`, to `right_wheel3_...`; `left_pin_angle`, `right_pin_angle`; `differential_angle` or
        `rear_bogie_angle`, as the robot has; `body_inclination`, `body_roll`, `body_roll_rate`, `body_rate`, `body_yaw_rate`. NaN is a
        missing reading. A row without an estimate is empty. Other Python threads go on meanwhile.

        Raises `EstimateError` with the row where the time does not increase, and if no row has an estimate; `KeyError` for a
        missing column, `TypeError` or `ValueError` for one that cannot be taken. Where the time jumps back by more than
        0.5 s, the filters start anew.
        """

@final
class WholeEstimate:
    """Wheel forces of both sides at one frame. Wheels are left 1 to 3, then right 1 to 3."""

    @property
    def time(self) -> float:
        """Time of the readings, s."""

    @property
    def normal_force(self) -> _Six:
        """Normal force N of each wheel, in its plane, N."""

    @property
    def normal_force_sigma(self) -> _Six:
        """Standard deviations of N along the ground's normal, which may be inclined across a wheel, N."""

    @property
    def in_plane_normal_force_sigma(self) -> _Six:
        """Standard deviations of N in the wheel's plane, as a force sensor above it reads, N."""

    @property
    def covariance(self) -> list[list[float]]:
        """Covariance of the six N along the ground's normals, 6 x 6, N^2."""

    @property
    def traction(self) -> _Six:
        """Traction T of each wheel, N, driving forward positive."""

    @property
    def traction_sigma(self) -> _Six:
        """Standard deviations of T, N."""

    @property
    def needed_friction(self) -> list[float | None]:
        """Friction that each wheel needs: hypot(T, A)/N with its mean axial force A. `None` without load."""

    @property
    def inclination(self) -> float:
        """Inclination of the body, rad, nose up."""

    @property
    def roll(self) -> float:
        """Roll of the body, rad, left side up."""

    @property
    def lateral_force(self) -> float:
        """The force of the ground on all wheels across the body, N, to the left."""

    @property
    def axial_share(self) -> float:
        """Mean axial force of a wheel over its normal force."""

    @property
    def tip_margin(self) -> float:
        """Load off the tip line over that on level ground: at 0 the rover tips over."""

    @property
    def tip_line(self) -> str:
        """The line with the least margin: `left`, `right`, `front`, `rear`."""

    @property
    def dragged(self) -> bool:
        """Whether wheels are dragged across, as in a skid turn: what is stated is large then."""

    @property
    def misfit(self) -> float:
        """Misfit of the nine rows: chi-square with three degrees of freedom if all that is stated holds."""

    @property
    def flags(self) -> list[str]:
        """Warnings of both sides, such as `wheel 1 unloaded`."""

@final
class Study:
    """The result of a study. `print(study)` shows the table of `robhaz study`."""

    def as_dict(self) -> dict[str, Any]:
        """The report in `robhaz study --json`. Errors of N and standard deviations are fractions of the mean true
        N."""

def study(scene: Scene, seeds: int = 10, *, ladder: bool = False) -> Study:
    """Errors of a scene's estimators and consistency of their covariance, over `seeds` seeds from the scene's on.

    The scene is simulated once and observed with each seed, on all processors. `ladder` studies the ablation ladder
    instead of the scene's estimators. Other Python threads go on meanwhile; Ctrl-C acts at the end. Raises `RunError`,
    `ValueError`.
    """
