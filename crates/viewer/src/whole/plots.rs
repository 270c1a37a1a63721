//! Plots of a rover with both sides.

use super::{SIDES, true_forces};
use crate::colours::{WHEELS, by_index, light};
use crate::series::{EDGE, Line, NARROW, Series, WHEEL_NAMES, WIDE, around, line};
use robhaz_estimator::whole::WholeEstimate;
use robhaz_run::{Frame, RunDescription};

/// N and T of the wheels of each side, with two standard deviations, and what follows from all
/// six.
pub(super) fn plots(run: &RunDescription) -> Series {
    let mut series = Series::default();
    let has_truth = run.has_truth;
    for (k, side) in SIDES.into_iter().enumerate() {
        for (force, quantity) in ["normal_force", "traction"].into_iter().enumerate() {
            series.add(format!("{quantity}/{side}"), lines(has_truth), move |f| {
                let (e, truth) = (estimate(f)?, f.both.as_ref()?.sides.truth.as_ref());
                let of_wheel = |i: usize| {
                    let (value, sigma) = match force {
                        0 => (e.normal_force[i], e.sigma_normal(i)),
                        _ => (e.traction[i], e.sigma_traction(i)),
                    };
                    // A gap where the truth has no row.
                    let truth = truth.map_or(f64::NAN, |truth| true_forces(truth, i)[force]);
                    let truth = has_truth.then_some(truth).into_iter();
                    let band = around(value, sigma.unwrap_or(f64::NAN));
                    truth.chain([value]).chain(band)
                };
                Some((3 * k..3 * k + 3).flat_map(of_wheel).collect())
            });
        }
    }
    let one = |name, k| line(name, by_index(k), NARROW);
    let angles = vec![one("inclination [deg]", 0), one("roll [deg]", 1)];
    series.add("attitude", angles, |f| {
        Some(estimate(f)?.attitude.map(f64::to_degrees).into())
    });
    series.add("tip_margin", vec![one("tip margin [-]", 1)], |f| {
        Some(vec![estimate(f)?.tip_margin])
    });
    series.add("axial_share", vec![one("axial share [-]", 1)], |f| {
        Some(vec![estimate(f)?.axial_share])
    });
    series
}

fn estimate<'a>(frame: &Frame<'a>) -> Option<&'a WholeEstimate> {
    frame.both.as_ref()?.estimate
}

/// The lines of N or T of three wheels.
fn lines(has_truth: bool) -> Vec<Line> {
    let of_wheel = |(wheel, colour): (&&str, _)| {
        let truth = has_truth.then(|| line(format!("{wheel} true [N]"), colour, WIDE));
        // Beside the truth an estimate is lighter.
        let (colour, width) = match has_truth {
            true => (light(colour), NARROW),
            false => (colour, 2.0 * NARROW),
        };
        let edge = |sign| line(format!("{wheel} {sign} 2 sigma [N]"), colour, EDGE);
        let found = [
            line(format!("{wheel} [N]"), colour, width),
            edge("+"),
            edge("-"),
        ];
        truth.into_iter().chain(found)
    };
    WHEEL_NAMES.iter().zip(WHEELS).flat_map(of_wheel).collect()
}
