//! Results as text for the terminal.

use robhaz_masses::{Lateral, Misfit, Plan, Weighed, WeighedValue};
use robhaz_record::Grid;

/// A deviation above this share of its prior counts as not seen.
const NOT_SEEN: f64 = 0.95;

/// The load parameters, the single values, and what was not seen.
pub fn weighed(of: &Weighed) -> String {
    let mean = of.robot.mean_wheel_load();
    let (before, after) = (of.forces.before, of.forces.after);
    let [share_before, share_after] = [before, after].map(|force| 100.0 * force / mean);
    let (sum, readings) = (of.misfit.sum, of.misfit.readings);
    let (loads, values) = (table_of(&of.loads, 4), table_of(&of.values, 3));
    let [first, second] = of
        .inclination_offsets
        .map(|(offset, sigma)| format!("{:+.2} ±{:.2}", offset.to_degrees(), sigma.to_degrees()));
    let is_unseen = |value: &&WeighedValue| value.deviation > NOT_SEEN * value.prior;
    let unseen = of.values.iter().filter(is_unseen).map(|v| v.name.as_str());
    let unseen = match unseen.collect::<Vec<_>>().join(", ").as_str() {
        "" => "The readings determine every value better than the tolerances do.".to_owned(),
        names => {
            format!("Hardly observable from these readings, and hardly corrected: {names}.")
        }
    };
    format!(
        "What the wheel forces depend on, with one standard deviation\n{loads}\n\
             Single values; they are known as far as the nominal values separate them\n{values}\n\
             {unseen}\n\
             Offsets of the inclinations, deg: link1 {first}, link2 {second}\n\
             Fit: weighted sum of squares {sum:.1} for {readings} readings.\n\
             Error of N by masses, centres of mass and pins, on a driven ground: {before:.2} N ({share_before:.1} %) with the nominal robot, \
             {after:.2} N ({share_after:.2} %) after weighing."
    )
}

/// The lateral centre of mass, and the body's nominal place, m.
pub fn lateral(nominal: f64, of: &Lateral) -> String {
    let shown = |(place, sigma): (f64, f64)| format!("{:.1} ±{:.1}", 1e3 * place, 1e3 * sigma);
    let (rover, body) = (shown(of.rover_place), shown(of.body_place));
    let (nominal, Misfit { sum, readings }) = (1e3 * nominal, of.misfit);
    format!(
        "Lateral centre of mass, mm to the left: rover {rover}, its body {body}, nominal {nominal:.1} (robot.across.body_place).\n\
             Fit: weighted sum of squares {sum:.1} for {readings} differences between left and right beyond it."
    )
}

/// Values with so many digits, lengths in mm with one less.
fn table_of(values: &[WeighedValue], digits: usize) -> String {
    let mut table = Grid::new(&[0], &["", "nominal", "weighed", "unit"]);
    for value in values {
        let (factor, unit, digits) = match value.unit {
            "m" => (1e3, "mm", digits - 1),
            unit => (1.0, unit, digits),
        };
        let shown = |value: f64, sigma: f64| {
            let (value, sigma) = (factor * value, factor * sigma);
            format!("{value:.digits$} ±{sigma:.digits$}")
        };
        let drawn = shown(value.drawn, value.prior);
        let found = shown(value.found, value.deviation);
        table.row([value.name.clone(), drawn, found, unit.to_owned()]);
    }
    table.text(None)
}

/// The postures, and how exact the forces are after each.
pub fn plan(of: &Plan) -> String {
    let header = [
        "posture",
        "block1, mm",
        "block2, mm",
        "block3, mm",
        "link1, deg",
        "link2, deg",
        "N1, N",
        "N2, N",
        "N3, N",
        "error of N after it, N",
    ];
    let mut table = Grid::new(&[0], &header);
    for (k, posture) in of.postures.iter().enumerate() {
        let mut row = vec![(k + 1).to_string()];
        row.extend(posture.blocks.map(|h| format!("{:.0}", 1e3 * h)));
        row.extend(posture.angles.map(|a| format!("{:.1}", a.to_degrees())));
        row.extend(posture.forces.map(|n| format!("{n:.1}")));
        row.push(format!("{:.3}", posture.after));
        table.row(row);
    }
    format!(
        "The postures that tell most, of {} on these blocks; angles and forces of the nominal robot\n{}\n\
             Without weighing, the tolerances of the nominal values are an error of N of {:.2} N.",
        of.candidates,
        table.text(None),
        of.before
    )
}
