//! Truth from a table: N and T of each wheel, their contacts, and the pins of Fig. 5.

use robhaz_model::Vec2;
use robhaz_run::BothTruth;
use robhaz_sim::Truth;

/// Start of the names of the wheels of each side.
const SIDES: [&str; 2] = ["left_", "right_"];
/// What is read of each wheel: what a table must have, [`REQUIRED`]; what one of one side may have besides; and, of one
/// of both sides, N in the wheel's plane, which is what an estimate is.
const PARTS: [&str; 8] = [
    "normal_force",
    "traction",
    "contact_angle",
    "equivalent_normal_force",
    "equivalent_contact_angle",
    "sliding",
    "contacts",
    "in_plane_normal_force",
];
const REQUIRED: usize = 2;
const EQUIVALENT: usize = 3;
const IN_PLANE: usize = 7;
/// What is read of the pins, of one side.
const PINS: [&str; 8] = [
    "pin_p_x", "pin_p_y", "pin_q_x", "pin_q_y", "pin_r_x", "pin_r_y", "pin_s_x", "pin_s_y",
];

/// The columns of these parts of each wheel, of one side or of `both`.
fn of_wheels(both: bool, parts: &[&str]) -> Vec<String> {
    let sides: &[&str] = if both { &SIDES } else { &[""] };
    let of_side = |side: &&str| [1, 2, 3].map(|i| format!("{side}wheel{i}_"));
    let wheels = sides.iter().flat_map(of_side);
    let of_wheel = |wheel: String| parts.iter().map(move |part| format!("{wheel}{part}"));
    wheels.flat_map(of_wheel).collect()
}

/// Columns that a table of the truth must have; one of `both` sides those of six wheels.
pub fn required(both: bool) -> Vec<String> {
    of_wheels(both, &PARTS[..REQUIRED])
}

/// Columns that are read of a table of the truth.
pub fn columns(both: bool) -> Vec<String> {
    if both {
        return of_wheels(both, &[PARTS[0], PARTS[1], PARTS[IN_PLANE]]);
    }
    let mut columns = of_wheels(both, &PARTS[..IN_PLANE]);
    columns.extend(PINS.map(str::to_owned));
    columns
}

/// Whether columns are those of the truth of both sides.
pub fn is_of_both(columns: &[String]) -> bool {
    let mut starts = columns.iter();
    starts.any(|name| SIDES.iter().any(|side| name.starts_with(side)))
}

/// What a row of a table of the truth gives: the truth of one side or of a robot in the plane, or that of both sides.
pub type FoundTruth = (Option<Truth>, Option<BothTruth>);

/// Whether a column is a state or a contact angle.
fn jumps(name: &str) -> bool {
    let ends = ["contact_angle", "sliding", "contacts"];
    ends.iter().any(|end| name.ends_with(end))
}

/// How the rows of a table are read as truth.
#[derive(Clone, Debug, PartialEq)]
pub struct TruthColumns {
    /// The names of the columns as in the table of a run, without units.
    pub names: Vec<String>,
    /// The factor of each column to the unit of that table.
    factors: Vec<f64>,
    /// The cells of [`PARTS`] of each wheel, three or six.
    wheels: Vec<[Option<usize>; PARTS.len()]>,
    /// Those of [`PINS`].
    pins: [Option<usize>; PINS.len()],
    /// Whether each column is a state or a contact angle, which may jump from row to row.
    jumps: Vec<bool>,
}

impl TruthColumns {
    /// For a table with columns of these names, each with the factor to the unit of a run's table.
    pub fn new(names: Vec<String>, factors: Vec<f64>) -> Self {
        let cell = |name: &str| names.iter().position(|own| own == name);
        let of_wheels = of_wheels(is_of_both(&names), &PARTS);
        let cells: Vec<_> = of_wheels.iter().map(|name| cell(name)).collect();
        Self {
            wheels: cells.as_chunks().0.to_vec(),
            pins: PINS.map(cell),
            jumps: names.iter().map(|name| jumps(name)).collect(),
            names,
            factors,
        }
    }

    /// The cells of the columns that a table must have, in their order.
    pub fn required(&self) -> Vec<usize> {
        let of_wheels = self.wheels.iter().flat_map(|wheel| &wheel[..REQUIRED]);
        let mut cells: Vec<usize> = of_wheels.flatten().copied().collect();
        cells.sort_unstable();
        cells
    }

    /// The cells between those of two rows, at the `share` of the way from the near one: what jumps is
    /// that of the near one, and so is what the far one does not have.
    pub fn between(&self, near: &[f64], far: &[f64], share: f64) -> Vec<f64> {
        let cells = near.iter().zip(far).zip(&self.jumps);
        let between = cells.map(|((near, far), jumps)| match far.is_finite() && !jumps {
            true => near + (far - near) * share,
            false => *near,
        });
        between.collect()
    }

