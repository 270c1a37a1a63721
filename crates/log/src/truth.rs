//! Truth from a table: N and T of each wheel, and whatever else the table of a run has.

use crate::stamp::Stamp;
use robhaz_model::Vec2;
use robhaz_run::BothTruth;
use robhaz_sim::Truth;

/// Start of the names of the wheels of each side.
const SIDES: [&str; 2] = ["left_", "right_"];
/// What a table of the truth must have of each wheel.
const REQUIRED: [&str; 2] = ["normal_force", "traction"];
/// What one of both sides may have of each wheel besides: N in the wheel's plane, which is what an
/// estimate is.
const IN_PLANE: &str = "in_plane_normal_force";

/// Columns that a table of the truth must have; one of `both` sides those of six wheels.
pub fn required(both: bool) -> Vec<String> {
    let sides: &[&str] = if both { &SIDES } else { &[""] };
    let of_wheel = |(side, i)| REQUIRED.map(|c| format!("{side}wheel{i}_{c}"));
    let wheels = sides
        .iter()
        .flat_map(|side| (1..=3).map(move |i| (side, i)));
    wheels.flat_map(of_wheel).collect()
}

/// Whether columns are those of the truth of both sides.
pub fn is_of_both(columns: &[String]) -> bool {
    let mut starts = columns.iter();
    starts.any(|name| SIDES.iter().any(|side| name.starts_with(side)))
}

/// What a row of a table of the truth gives: the truth of one side or of a robot in the plane, or that of both sides.
pub type FoundTruth = (Option<Truth>, Option<BothTruth>);

/// Which rows of a table of the truth can be compared with: those with N and T of every wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct TruthRows {
    /// Number of all rows.
    pub rows: u64,
    /// Number of rows with all required columns.
    pub whole: u64,
    /// Stamps of the first and the last of these.
    pub span: Option<(Stamp, Stamp)>,
    /// Cells of the required columns, and number of rows without each.
    empty: Vec<(usize, u64)>,
}

impl TruthRows {
    /// No rows yet of a table with these columns, named as in a run, among them the required ones.
    pub fn new(columns: &[String]) -> Self {
        let required = required(is_of_both(columns));
        let cells = (0..columns.len()).filter(|i| required.contains(&columns[*i]));
        Self {
            rows: 0,
            whole: 0,
            span: None,
            empty: cells.map(|cell| (cell, 0)).collect(),
        }
    }

    /// Adds a row.
    pub fn add(&mut self, stamp: Stamp, cells: &[f64]) {
        self.rows += 1;
        for (cell, count) in &mut self.empty {
            *count += u64::from(cells[*cell].is_nan());
        }
        if self.empty.iter().all(|(cell, _)| cells[*cell].is_finite()) {
            self.whole += 1;
            let first = self.span.map_or(stamp, |(first, _)| first);
            self.span = Some((first, stamp));
        }
    }

    /// The required columns that are empty somewhere, with the number of rows, in words.
    pub fn lacks(&self, columns: &[String]) -> String {
        let of_column = |(cell, count): &(usize, u64)| {
            let name = columns.get(*cell).filter(|_| *count > 0)?;
            Some(format!("{name} in {count}"))
        };
        let columns: Vec<String> = self.empty.iter().filter_map(of_column).collect();
        let (rows, columns) = (self.rows, columns.join(", "));
        format!("of {rows} rows there is no number for {columns}")
    }
}

/// A truth that a row is read into, and what of each wheel is no number of its truth: N and angle
/// of the equivalent contact, whether it slides, and its number of contacts.
struct Row {
    truth: Truth,
    derived: [[f64; 4]; 3],
}

/// The numbers of a row by their columns: kind of the part, and its quantity.
type Numbers<'a> = Vec<([&'static str; 2], &'a mut f64)>;

