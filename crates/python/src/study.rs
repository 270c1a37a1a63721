//! Many seeds of one scene.

use crate::error::of_run;
use crate::scene::Scene;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robhaz_study::{Report, TruthRun, floor, ladder};

/// See the stub `_robhaz.pyi`.
#[pyclass(frozen, module = "robhaz")]
pub struct Study {
    report: Report,
}

#[pymethods]
impl Study {
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = serde_json::to_string(&self.report);
        let text = text.map_err(|e| of_run("the study has no JSON", &e))?;
        py.import("json")?.call_method1("loads", (text,))
    }

    fn __str__(&self) -> String {
        self.report.text()
    }

    fn __repr__(&self) -> String {
        let (scene, seeds) = (&self.report.scene, self.report.seeds.len());
        format!("<robhaz.Study {scene}: {seeds} seeds>")
    }
}

/// See the stub `_robhaz.pyi`.
#[pyfunction]
#[pyo3(signature = (scene, seeds=10, *, ladder=false))]
pub fn study(py: Python<'_>, scene: &Scene, seeds: u64, ladder: bool) -> PyResult<Study> {
    scene.warn(py)?;
    let mut checked = scene.checked.clone();
    if ladder {
        checked.estimators = self::ladder();
    }
    let name = &checked.name;
    if checked.estimators.is_empty() {
        return Err(PyValueError::new_err(format!(
            "{name} has no estimator to study: leave out `estimator = []`, or study the ladder"
        )));
    }
    if !(1..=10_000).contains(&seeds) {
        let text = format!("seeds: found {seeds}, allowed: 1 to 10000");
        return Err(PyValueError::new_err(text));
    }
    let Some(last) = checked.seed.checked_add(seeds - 1) else {
        return Err(PyValueError::new_err(format!(
            "{seeds} seeds from {} on: the last seed must be below 2^64",
            checked.seed
        )));
    };
    let seeds: Vec<u64> = (checked.seed..=last).collect();
    let cannot = format!("cannot study {name}");
    let report = py.detach(|| {
        let truth = TruthRun::of(&checked).map_err(|e| of_run(&cannot, &e))?;
        let scores = robhaz_study::study(&checked, &truth, &seeds, &|| {});
        let scores = scores.map_err(|e| of_run(&cannot, &e))?;
        let floor = floor(&checked, &truth);
        Ok::<_, PyErr>(Report::new(&checked, &truth, &seeds, floor, &scores))
    })?;
    Ok(Study { report })
}
