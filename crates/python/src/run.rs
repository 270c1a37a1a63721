//! A run of a scene, and its results in memory.

use crate::error::of_run;
use crate::table::Table;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robhaz_record::{Summary, SummarySink, TableSink, comparison_table};
use robhaz_run::RunError;
use robhaz_scene::Scene;
use std::cell::{Cell, RefCell};

/// Samples between two looks for Ctrl-C: about 10 ms of computing.
const SIGNAL_SAMPLES: u32 = 256;

/// See the stub `_robhaz.pyi`.
#[pyclass(frozen, module = "robhaz")]
pub struct Run {
    #[pyo3(get)]
    name: String,
    tables: Vec<Py<Table>>,
    summary: Summary,
}

impl Run {
    /// Runs a scene to its end, without Python's lock.
    pub fn of(py: Python<'_>, scene: &Scene) -> PyResult<Self> {
        let (tables, summary) = py.detach(|| simulate(scene))?;
        let tables = tables.into_iter();
        let tables = tables.map(|(name, batch)| Py::new(py, Table { name, batch }));
        Ok(Self {
            name: scene.name.clone(),
            tables: tables.collect::<PyResult<_>>()?,
            summary,
        })
    }

    /// The tables whose names have this prefix, by the rest of their names.
    fn tables_of<'py>(&self, py: Python<'py>, prefix: &str) -> PyResult<Bound<'py, PyDict>> {
        let tables = PyDict::new(py);
        for table in &self.tables {
            if let Some(name) = table.get().name.strip_prefix(prefix) {
                tables.set_item(name, table)?;
            }
        }
        Ok(tables)
    }
}

type Results = (Vec<(String, arrow_array::RecordBatch)>, Summary);

fn simulate(scene: &Scene) -> PyResult<Results> {
    let name = &scene.name;
    let start = robhaz_run::Run::new(scene);
    let run = start.map_err(|e| of_run(&format!("cannot start {name}"), &e))?;
    let run = run.on_threads();
    let (mut memory, mut summary) = (TableSink::in_memory(), SummarySink::new());
    let (samples, interrupt) = (Cell::new(0_u32), RefCell::new(None));
    let stop = || {
        samples.set(samples.get().wrapping_add(1));
        if !samples.get().is_multiple_of(SIGNAL_SAMPLES) {
            return None;
        }
        let error = Python::attach(|py| py.check_signals()).err()?;
        *interrupt.borrow_mut() = Some(error);
        Some("Ctrl-C")
    };
    let done = run.until(&mut [&mut memory, &mut summary], &stop);
    match (done, interrupt.take()) {
        (Err(RunError::Stopped { .. }), Some(error)) => return Err(error),
        (Err(error), _) => return Err(of_run(&format!("{name} broke off"), &error)),
        (Ok(_), _) => {}
    }
    let summary = summary.summary();
    let summary = summary.map_err(|e| of_run(&format!("no summary of {name}"), &e))?;
    Ok((memory.into_tables(), summary))
}

#[pymethods]
impl Run {
    #[getter]
    fn tables<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.tables_of(py, "")
    }

    #[getter]
    fn truth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.tables_of(py, "")?.as_any().get_item("truth")
    }

    #[getter]
    fn sensors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.tables_of(py, "")?.as_any().get_item("sensors")
    }

    #[getter]
    fn terrain<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.tables_of(py, "")?.as_any().get_item("terrain")
    }

    #[getter]
    fn estimates<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.tables_of(py, "estimate-")
    }

    #[getter]
    fn ground<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.tables_of(py, "ground-")
    }

    #[getter]
    fn summary<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = self.summary.to_json();
        let text = text.map_err(|e| of_run(&format!("no summary of {}", self.name), &e))?;
        py.import("json")?.call_method1("loads", (text,))
    }

    fn __str__(&self) -> String {
        comparison_table(&[(&self.name, &self.summary)])
    }

    fn __repr__(&self) -> String {
        let (name, seconds) = (&self.name, self.summary.duration_s);
        format!(
            "<robhaz.Run {name}: {seconds} s, {} tables>",
            self.tables.len()
        )
    }
}
