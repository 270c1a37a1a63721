//! `robhaz path`: a path judged from its geometry before it is driven.

use crate::choice::{Choice, choice, choices};
use crate::results::FORMATS;
use crate::terminal::{tell, warn};
use miette::{IntoDiagnostic, Result, WrapErr, bail};
use robhaz_path::{DriveKind, Options, PathSetup, judge, path_files, write_path};
use robhaz_record::TableFormat;
use robhaz_scene::Scene;
use std::path::{Path, PathBuf};

/// Arguments of `robhaz path`.
#[derive(clap::Args)]
pub struct Args {
    /// Scene file (TOML): robot, ground, friction and torque limit.
    scene: PathBuf,
    /// Mean of the available friction coefficient, in place of contact.mu_s of the scene. Its
    /// friction stretches keep their own.
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    mu: Option<f64>,
    /// Standard deviation of the available friction coefficient, for the probability of go.
    #[arg(
        long,
        value_name = "S",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    mu_sigma: f64,
    /// How the tractions are distributed over the wheels.
    #[arg(long, value_parser = choice(DRIVES), default_value = "ideal")]
    drive: DriveKind,
    /// Distance that the middle wheel travels, m; by default until the rear wheel has passed the
    /// profile.
    #[arg(long, value_name = "D", allow_negative_numbers = true)]
    distance: Option<f64>,
    /// Sets a key of the scene, in place of the file's value. Can be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Also writes the table `path` and the figure `needed_friction` into a folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Format of the table.
    #[arg(long, value_parser = choice(FORMATS), default_value = "parquet")]
    format: TableFormat,
    /// Replaces the files of an earlier judgement.
    #[arg(long)]
    force: bool,
}

/// Distribution of the tractions.
const DRIVES: &[Choice<DriveKind>] = choices! {
    "ideal", "The best one: with the least needed friction" => DriveKind::Ideal;
    "shared", "That of drive.kind = \"shared\": the same T/N at every wheel; driven along the path" => DriveKind::Shared;
    "speed", "That of drive.kind = \"speed\": every wheel turns with the set speed; driven along the path" => DriveKind::Speed;
};

/// Judges the path and prints the result. An error if the robot cannot pass.
pub fn run(args: &Args) -> Result<()> {
    let scene = Scene::load(&args.scene, &args.set)?;
    warn(&scene);
    let options = Options {
        mu: args.mu,
        mu_sigma: args.mu_sigma,
        drive: args.drive,
        distance: args.distance,
    };
    if let Some(folder) = &args.out {
        check_folder(folder, args.format, args.force)?;
    }
    let cannot = || format!("cannot judge the path of {}", args.scene.display());
    let setup = PathSetup::new(&scene, options)
        .into_diagnostic()
        .wrap_err_with(cannot)?;
    let report = judge(&setup).into_diagnostic().wrap_err_with(cannot)?;
    if let Some(folder) = &args.out {
        write_path(folder, args.format, &setup, &report).into_diagnostic()?;
    }
    let document = serde_json::to_value(&report).into_diagnostic()?;
    tell(&report.text(), &document)?;
    match report.go {
        true => Ok(()),
        false => bail!("{}: no-go", scene.name),
    }
}

/// Refuses a folder that holds other files of the same names.
fn check_folder(folder: &Path, format: TableFormat, force: bool) -> Result<()> {
    if folder.symlink_metadata().is_ok() && !folder.is_dir() {
        let shown = folder.display();
        bail!("{shown} is not a folder: --out needs the name of a folder");
    }
    let files = path_files(folder, format);
    match files.iter().find(|file| file.symlink_metadata().is_ok()) {
        Some(file) if !force => bail!(help = "--force replaces it", "{} exists", file.display()),
        _ => Ok(()),
    }
}
