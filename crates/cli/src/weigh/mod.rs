//! `robhaz weigh`: masses and centres of mass from wheels on scales.

mod table;
mod text;

use self::table::{read_table, table};
use crate::output_file::{Format, OutputFile};
use crate::terminal::{say, warn_of};
use miette::{IntoDiagnostic, Result, WrapErr, bail, miette};
use robhaz_masses::{
    Accuracy, Blocks, CHECK_UNITS, Measurements, Tolerances, is_other_mass, lateral, plan,
    simulate, simulate_both, weigh,
};
use robhaz_scene::{RobotChoice, errors_of_scales};
use std::path::{Path, PathBuf};

/// Arguments of `robhaz weigh`.
#[derive(clap::Args)]
pub struct Args {
    /// The table of the weighing: inclinations of links 1 and 2 and forces of the wheels, a posture
    /// a line. See docs/weighing.md.
    #[arg(
        value_name = "MEASUREMENTS.csv",
        required_unless_present = "plan",
        conflicts_with = "plan"
    )]
    measurements: Option<PathBuf>,
    /// The nominal robot: a file with the section robot of a scene.
    #[arg(long, value_name = "ROBOT.toml")]
    robot: PathBuf,
    /// Writes the weighed robot with its budget (.toml), or with --plan the table to fill in
    /// (.csv).
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replaces an existing file.
    #[arg(long)]
    force: bool,
    /// Prints the N postures on blocks that tell most about this robot.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=20))]
    plan: Option<u8>,
    /// Heights of the blocks that can stand under a wheel, mm; for --plan.
    #[arg(long, value_name = "MM", value_delimiter = ',', requires = "plan", conflicts_with = "measurements", default_values_t = [50.0, 100.0, 150.0])]
    blocks: Vec<f64>,
    /// With --plan: fills the table with what scales would show of this robot, to try the command.
    #[arg(
        long,
        value_name = "ROBOT.toml",
        requires = "plan",
        requires = "out",
        conflicts_with = "measurements"
    )]
    simulate: Option<PathBuf>,
    /// Seed of the errors of --simulate.
    #[arg(
        long,
        value_name = "N",
        requires = "simulate",
        conflicts_with = "measurements",
        default_value_t = 0
    )]
    seed: u64,
    #[command(flatten)]
    errors: Errors,
}

/// Standard deviations of nominal values and readings.
#[derive(clap::Args)]
struct Errors {
    /// Relative error of each nominal mass.
    #[arg(long, value_name = "SHARE", default_value_t = Tolerances::NOMINAL.mass)]
    mass_error: f64,
    /// Distance of each centre of mass from its nominal place, mm.
    #[arg(long, value_name = "MM", default_value_t = 1e3 * Tolerances::NOMINAL.centre)]
    cg_error: f64,
    /// Distance of each pin from its nominal place, mm.
    #[arg(long, value_name = "MM", default_value_t = 1e3 * Tolerances::NOMINAL.pin)]
    pin_error: f64,
    /// Error of a scale's reading, N.
    #[arg(long, value_name = "N", default_value_t = Accuracy::TYPICAL.scale)]
    scale_error: f64,
    /// Relative error of each scale, the same in all its readings: of one that was not compared
    /// with known weights.
    #[arg(long, value_name = "SHARE", default_value_t = Accuracy::TYPICAL.scale_gain)]
    scale_gain: f64,
    /// Constant error of each scale, such as a tare that is off, N.
    #[arg(long, value_name = "N", default_value_t = Accuracy::TYPICAL.scale_zero)]
    scale_zero: f64,
    /// Constant error of the inclinations of a link, deg.
    #[arg(long, value_name = "DEG", default_value_t = 0.1)]
    inclination_offset: f64,
    /// Error of an inclination in one posture, deg.
    #[arg(long, value_name = "DEG", default_value_t = 0.03)]
    inclination_error: f64,
    /// Horizontal force that is left between a wheel and its scale, N.
    #[arg(long, value_name = "N", default_value_t = Accuracy::TYPICAL.horizontal_force)]
    horizontal_force: f64,
}

impl Errors {
    fn tolerances(&self) -> Tolerances {
        Tolerances {
            mass: self.mass_error,
            centre: 1e-3 * self.cg_error,
            pin: 1e-3 * self.pin_error,
        }
    }

    fn accuracy(&self) -> Accuracy {
        Accuracy {
            scale: self.scale_error,
            scale_gain: self.scale_gain,
            scale_zero: self.scale_zero,
            inclination_offset: self.inclination_offset.to_radians(),
            inclination: self.inclination_error.to_radians(),
            horizontal_force: self.horizontal_force,
        }
    }
}

