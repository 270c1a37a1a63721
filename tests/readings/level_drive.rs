//! A drive on level ground whose forces are known in closed form, as a log that a test then spoils.

use crate::support::{assert_contains, columns, robhaz, text, words};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use robhaz_model::Robot;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Output;
use tempfile::TempDir;

/// A log of robot A: 6 s at 100 Hz, rest until 1 s, then to 0.2 m/s within 0.6 s. Its readings have the errors of the
/// default budget; the torques are those of damping and acceleration, so that the drive's mean traction is 0.
#[derive(Clone)]
pub struct LevelDrive {
    /// Name of each column, and its values, a row each.
    pub columns: Vec<(String, Vec<f64>)>,
}

/// The description of the log: robot A, stated exactly.
pub const DESCRIPTION: &str =
    "[robot]\ngeometry = \"A\"\nmass = \"caption\"\n[budget]\nbody_cg = 0\nlink_masses = 0\n";

/// The same of a robot in the plane: its deviations are those of the readings alone.
pub fn in_the_plane() -> String {
    format!("sides = \"plane\"\n{DESCRIPTION}")
}

/// From when on forces count, s: the drive is steady from 1.6 s on.
const STEADY: f64 = 2.0;

/// Draws from N(0, 1).
pub fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut random = Pcg64Mcg::new(u128::from(seed));
    move || StandardNormal.sample(&mut random)
}

impl LevelDrive {
    /// With the noise of this seed.
    pub fn new(seed: u64) -> Self {
        let mut random = normal(seed);
        let mut noise = |size: f64| size * random();
        let robot = Robot::default_a();
        let radius = robot.geometry.wheel_radius;
        let inertia = robot.mass.wheel_inertia + robot.mass.rotor_inertia;
        let of_robot = radius * radius * robot.mass.total() / 3.0;
        let names = [
            "time",
            "wheel1_angle",
            "wheel2_angle",
            "wheel3_angle",
            "wheel1_motor_torque",
            "wheel2_motor_torque",
            "wheel3_motor_torque",
            "link1_inclination",
            "link2_inclination",
            "link1_rate",
            "link2_rate",
        ];
        let mut columns: Vec<_> = names.map(|name| (name.to_owned(), Vec::new())).into();
        let count = std::f64::consts::TAU / 160_000.0;
        let degree = 0.1_f64.to_radians();
        for k in 0..601_u32 {
            let time = f64::from(k) / 100.0;
            let (angle, speed, acceleration) = spin(time);
            let torque = 0.15 * speed + (inertia + of_robot) * acceleration;
            let counted = |start: f64| ((start + angle) / count).floor() * count;
            let row = [
                time,
                counted(0.0),
                counted(0.31),
                counted(-0.47),
                torque + noise(0.1),
                torque + noise(0.1),
                torque + noise(0.1),
                noise(degree),
                noise(degree),
                noise(degree),
                noise(degree),
            ];
            for ((_, values), value) in columns.iter_mut().zip(row) {
                values.push(value);
            }
        }
        Self { columns }
    }

    /// The values of a column.
    pub fn column(&mut self, name: &str) -> &mut Vec<f64> {
        let found = self.columns.iter_mut().find(|(column, _)| column == name);
        &mut found.unwrap_or_else(|| panic!("{name}")).1
    }

    /// Changes the values of all columns whose names end so, each by its row.
    pub fn change(&mut self, end: &str, mut of: impl FnMut(usize, f64) -> f64) {
        for (_, values) in self
            .columns
            .iter_mut()
            .filter(|(name, _)| name.ends_with(end))
        {
            values
                .iter_mut()
                .enumerate()
                .for_each(|(k, x)| *x = of(k, *x));
        }
    }

    /// Writes the log as CSV.
    pub fn write(&self, path: &Path) {
        let names: Vec<_> = self.columns.iter().map(|(name, _)| name.as_str()).collect();
        let mut table = names.join(",") + "\n";
        for row in 0..self.columns[0].1.len() {
            let cells: Vec<_> = self
                .columns
                .iter()
                .map(|(_, c)| c[row].to_string())
                .collect();
            writeln!(table, "{}", cells.join(",")).unwrap();
        }
        fs::write(path, table).unwrap();
    }
}