    /// The truth of a row's cells at a time (s), of one side or of both; `None` where N or T of a wheel is missing:
    /// there is nothing to compare with then.
    pub fn found(&self, cells: &[f64], time: f64) -> Option<FoundTruth> {
        let scaled = cells.iter().zip(&self.factors);
        let cells: Vec<f64> = scaled.map(|(x, factor)| x * factor).collect();
        let of = |part: usize| {
            let of_wheel = |i: usize| self.wheels[i][part].map_or(f64::NAN, |cell| cells[cell]);
            core::array::from_fn(of_wheel)
        };
        let ([left, right], _) = self.wheels.as_chunks::<3>() else {
            let truth = self.side(&self.wheels, 0, &cells, time)?;
            return Some((Some(truth), None));
        };
        let in_plane: [f64; 6] = of(IN_PLANE);
        let in_plane = Some(in_plane).filter(|n| n.iter().all(|n| n.is_finite()));
        let compared = in_plane.map_or(0, |_| IN_PLANE);
        let side = |wheels| self.side(wheels, compared, &cells, time);
        let truth = BothTruth {
            sides: [side(left)?, side(right)?],
            normal_force: of(0),
            in_plane,
        };
        Some((None, Some(truth)))
    }

    /// The truth of three wheels, whose N is the part `compared`.
    ///
    /// N, T and angle are those of the wheel, however many contact points an engine has under it:
    /// points across the width of a wheel, or in one patch, are one contact. Only a table that also
    /// has the equivalent contact tells contacts at different places, such as riser and tread,
    /// whose sum of N is not the N of a single contact.
    fn side(
        &self,
        wheels: &[[Option<usize>; PARTS.len()]],
        compared: usize,
        cells: &[f64],
        time: f64,
    ) -> Option<Truth> {
        let value = |cell: Option<usize>| Some(cells[cell?]).filter(|x| x.is_finite());
        let or_unknown = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let mut truth = Truth {
            time,
            ..Truth::default()
        };
        let pins = self.pins.map(value).map(or_unknown);
        for (pin, [x, y]) in truth.pins.iter_mut().zip(pins.as_chunks().0) {
            pin.position = Vec2::new(*x, *y);
        }
        for (wheel, cells) in truth.wheels.iter_mut().zip(wheels) {
            let [_, traction, angle, normal, direction, sliding, contacts, _] = cells.map(value);
            (wheel.normal_force, wheel.traction) = (value(cells[compared])?, traction?);
            wheel.contact_angle = or_unknown(angle);
            // Without a number for the equivalent contact of two the force stays unknown, and the
            // record is left out.
            let (sin, cos) = or_unknown(direction).sin_cos();
            let (across, along) = (Vec2::new(-sin, cos), Vec2::new(cos, sin));
            wheel.force = across * or_unknown(normal) + along * wheel.traction;
            wheel.slides = sliding.is_some_and(|sliding| sliding > 0.0);
            let most = cells[EQUIVALENT].map_or(1.0, |_| f64::INFINITY);
            // A count.
            wheel.contacts = contacts.unwrap_or(1.0).min(most) as u32;
        }
        Some(truth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The row of three equal wheels with these columns.
    fn truth(columns: &[(&str, f64)]) -> Option<Truth> {
        let of_wheel = |i: usize| columns.iter().map(move |(c, _)| format!("wheel{i}_{c}"));
        let names: Vec<String> = (1..=3).flat_map(of_wheel).collect();
        let cells: Vec<f64> = (0..3)
            .flat_map(|_| columns.iter().map(|(_, x)| *x))
            .collect();
        let factors = vec![1.0; names.len()];
        TruthColumns::new(names, factors).found(&cells, 0.0)?.0
    }

    /// However many contact points another engine has under a wheel, N, T and angle of the table
    /// are those of the wheel. An angle that the table does not have stays unknown.
    #[test]
    fn contact_points_of_one_patch_are_one_contact() {
        for contacts in [1.0, 2.0, 4.0, 6.0, 12.0] {
            let n_and_t = [
                ("normal_force", 45.0),
                ("traction", -7.0),
                ("contacts", contacts),
            ];
            let found = truth(&n_and_t).expect("N and T");
            for wheel in &found.wheels {
                let contact = wheel.equivalent_contact().expect("one contact");
                assert_eq!((contact.normal_force, contact.traction), (45.0, -7.0));
                assert!(contact.angle.is_nan());
                assert_eq!(wheel.contacts, 1);
            }
            let angle = [n_and_t.as_slice(), &[("contact_angle", 0.3)]].concat();
            let found = truth(&angle).expect("N and T");
            let contact = found.wheels[2].equivalent_contact().expect("one contact");
            assert_eq!((contact.normal_force, contact.angle), (45.0, 0.3));
        }
        let air = [("normal_force", 0.0), ("traction", 0.0), ("contacts", 0.0)];
        assert_eq!(truth(&air).expect("N and T").wheels[0].contacts, 0);
    }

    /// Contacts at two places, of a table with the equivalent contact: its force counts, and where
    /// there is none the wheel cannot be compared with. Rounding of a root of squares.
    #[test]
    fn contacts_at_two_places_are_their_equivalent() {
        let two = |equivalent: f64| {
            truth(&[
                ("normal_force", 60.0),
                ("traction", 3.0),
                ("contact_angle", 0.1),
                ("contacts", 2.0),
                ("equivalent_normal_force", equivalent),
                ("equivalent_contact_angle", 0.4),
            ])
        };
        let found = two(40.0).expect("N and T").wheels[0];
        let contact = found.equivalent_contact().expect("stated");
        assert!((contact.normal_force - 40.0).abs() < 1e-12, "{contact:?}");
        assert!((contact.angle - 0.4).abs() < 1e-12, "{contact:?}");
        assert_eq!(found.contacts, 2);
        let none = two(f64::NAN).expect("N and T").wheels[0];
        assert!(none.equivalent_contact().is_none());
    }
}