impl Row {
    /// The numbers that a table of the truth may have, in an order of their own. The contacts of a
    /// wheel one by one are none of them: nothing that a log leaves shows them.
    fn numbers(&mut self) -> Numbers<'_> {
        let Self { truth, derived } = self;
        let mut all: Numbers<'_> = vec![
            (["", "stop_torque"], &mut truth.stop_torque),
            (["", "loop_error"], &mut truth.loop_error),
        ];
        let bars = std::iter::once(&mut truth.body).chain(&mut truth.links);
        let kinds = ["body_", "link1_", "link2_", "link3_"].into_iter();
        for (kind, bar) in kinds.zip(bars) {
            let [[x, y]] = &mut bar.position.data.0;
            let [[vx, vy]] = &mut bar.velocity.data.0;
            let numbers = [x, y, vx, vy, &mut bar.angle, &mut bar.rate];
            let parts = ["x", "y", "vx", "vy", "angle", "rate"].into_iter();
            all.extend(parts.map(|part| [kind, part]).zip(numbers));
        }
        let wheels = truth.wheels.iter_mut().zip(derived);
        for (kind, (wheel, derived)) in ["wheel1_", "wheel2_", "wheel3_"].into_iter().zip(wheels) {
            let [[x, y]] = &mut wheel.position.data.0;
            let [normal_force, contact_angle, sliding, contacts] = derived;
            let parts = [
                ("x", x),
                ("y", y),
                ("angle", &mut wheel.angle),
                ("omega", &mut wheel.omega),
                ("torque", &mut wheel.torque),
                ("normal_force", &mut wheel.normal_force),
                ("traction", &mut wheel.traction),
                ("contact_angle", &mut wheel.contact_angle),
                ("penetration", &mut wheel.penetration),
                ("slip_speed", &mut wheel.slip_speed),
                ("equivalent_normal_force", normal_force),
                ("equivalent_contact_angle", contact_angle),
                ("sliding", sliding),
                ("contacts", contacts),
            ];
            all.extend(parts.map(|(part, number)| ([kind, part], number)));
        }
        let kinds = ["pin_p_", "pin_q_", "pin_r_", "pin_s_"].into_iter();
        for (kind, pin) in kinds.zip(&mut truth.pins) {
            let ([[x, y]], [[fx, fy]]) = (&mut pin.position.data.0, &mut pin.force.data.0);
            let parts = [("x", x), ("y", y), ("force_x", fx), ("force_y", fy)];
            all.extend(parts.map(|(part, number)| ([kind, part], number)));
        }
        all
    }

    /// A row that nothing is known of: not a number.
    fn unknown() -> Self {
        let mut row = Self {
            truth: Truth::default(),
            derived: [[0.0; 4]; 3],
        };
        for (_, number) in row.numbers() {
            *number = f64::NAN;
        }
        // Wheels with one contact that does not slide.
        row.derived = [[f64::NAN, f64::NAN, 0.0, 1.0]; 3];
        row
    }
}

/// The place of a column in the numbers of a row; `None` of one that does not belong to the truth.
fn place(column: &str) -> Option<usize> {
    let column = match column {
        "body_pitch" => "body_angle",
        "body_pitch_rate" => "body_rate",
        other => other,
    };
    let mut row = Row::unknown();
    let numbers = row.numbers();
    let is = |[kind, part]: [&str; 2]| column.strip_prefix(kind) == Some(part);
    numbers.iter().position(|(names, _)| is(*names))
}

/// Whether a column belongs to the truth of one side.
pub fn is_column(name: &str) -> bool {
    place(name).is_some()
}

/// Whether a column belongs to the truth of both sides: what is compared with.
pub fn is_column_of_both(name: &str) -> bool {
    let mut sides = SIDES.iter();
    let wheel = sides.find_map(|side| name.strip_prefix(side));
    let parts = REQUIRED.into_iter().chain([IN_PLANE]);
    let all = parts.flat_map(|part| (1..=3).map(move |i| format!("wheel{i}_{part}")));
    wheel.is_some_and(|wheel| all.into_iter().any(|column| column == wheel))
}

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
    /// The place of each column in the numbers of a row.
    places: Vec<usize>,
    /// Whether the table has N of the equivalent contact of each wheel, as tables of runs have.
    has_equivalent: [bool; 3],
    /// Whether each column is a state or a contact angle, which may jump from row to row.
    jumps: Vec<bool>,
    /// Of a table of both sides, the cells of each wheel: N, T, N in the wheel's plane.
    both: Option<[[Option<usize>; 3]; 6]>,
}

