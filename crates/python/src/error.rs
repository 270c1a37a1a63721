//! Exceptions, with the texts of the command.

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use robhaz_run::in_one_line;
use std::error::Error;
use std::ffi::CString;
use std::fmt::Display;

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

/// The exception of an argument.
pub fn invalid(error: impl Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// The exception of a frame without an estimate.
pub fn of_frame(error: impl Display) -> PyErr {
    EstimateError::new_err(error.to_string())
}

/// A warning for the user.
pub fn warn(py: Python<'_>, text: String) -> PyResult<()> {
    let text = CString::new(text)?;
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 1)
}

/// The exception of a run or study, `title` first.
pub fn of_run(title: &str, error: &dyn Error) -> PyErr {
    RunError::new_err(format!("{title}: {}", in_one_line(error)))
}
