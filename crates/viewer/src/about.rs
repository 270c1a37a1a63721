//! How to read the recording, in words inside the recording.

use crate::scene_view::ForceScale;
use robhaz_scene::Scene;
use std::fmt::Write as _;

/// A page of Markdown.
pub(crate) fn page(scene: &Scene, scale: ForceScale, chosen: Option<usize>) -> String {
    let robot = &scene.robot;
    let mut text = format!(
        "# {}\n\nRobot geometry {}, masses {}, terrain {}, {} s at {} Hz.\n\n\
         - Wheels: front blue, middle vermilion, rear green, in every view.\n\
         - Arrows at the contacts: N pushes up into the wheel, T lies along the ground and drives forward when it points \
         forward. 1 m of arrow is {:.0} N.\n",
        scene.name,
        robot.geometry_name,
        robot.mass_name,
        scene.terrain.kind,
        scene.record.duration,
        scene.record.rate,
        scale.newtons_per_metre(),
    );
    if let Some(k) = chosen {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "- Thick arrows are true, thin light ones beside them come from the estimator {}.",
            scene.estimators[k].name
        );
    }
    text.push_str(
        "- Coloured traces are the paths of the pins P, Q, R, S so far.\n\
         - Time series: wide lines are true, narrow ones estimated. A gap is a time without an estimate; mu_n = T/N also has \
         one where a wheel carries less than 1 N. Contact angles are those of the ground (true) and those that the estimators \
         are given.\n",
    );
    text
}
