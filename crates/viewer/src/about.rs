//! How to read the recording, in words inside the recording.

use crate::forces::ForceScale;
use robhaz_run::RunDescription;
use std::fmt::Write as _;

/// A page of Markdown.
pub(crate) fn page(run: &RunDescription, chosen: Option<usize>) -> String {
    let robot = &run.robot;
    let scale = ForceScale::new(&robot.robot);
    let source = match &run.world {
        Some(world) => format!("terrain {}", world.terrain.kind),
        None => "recorded readings without truth".to_owned(),
    };
    let mut text = format!(
        "# {}\n\nRobot geometry {}, masses {}, {}, {} s at {} Hz.\n\n\
         - Wheels: front blue, middle vermilion, rear green, in every view.\n\
         - Arrows at the contacts: N pushes up into the wheel, T lies along the ground and drives forward when it points \
         forward. 1 m of arrow is {:.0} N.\n",
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
            "- Thick arrows are true, thin ones beside them come from the estimator {}; the bar across their end is \
             two standard deviations to both sides, where the estimator knows them.",
            run.estimators[k].label
        );
    }
    text.push_str(
        "- Grey traces are the paths of the pins P, Q, R, S so far. The arc at Q is how far link 1 can turn; a stop is thick \
         while it is reached.\n\
         - Ground of another colour has friction coefficients of its own: like ice where it grips less, red where it grips \
         more.\n\
         - Time series: wide lines are true, narrow ones estimated, the narrowest are two standard deviations. A gap is a time \
         without an estimate; mu_n = T/N also has one where a wheel carries less than 1 N. Slip margin: static coefficient \
         of the ground less |mu_n|. Contact angles are those of the ground (true) and those that the estimators are given.\n\
         - Lines are kept at 125 Hz, the scene at 60 Hz: peaks at edges are shorter. Events and the lanes of wheels and \
         estimators are looked for at every record.\n",
    );
    text
}
