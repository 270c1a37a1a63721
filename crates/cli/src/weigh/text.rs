//! Results as text for the terminal.

use robhaz_masses::{Plan, Weighed, WeighedValue};
use robhaz_record::Grid;

/// A deviation above this share of its prior counts as not seen.
const NOT_SEEN: f64 = 0.95;

/// The load parameters, the single values, and what was not seen.
pub fn weighed(of: &Weighed) -> String {
    let mean = of.robot.mean_wheel_load();
    let percent = |force: f64| 100.0 * force / mean;
    let [first, second] = of
        .inclination_offsets
        .map(|(offset, sigma)| format!("{:+.2} ±{:.2}", offset.to_degrees(), sigma.to_degrees()));
    let is_unseen = |value: &&WeighedValue| value.deviation > NOT_SEEN * value.prior;
    let unseen = of.values.iter().filter(is_unseen).map(|v| v.name.as_str());
    let unseen = match unseen.collect::<Vec<_>>().join(", ").as_str() {
        "" => "The readings determine every value better than the tolerances do.".to_owned(),
        names => {
            format!("Not observable from these readings, kept at their nominal values: {names}.")
        }
    };
    format!(
        "What the wheel forces depend on, with one standard deviation\n{}\n\
             Single values; they are known as far as the nominal values separate them\n{}\n\
             {unseen}\n\
             Offsets of the inclinations, deg: link1 {first}, link2 {second}\n\
             Fit: weighted sum of squares {:.1} for {} readings.\n\
             Error of N by masses, centres of mass and pins, on a driven ground: {:.2} N ({:.1} %) with the nominal robot, {:.2} N ({:.2} %) \
             after weighing.",
        table_of(&of.loads, 4),
        table_of(&of.values, 3),
        of.misfit.sum,
        of.misfit.readings,
        of.forces.before,
        percent(of.forces.before),
        of.forces.after,
        percent(of.forces.after),
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