impl TruthColumns {
    /// For a table with these columns, in the units of a run's table.
    pub fn new(columns: &[String]) -> Self {
        let equivalent = |i: usize| format!("wheel{i}_equivalent_normal_force");
        Self {
            names: columns.to_vec(),
            factors: vec![1.0; columns.len()],
            places: columns.iter().filter_map(|name| place(name)).collect(),
            has_equivalent: [1, 2, 3].map(|i| columns.contains(&equivalent(i))),
            jumps: columns.iter().map(|name| jumps(name)).collect(),
            both: is_of_both(columns).then(|| {
                core::array::from_fn(|i| {
                    let (side, wheel) = (SIDES[i / 3], i % 3 + 1);
                    [REQUIRED[0], REQUIRED[1], IN_PLANE].map(|part| {
                        let name = format!("{side}wheel{wheel}_{part}");
                        columns.iter().position(|column| *column == name)
                    })
                })
            }),
        }
    }

    /// For a table with these columns, each with the factor to the unit of a run's table.
    pub fn scaled((columns, factors): (Vec<String>, Vec<f64>)) -> Self {
        Self {
            factors,
            ..Self::new(&columns)
        }
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

    /// The truth of a row's cells at a time (s), as [`Self::truth`] gives it, of one side or of both.
    pub fn found(&self, cells: &[f64], time: f64) -> Option<FoundTruth> {
        let scaled = cells.iter().zip(&self.factors);
        let cells: Vec<f64> = scaled.map(|(x, factor)| x * factor).collect();
        let at_time = |truth: Truth| Truth { time, ..truth };
        let Some(both) = &self.both else {
            return Some((Some(at_time(self.truth(&cells)?)), None));
        };
        let of = |part: usize| {
            let value = |wheel: &[Option<usize>; 3]| wheel[part].map_or(f64::NAN, |c| cells[c]);
            both.each_ref().map(value)
        };
        let [normal_force, traction, in_plane] = [of(0), of(1), of(2)];
        let in_plane = in_plane.iter().all(|n| n.is_finite()).then_some(in_plane);
        let (compared, names) = (in_plane.unwrap_or(normal_force), required(false));
        let columns = Self::new(&names);
        let side = |k: usize| {
            let of_wheel = |i: usize| [compared[3 * k + i], traction[3 * k + i]];
            columns.truth(&[0, 1, 2].map(of_wheel).concat())
        };
        let truth = BothTruth {
            sides: [side(0)?, side(1)?].map(at_time),
            normal_force,
            in_plane,
        };
        Some((None, Some(truth)))
    }

    /// The truth of a row's cells; `None` where N or T of a wheel is missing: there is nothing to
    /// compare with then.
    ///
    /// N, T and angle are those of the wheel, however many contact points an engine has under it:
    /// points across the width of a wheel, or in one patch, are one contact. Only a table that also
    /// has the equivalent contact tells contacts at different places, such as riser and tread,
    /// whose sum of N is not the N of a single contact.
    pub fn truth(&self, cells: &[f64]) -> Option<Truth> {
        let mut row = Row::unknown();
        let mut numbers = row.numbers();
        let places = self.places.iter().zip(cells);
        let read = places.filter(|(_, value)| value.is_finite());
        read.for_each(|(place, value)| *numbers[*place].1 = *value);
        let wheels = row.truth.wheels.iter_mut().zip(row.derived);
        for ((wheel, derived), has_equivalent) in wheels.zip(self.has_equivalent) {
            if !(wheel.normal_force.is_finite() && wheel.traction.is_finite()) {
                return None;
            }
            // Without a number for the equivalent contact of two the force stays unknown, and the
            // record is left out.
            let [normal_force, angle, sliding, contacts] = derived;
            let (sin, cos) = angle.sin_cos();
            let (normal, tangent) = (Vec2::new(-sin, cos), Vec2::new(cos, sin));
            wheel.force = normal * normal_force + tangent * wheel.traction;
            wheel.slides = sliding > 0.0;
            // The cast saturates; a count is small and not negative.
            let contacts = contacts as u32;
            wheel.contacts = if has_equivalent {
                contacts
            } else {
                contacts.min(1)
            };
        }
        Some(row.truth)
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
        TruthColumns::new(&names).truth(&cells)
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