/// Angle (rad), speed and acceleration of a wheel that starts at 1 s along a quintic ramp of 0.6 s to 2 rad/s.
fn spin(time: f64) -> (f64, f64, f64) {
    let (ramp, speed) = (0.6, 2.0);
    let u = ((time - 1.0) / ramp).clamp(0.0, 1.0);
    let share = u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u);
    let by_u = 30.0 * (u * (1.0 - u)).powi(2);
    let turned = ramp * (2.5 * u.powi(4) - 3.0 * u.powi(5) + u.powi(6));
    let after = (time - 1.0 - ramp).max(0.0);
    (speed * (turned + after), speed * share, speed * by_u / ramp)
}

/// A folder with a description, `d.toml`, and the log of the drive with a change, `log.csv`.
pub fn logged(description: &str, change: impl FnOnce(&mut LevelDrive)) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("d.toml"), description).unwrap();
    let mut drive = LevelDrive::new(1);
    change(&mut drive);
    drive.write(&folder.path().join("log.csv"));
    folder
}

/// Output of `robhaz check log.csv --sensors d.toml` in a folder.
pub fn check(folder: &Path) -> Output {
    check_of(folder, "log.csv")
}

/// The same of another log.
pub fn check_of(folder: &Path, log: &str) -> Output {
    let mut command = robhaz(folder);
    command.args(["check", "-v", log, "--sensors", "d.toml"]);
    command.output().unwrap()
}

/// Output of `robhaz estimate log.csv --sensors d.toml`, with `kalman` without contact angles, into the folder `out`.
pub fn estimate(folder: &Path) -> Output {
    estimate_of(folder, "log.csv")
}

/// The same of another log.
pub fn estimate_of(folder: &Path, log: &str) -> Output {
    let mut command = robhaz(folder);
    command.args(["estimate", log, "--sensors", "d.toml"]);
    command.args(words("--estimator kalman --contact-angles none"));
    command.args(words("--out out --format csv --force --rerun off"));
    command.output().unwrap()
}

/// `check` finds no fault: what it printed and warned of.
#[track_caller]
pub fn sound(folder: &Path) -> [String; 2] {
    let output = check(folder);
    let said = [&output.stdout, &output.stderr].map(|of| text(of));
    assert!(output.status.success(), "{said:?}");
    said
}

/// Both commands refuse the log, with an error that has these parts.
#[track_caller]
pub fn refused(folder: &Path, log: &str, parts: &[&str]) {
    for output in [check_of(folder, log), estimate_of(folder, log)] {
        let error = text(&output.stderr);
        assert!(!output.status.success(), "not refused: {parts:?}");
        for part in parts {
            assert_contains(&error, part);
        }
    }
}

/// Largest error of N in the steady part, N: the estimate in `out` against the static loads.
pub fn largest_error(folder: &Path) -> f64 {
    let loads = Robot::default_a().static_loads().unwrap();
    let table = columns(&folder.join("out/estimate-kalman.csv"));
    let mut largest = 0.0_f64;
    for (i, load) in loads.iter().enumerate() {
        let forces = &table[&format!("wheel{}_normal_force", i + 1)];
        for (time, force) in table["time"].iter().zip(forces) {
            if *time >= STEADY {
                largest = largest.max((force - load).abs());
            }
        }
    }
    largest
}

/// The drive itself is sound: no fault, and N within 2 N of the static loads, three of the
/// deviations that are stated with the budget's errors, 0.3 to 0.6 N.
#[test]
fn the_level_drive_has_its_static_loads() {
    let dir = logged(DESCRIPTION, |_| ());
    let folder = dir.path();
    sound(folder);
    let estimated = estimate(folder);
    assert!(estimated.status.success(), "{}", text(&estimated.stderr));
    let error = largest_error(folder);
    assert!(error < 2.0, "{error}");
}
