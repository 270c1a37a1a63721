//! Exceptions, with the texts of the command.

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use robhaz_estimator::EstimateError as NoEstimate;
use robhaz_run::in_one_line;
use robhaz_scene::{LogChoice, LogSides};
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

/// What became of the rows of a table: one whose time does not increase is an error, one without an estimate is empty.
#[derive(Default)]
pub struct Outcome {
    some: bool,
    last: Option<(usize, NoEstimate)>,
}

impl Outcome {
    /// Counts a row.
    pub fn take<T>(&mut self, row: usize, found: &Result<T, NoEstimate>) -> PyResult<()> {
        match found {
            Err(error @ NoEstimate::Time { .. }) => {
                return Err(of_frame(format!("row {row}: {error}")));
            }
            Err(error) => self.last = Some((row, *error)),
            Ok(_) => self.some = true,
        }
        Ok(())
    }

    /// Refuses a table of which all rows are empty.
    pub fn end(self) -> PyResult<()> {
        match self.last.filter(|_| !self.some) {
            Some((row, error)) => Err(of_frame(format!(
                "no row has an estimate; row {row}: {error}"
            ))),
            None => Ok(()),
        }
    }
}

/// Refuses a description that states that its readings are of something else than an estimator takes.
pub fn check_sides(choice: &LogChoice, both: bool) -> PyResult<()> {
    if !choice.states("sides") || both == (choice.sides == LogSides::Both) {
        return Ok(());
    }
    let allowed = match both {
        true => "\"both\" for WholeEstimator; Estimator is of one side",
        false => "\"one of two\", \"plane\" for Estimator; WholeEstimator is of both sides",
    };
    let (at, found) = (&choice.sides_at.0, choice.sides.name());
    Err(SceneError::new_err(format!(
        "{at}: sides: found {found:?}, allowed: {allowed}"
    )))
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
