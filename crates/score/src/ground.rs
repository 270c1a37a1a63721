//! Errors of the ground that an estimator has found.

use crate::sum::{Rms, share};
use robhaz_estimator::GroundPoint;
use robhaz_model::Vec2;
use robhaz_sim::Truth;
use serde::{Deserialize, Serialize};

/// The true ground at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueGround {
    /// Height over the origin of the section, m.
    pub height: f64,
    /// Angle of the tangent, rad; `None` on a riser.
    pub slope: Option<f64>,
}

/// True place of the origin of an estimator's first section, m, for the truth of the first record
/// and the wheels' radius (m): below the middle axle, at the height of that wheel's contact. The
/// robot has not moved before the first record.
pub fn ground_origin(truth: &Truth, wheel_radius: f64) -> Vec2 {
    let wheel = &truth.wheels[1];
    let lowest = wheel.position.y - wheel_radius * wheel.contact_angle.cos();
    let contact = wheel.contact_list.first();
    Vec2::new(wheel.position.x, contact.map_or(lowest, |c| c.point.y))
}

/// Errors of the ground over its points. Places are those that the robot has found: an error of the
/// place counts as one of height and slope.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroundErrors {
    /// Points compared.
    pub points: u64,
    /// Root mean square error of the height, m.
    pub height_rmse_m: f64,
    /// Share of errors of the height within two stated standard deviations, -.
    pub height_coverage: f64,
    /// Root mean square error of the angle, rad; `None` without a point off the risers.
    pub slope_rmse_rad: Option<f64>,
    /// Share of errors of the angle within two stated standard deviations, -.
    pub slope_coverage: Option<f64>,
}

/// Running sums of one error.
#[derive(Default)]
struct Sums {
    rms: Rms,
    inside: u64,
}

impl Sums {
    fn add(&mut self, error: f64, sigma: f64) {
        self.rms.add(error);
        self.inside += u64::from(error.abs() <= 2.0 * sigma);
    }
}

impl GroundErrors {
    /// The errors over points with their truth; `None` without points.
    pub fn of(points: impl IntoIterator<Item = (GroundPoint, TrueGround)>) -> Option<Self> {
        let (mut height, mut slope) = (Sums::default(), Sums::default());
        for (point, truth) in points {
            height.add(point.height - truth.height, point.sigma_height);
            if let Some(angle) = truth.slope {
                slope.add(point.slope - angle, point.sigma_slope);
            }
        }
        Some(Self {
            points: height.rms.count,
            height_rmse_m: height.rms.value()?,
            height_coverage: share(height.inside, height.rms.count)?,
            slope_rmse_rad: slope.rms.value(),
            slope_coverage: share(slope.inside, slope.rms.count),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_estimator::FrictionBounds;

    /// Closed form: errors of 3 and 4 mm with deviations of 1 and 3 mm; one of the points is on a
    /// riser.
    #[test]
    fn errors_of_two_points() {
        let point = |height: f64, sigma_height: f64| GroundPoint {
            x: 0.0,
            axle_x: 0.0,
            sigma_x: 0.0,
            height,
            sigma_height,
            slope: 0.1,
            friction: FrictionBounds::default(),
            sigma_slope: 0.2,
            section: 0,
        };
        let truth = |slope| TrueGround { height: 0.0, slope };
        let points = [
            (point(0.003, 0.001), truth(None)),
            (point(-0.004, 0.003), truth(Some(0.4))),
        ];
        let errors = GroundErrors::of(points).expect("two points");
        assert_eq!((errors.points, errors.slope_coverage), (2, Some(1.0)));
        assert!((errors.height_rmse_m - 12.5e-6_f64.sqrt()).abs() < 1e-15);
        assert!((errors.height_coverage - 0.5).abs() < 1e-15);
        assert!(
            errors
                .slope_rmse_rad
                .is_some_and(|s| (s - 0.3).abs() < 1e-15)
        );
        assert_eq!(GroundErrors::of([]), None);
    }
}
