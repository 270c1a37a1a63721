//! The files of a judged path: its table and its figure.

use crate::figure::write_needed_friction;
use crate::report::{PathReport, Place};
use crate::setup::PathSetup;
use robhaz_record::{PointColumn, RecordError, TableFormat, create_folder, write_points};
use std::path::{Path, PathBuf};

/// Name of the table.
const NAME: &str = "path";

const COLUMNS: &[PointColumn<Place>] = robhaz_record::point_columns! {
    Float "x", "m", "centre of the middle wheel" => |p| Some(p.wheel_x[1]);
    Float "y", "m", "centre of the middle wheel" => |p| Some(p.wheel_y[1]);
    Float "wheel1_x", "m", "centre of the front wheel" => |p| Some(p.wheel_x[0]);
    Float "wheel1_y", "m", "centre of the front wheel" => |p| Some(p.wheel_y[0]);
    Float "wheel3_x", "m", "centre of the rear wheel" => |p| Some(p.wheel_x[2]);
    Float "wheel3_y", "m", "centre of the rear wheel" => |p| Some(p.wheel_y[2]);
    Float "opening", "rad", "angle of pin Q, theta_1 - theta_2" => |p| Some(p.opening);
    Float "wheel1_contacts", "1", "contacts of the front wheel" => |p| Some(count(p.contacts[0]));
    Float "wheel2_contacts", "1", "contacts of the middle wheel" => |p| Some(count(p.contacts[1]));
    Float "wheel3_contacts", "1", "contacts of the rear wheel" => |p| Some(count(p.contacts[2]));
    Optional "needed_mu", "1", "needed friction mu_n; empty where no allowed forces balance the robot" => |p| p.needed_mu;
    Optional "available_mu", "1", "available friction: mu_n plus margin" => Place::available_mu;
    Optional "margin", "1", "how far all friction coefficients can fall" => |p| p.margin;
    Optional "speed", "m/s",
        "mean speed of the wheels' centres of the driven robot; empty with the drive ideal and where it is stuck" => |p| p.speed;
    Float "clearance", "m", "least clearance of body and links to the ground; at 0 or below one touches it" =>
        |p| Some(p.clearance);
    Optional "wheel1_normal_force", "N", "sum of N of the front wheel" => |p| Some(p.normal_force?[0]);
    Optional "wheel2_normal_force", "N", "sum of N of the middle wheel" => |p| Some(p.normal_force?[1]);
    Optional "wheel3_normal_force", "N", "sum of N of the rear wheel" => |p| Some(p.normal_force?[2]);
    Optional "wheel1_traction", "N", "sum of T of the front wheel" => |p| Some(p.traction?[0]);
    Optional "wheel2_traction", "N", "sum of T of the middle wheel" => |p| Some(p.traction?[1]);
    Optional "wheel3_traction", "N", "sum of T of the rear wheel" => |p| Some(p.traction?[2]);
};

fn count(contacts: usize) -> f64 {
    // At most a few contacts.
    contacts as f64
}

/// Files of a judged path below a folder, in one format of the table.
pub fn path_files(folder: &Path, format: TableFormat) -> Vec<PathBuf> {
    let names: &[&str] = match format {
        TableFormat::Parquet => &["path.parquet"],
        TableFormat::Csv => &["path.csv", "columns.csv"],
    };
    let names = names.iter().chain(&["figures/needed_friction.svg"]);
    names.map(|name| folder.join(name)).collect()
}

/// Writes the table `path` and the figure `needed_friction` into a folder, which is created where
/// it does not exist.
///
/// # Errors
/// [`RecordError`] of the file system and of the drawing library.
pub fn write_path(
    folder: &Path,
    format: TableFormat,
    setup: &PathSetup,
    report: &PathReport,
) -> Result<(), RecordError> {
    let figures = folder.join("figures");
    create_folder(&figures)?;
    let metadata = [
        ("scene", report.scene.clone()),
        ("drive", report.drive.to_owned()),
    ];
    write_points(folder, format, NAME, COLUMNS, &report.places, &metadata)?;
    write_needed_friction(&figures, setup, report)
}
