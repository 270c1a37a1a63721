//! The estimate of one frame.

use pyo3::prelude::*;

type Three = (f64, f64, f64);

/// See the stub `_robhaz.pyi`.
#[pyclass(frozen, get_all, module = "robhaz")]
pub struct Estimate {
    time: f64,
    normal_force: Three,
    traction: Three,
    normal_force_sigma: Option<Three>,
    traction_sigma: Option<Three>,
    covariance: Option<[[f64; 6]; 6]>,
    contact_angle: Three,
    contact_angle_sigma: Option<Three>,
    body_pitch: f64,
    link_angle: Three,
    flags: Vec<&'static str>,
    weight: Option<&'static str>,
}

impl From<robhaz_estimator::Estimate> for Estimate {
    fn from(found: robhaz_estimator::Estimate) -> Self {
        Self {
            time: found.time,
            normal_force: found.normal_force.into(),
            traction: found.traction.into(),
            normal_force_sigma: each(|i| found.sigma_normal(i)),
            traction_sigma: each(|i| found.sigma_traction(i)),
            covariance: found.kalman.map(|k| k.covariance),
            contact_angle: found.contact_angle.into(),
            contact_angle_sigma: found.kalman.map(|k| k.contact_angle_sigma.into()),
            body_pitch: found.posture.body,
            link_angle: found.posture.links.into(),
            flags: found.flags.names().collect(),
            weight: found
                .kalman
                .and_then(|k| k.torque_scale)
                .map(|scale| scale.confirmation.name()),
        }
    }
}

fn each(sigma: impl Fn(usize) -> Option<f64>) -> Option<Three> {
    Some((sigma(0)?, sigma(1)?, sigma(2)?))
}

#[pymethods]
impl Estimate {
    fn __repr__(&self) -> String {
        let list = |(a, b, c): Three| [a, b, c].map(|v| format!("{v:.2}")).join(", ");
        let (n, t) = (list(self.normal_force), list(self.traction));
        format!(
            "<robhaz.Estimate {} s: N = [{n}] N, T = [{t}] N>",
            self.time
        )
    }
}
