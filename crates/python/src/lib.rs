//! The Python package `robhaz`: scenes, runs, tables, estimators and studies.
//!
//! The classes here convert between Python and the crates of the workspace; they compute nothing.
//! Docstrings for users are in `python/robhaz/_robhaz.pyi`. The crate is empty without the feature
//! `extension-module`.

#![cfg(feature = "extension-module")]

mod error;
mod estimate;
mod estimator;
mod readings;
mod run;
mod scene;
mod study;
mod table;
mod whole;

#[pyo3::pymodule]
mod _robhaz {
    #[pymodule_export]
    use crate::{
        error::{EstimateError, RunError, SceneError},
        estimate::Estimate,
        estimator::Estimator,
        run::Run,
        scene::Scene,
        study::{Study, study},
        table::Table,
        whole::{WholeEstimate, WholeEstimator},
    };
    #[pymodule_export]
    #[expect(
        non_upper_case_globals,
        reason = "Python's name of a package's version"
    )]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
