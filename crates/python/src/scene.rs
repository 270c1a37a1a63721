//! Scenes, with overrides.

use crate::error::{invalid, of_run, of_scene, warn};
use crate::estimator::Estimator;
use crate::run::Run;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyString};
use robhaz_scene::{LogChoice, Scene as Checked};

use std::path::PathBuf;

/// See the stub `_robhaz.pyi`.
#[pyclass(frozen, module = "robhaz")]
pub struct Scene {
    /// The scene with every key checked.
    pub checked: Checked,
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (overrides=None, *, text="", base_dir=PathBuf::from(".")))]
    fn new(overrides: Option<Bound<'_, PyAny>>, text: &str, base_dir: PathBuf) -> PyResult<Self> {
        let overrides = texts(overrides)?;
        let checked = Checked::parse(text, "scene", &base_dir, &overrides).map_err(of_scene)?;
        Ok(Self { checked })
    }

    #[staticmethod]
    #[pyo3(signature = (path, overrides=None))]
    fn load(path: PathBuf, overrides: Option<Bound<'_, PyAny>>) -> PyResult<Self> {
        let checked = Checked::load(&path, &texts(overrides)?).map_err(of_scene)?;
        Ok(Self { checked })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.checked.name
    }

    #[getter]
    fn seed(&self) -> u64 {
        self.checked.seed
    }

    #[getter]
    fn estimators(&self) -> Vec<&str> {
        let estimators = self.checked.estimators.iter();
        estimators.map(|e| e.name.as_str()).collect()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.checked.warnings()
    }

    fn to_toml(&self) -> String {
        let version = env!("CARGO_PKG_VERSION");
        let library = self.checked.engine.kind.library();
        self.checked
            .to_toml(&format!("robhaz {version}, {library}"))
    }

    fn run(&self, py: Python<'_>) -> PyResult<Run> {
        self.warn(py)?;
        Run::of(py, &self.checked)
    }

    #[pyo3(signature = (name="kalman", *, contact_angles=None))]
    fn estimator(&self, name: &str, contact_angles: Option<&str>) -> PyResult<Estimator> {
        let choice = LogChoice::of_scene(&self.checked);
        let choice = choice.map_err(|e| of_run("model_error", &e))?;
        Estimator::of(choice, name, contact_angles)
    }

    fn __repr__(&self) -> String {
        format!("<robhaz.Scene {}>", self.checked.name)
    }
}

impl Scene {
    /// Raises the warnings of the scene as Python's.
    pub fn warn(&self, py: Python<'_>) -> PyResult<()> {
        for warning in self.checked.warnings() {
            warn(py, format!("{}: {warning}", self.checked.name))?;
        }
        Ok(())
    }
}

/// Overrides as texts `key=value`: a dictionary of keys and values, or a list of such texts.
fn texts(overrides: Option<Bound<'_, PyAny>>) -> PyResult<Vec<String>> {
    let Some(overrides) = overrides else {
        return Ok(Vec::new());
    };
    let Ok(pairs) = overrides.cast::<PyDict>() else {
        return overrides.extract();
    };
    let text = |(key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let key: String = key.extract()?;
        let plain = value.cast::<PyString>().map(ToString::to_string);
        Ok(format!(
            "{key}={}",
            plain.or_else(|_| toml(&key, &value, 0))?
        ))
    };
    pairs.iter().map(text).collect()
}

/// Most lists and dictionaries within each other in a value, far above what any key takes: each is a call.
const DEEPEST: usize = 16;

/// A value as TOML.
fn toml(key: &str, value: &Bound<'_, PyAny>, depth: usize) -> PyResult<String> {
    if depth > DEEPEST {
        return Err(invalid(format!(
            "{key}: found more than {DEEPEST} lists or dictionaries within each other, allowed: at most {DEEPEST}"
        )));
    }
    let inner = |value: &Bound<'_, PyAny>| toml(key, value, depth + 1);
    if value.cast::<PyBool>().is_ok() {
        return Ok(value.extract::<bool>()?.to_string());
    }
    if value.cast::<PyString>().is_ok() {
        let text: String = value.extract()?;
        // A TOML string takes the escapes of JSON.
        return Ok(serde_json::Value::from(text).to_string());
    }
    if value.cast::<PyInt>().is_ok() {
        return Ok(value.str()?.to_string());
    }
    if value.cast::<PyFloat>().is_ok() {
        return Ok(format!("{:?}", value.extract::<f64>()?));
    }
    // NumPy's numbers are neither, and its arrays are no sequences.
    if let Ok(plain) = value.call_method0("tolist") {
        return inner(&plain);
    }
    if let Ok(table) = value.cast::<PyDict>() {
        let entry = |(k, v): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
            Ok(format!("{} = {}", inner(&k)?, inner(&v)?))
        };
        let entries: PyResult<Vec<_>> = table.iter().map(entry).collect();
        return Ok(format!("{{ {} }}", entries?.join(", ")));
    }
    let Ok(items) = value.try_iter() else {
        let found = value.repr()?;
        return Err(PyTypeError::new_err(format!(
            "{key}: found {found}, allowed: a number, a text, True or False, a list or a dictionary of these"
        )));
    };
    let items: PyResult<Vec<_>> = items.map(|item| inner(&item?)).collect();
    Ok(format!("[{}]", items?.join(", ")))
}