const TABLES: Format = ("tables of a weighing", "csv");
const ROBOTS: Format = ("robots", "toml");

/// Weighs, or plans a weighing.
pub fn run(args: &Args) -> Result<()> {
    let nominal = RobotChoice::load(&args.robot)?;
    match (&args.measurements, args.plan) {
        (Some(measurements), _) => weigh_robot(args, &nominal, measurements),
        (None, count) => plan_postures(args, &nominal, count.unwrap_or(1).into()),
    }
}

fn weigh_robot(args: &Args, nominal: &RobotChoice, path: &Path) -> Result<()> {
    let inputs = [args.robot.clone(), path.to_path_buf()];
    let file = create(args, ROBOTS, &inputs)?;
    let measurements = read_table(path)?;
    let one_side = || {
        miette!(
            "{} has scales under both sides, but {} has no [robot.across]; allowed: a robot that states what lies across, or scales of one side",
            path.display(),
            args.robot.display()
        )
    };
    if !measurements.differences.is_empty() && nominal.whole_rover().is_none() {
        return Err(one_side());
    }
    let (tolerances, accuracy) = (args.errors.tolerances(), args.errors.accuracy());
    let weighed = weigh(&nominal.robot, &measurements, &tolerances, &accuracy).into_diagnostic();
    let weighed = weighed.wrap_err_with(|| format!("cannot weigh with {}", path.display()))?;
    say(&text::weighed(&weighed))?;
    let [found, stated] = [&weighed.robot, &nominal.robot].map(|robot| robot.mass.total());
    if is_other_mass(found / stated) {
        let warning = format!(
            "the weighed side has {found:.2} kg, that of {} {stated:.2} kg{CHECK_UNITS}",
            args.robot.display()
        );
        warn_of(&path.display().to_string(), &warning);
    }
    let mut robot = nominal.weighed(weighed.robot);
    if !measurements.differences.is_empty() {
        let rover = robot.whole_rover().ok_or_else(one_side)?;
        let lateral = lateral(&rover, &measurements.differences, &accuracy).into_diagnostic();
        let lateral = lateral.wrap_err_with(|| format!("cannot weigh with {}", path.display()))?;
        say(&text::lateral(rover.body_place, &lateral))?;
        robot.set_body_place(lateral.body_place.0);
    }
    let version = format!("robhaz {}", env!("CARGO_PKG_VERSION"));
    let text = robot.weighed_to_toml(&weighed.covariance, &version);
    write(file, &text, "the weighed robot and its budget")
}

fn plan_postures(args: &Args, nominal: &RobotChoice, count: usize) -> Result<()> {
    let mut inputs = vec![args.robot.clone()];
    inputs.extend(args.simulate.clone());
    let file = create(args, TABLES, &inputs)?;
    let heights: Vec<f64> = args.blocks.iter().map(|mm| 1e-3 * mm).collect();
    let (tolerances, accuracy) = (args.errors.tolerances(), args.errors.accuracy());
    let plan = plan(&nominal.robot, &tolerances, &accuracy, &heights, count).into_diagnostic()?;
    say(&text::plan(&plan))?;
    let blocks: Vec<Blocks> = plan.postures.iter().map(|p| p.blocks).collect();
    let both = nominal.whole_rover().is_some();
    let simulated = args.simulate.as_ref().map(|path| -> Result<Measurements> {
        let real = RobotChoice::load(path)?;
        let errors = errors_of_scales(args.seed);
        let simulated = match real.whole_rover() {
            Some(rover) if both => simulate_both(&rover, &blocks, &accuracy, errors),
            None if both => bail!(
                "{} has [robot.across], but {} has not; allowed: both or none",
                args.robot.display(),
                path.display()
            ),
            _ => simulate(&real.robot, &blocks, &accuracy, errors),
        };
        simulated.into_diagnostic()
    });
    let text = table(&blocks, both, simulated.transpose()?.as_ref());
    write(file, &text, "the table")
}

fn create(args: &Args, format: Format, inputs: &[PathBuf]) -> Result<Option<OutputFile>> {
    let create = |path: &PathBuf| OutputFile::create(path, format, inputs, args.force);
    args.out.as_ref().map(create).transpose()
}

/// Writes the file if one was asked for, and says so.
fn write(file: Option<OutputFile>, text: &str, what: &str) -> Result<()> {
    let Some(file) = file else {
        return Ok(());
    };
    file.write(text)?;
    let path = file.finish()?;
    say(&format!("{}: {what}", path.display()))
}
