//! Exceptions, with the texts of the command.

use pyo3::PyErr;
use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use robhaz_run::in_one_line;
use std::error::Error;

create_exception!(
    robhaz,
    SceneError,
    PyValueError,
    "Problems of a scene, of a description of sensors or of a robot file, a line each: file, line, key, what was found and what is allowed."
);
create_exception!(
    robhaz,
    RunError,
    PyRuntimeError,
    "A run or a study that cannot start or has stopped, with its causes."
);
create_exception!(
    robhaz,
    EstimateError,
    PyValueError,
    "There is no estimate for a frame: a reading that was never there, a time that does not increase, a linkage that cannot close."
);

/// The exception of a scene or of a description of sensors.
// An argument of map_err.
pub fn of_scene(error: robhaz_scene::FileError) -> PyErr {
    let lines: Vec<_> = error.problems.iter().map(ToString::to_string).collect();
    SceneError::new_err(lines.join("\n"))
}

/// The exception of a run or study, `title` first.
pub fn of_run(title: &str, error: &dyn Error) -> PyErr {
    RunError::new_err(format!("{title}: {}", in_one_line(error)))
}
