//! The page of the recording that explains its views.

use crate::forces::ForceScale;
use crate::rates::rates;
use robhaz_run::RunDescription;
use std::fmt::Write as _;

/// The page as Markdown. `chosen` is the index of the estimator whose forces are drawn; all rates
/// are divided by `thinning`.
pub(crate) fn page(run: &RunDescription, chosen: Option<usize>, thinning: f64) -> String {
    let robot = &run.robot;
    let scale = ForceScale::new(&robot.robot);
    let source = match &run.world {
        Some(world) => format!("terrain {}", world.terrain.kind),
        None if run.has_truth => {
            "recorded readings, compared with a table of true forces".to_owned()
        }
        None => "recorded readings without truth".to_owned(),
    };
    let mut text = format!(
        "# {}\n\nRobot geometry {}, masses {}, {}, {} s at {} Hz.\n\n\
         - Wheels: front blue, middle vermilion, rear green, in every view.\n\
         - Arrows at the contacts: N points into the wheel, T along the ground. T > 0 drives forward. 1 m of arrow is \
         {:.0} N.\n",
        run.name,
        robot.geometry_name,
        robot.mass_name,
        source,
        run.record.duration,
        run.record.rate,
        scale.newtons_per_metre(),
    );
    if let Some(k) = chosen {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "- Thick arrows are true; thin arrows beside them are from the estimator {}. The bar across the end of an \
             arrow is two standard deviations to both sides, if the estimator states them.",
            run.estimators[k].label
        );
    }
    text.push_str(
        "- Grey lines are the paths of the pins P, Q, R, S. The arc at Q is the range of link 1 between its \
         end stops.\n\
         - Ground of another colour is a friction stretch: light blue for less friction than elsewhere, red \
         for more.\n\
         - Time series: wide lines are true, narrow lines estimated, the narrowest are two standard \
         deviations. A gap is a time without an estimate; needed friction mu_n = T/N also has a gap while N \
         is below 1 N. The slip margin is the static coefficient of the ground minus |mu_n|. Contact angles \
         are those of the ground (true), those that the estimators get (dark), and those of the \
         estimator of the needed friction (light). With two contacts of a wheel the true N, \
         needed friction and contact angle are those of the equivalent contact: the single contact with the same force on \
         the axle and the same T. The arrows show both contacts.\n",
    );
    let [series, frames] = rates(thinning).map(|rate| (10.0 * rate).round() / 10.0);
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "- Time series have {series} Hz, the animation {frames} Hz: peaks at edges are shorter than a sample. Events, \
         and the lanes of wheels and estimators, are detected at every record."
    );
    text
}
