//! The estimate of one frame.

use pyo3::prelude::*;

type Three = (f64, f64, f64);

/// See the stub `_robhaz.pyi`.
#[pyclass(frozen, module = "robhaz")]
pub struct Estimate {
    inner: robhaz_estimator::Estimate,
}

impl From<robhaz_estimator::Estimate> for Estimate {
    fn from(inner: robhaz_estimator::Estimate) -> Self {
        Self { inner }
    }
}

fn three([a, b, c]: [f64; 3]) -> Three {
    (a, b, c)
}

fn each(sigma: impl Fn(usize) -> Option<f64>) -> Option<Three> {
    Some((sigma(0)?, sigma(1)?, sigma(2)?))
}

#[pymethods]
impl Estimate {
    #[getter]
    fn time(&self) -> f64 {
        self.inner.time
    }

    #[getter]
    fn normal_force(&self) -> Three {
        three(self.inner.normal_force)
    }

    #[getter]
    fn traction(&self) -> Three {
        three(self.inner.traction)
    }

    #[getter]
    fn normal_force_sigma(&self) -> Option<Three> {
        each(|i| self.inner.sigma_normal(i))
    }

    #[getter]
    fn traction_sigma(&self) -> Option<Three> {
        each(|i| self.inner.sigma_traction(i))
    }

    #[getter]
    fn covariance(&self) -> Option<[[f64; 6]; 6]> {
        self.inner.covariance
    }

    #[getter]
    fn contact_angle(&self) -> Three {
        three(self.inner.contact_angle)
    }

    #[getter]
    fn contact_angle_sigma(&self) -> Option<Three> {
        self.inner.contact_angle_sigma.map(three)
    }

    #[getter]
    fn body_pitch(&self) -> f64 {
        self.inner.posture.body
    }

    #[getter]
    fn link_angle(&self) -> Three {
        three(self.inner.posture.links)
    }

    #[getter]
    fn flags(&self) -> Vec<&'static str> {
        self.inner.flags.names().collect()
    }

    fn __repr__(&self) -> String {
        let list = |values: [f64; 3]| values.map(|v| format!("{v:.2}")).join(", ");
        let (n, t) = (list(self.inner.normal_force), list(self.inner.traction));
        format!(
            "<robhaz.Estimate {} s: N = [{n}] N, T = [{t}] N>",
            self.inner.time
        )
    }
}
