//! Many seeds of one scene.

use crate::error::of_run;
use crate::scene::Scene;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use robhaz_study::{Report, StudyError, Watch, compute_dataset};

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
    if !(1..=10_000).contains(&seeds) {
        let text = format!("seeds: found {seeds}, allowed: 1 to 10000");
        return Err(PyValueError::new_err(text));
    }
    let refused = |error: StudyError| match error {
        StudyError::Refused(why) => PyValueError::new_err(why),
        error => of_run(&format!("cannot study {}", scene.checked.name), &error),
    };
    let report = py.detach(|| {
        let study = robhaz_study::Study::of_scene(&scene.checked, seeds, ladder)?;
        let jobs = std::thread::available_parallelism().map_or(1, usize::from);
        Report::of(&study, &compute_dataset(&study, jobs, &Watch::SILENT)?)
    });
    let report = report.map_err(refused)?;
    Ok(Study { report })
}
