//! The files of a judged path: its table and its figure.

use crate::csv_table::write_columns;
use crate::error::{RecordError, io_error};
use crate::figures::write_needed_friction;
use crate::format::TableFormat;
use crate::point_table::{PointColumn, write_points};
use robhaz_path::{PathReport, PathSetup, Place};
use std::path::{Path, PathBuf};

/// Name of the table.
const NAME: &str = "path";

const COLUMNS: [PointColumn<Place>; 21] = [
    PointColumn::always("x", "m", "centre of the middle wheel", |p| {
        Some(p.wheel_x[1])
    }),
    PointColumn::always("y", "m", "centre of the middle wheel", |p| {
        Some(p.wheel_y[1])
    }),
    PointColumn::always("wheel1_x", "m", "centre of the front wheel", |p| {
        Some(p.wheel_x[0])
    }),
    PointColumn::always("wheel1_y", "m", "centre of the front wheel", |p| {
        Some(p.wheel_y[0])
    }),
    PointColumn::always("wheel3_x", "m", "centre of the rear wheel", |p| {
        Some(p.wheel_x[2])
    }),
    PointColumn::always("wheel3_y", "m", "centre of the rear wheel", |p| {
        Some(p.wheel_y[2])
    }),
    PointColumn::always("opening", "rad", "angle of pin Q, theta_1 - theta_2", |p| {
        Some(p.opening)
    }),
    PointColumn::always("wheel1_contacts", "1", "contacts of the front wheel", |p| {
        Some(count(p.contacts[0]))
    }),
    PointColumn::always(
        "wheel2_contacts",
        "1",
        "contacts of the middle wheel",
        |p| Some(count(p.contacts[1])),
    ),
    PointColumn::always("wheel3_contacts", "1", "contacts of the rear wheel", |p| {
        Some(count(p.contacts[2]))
    }),
    PointColumn {
        name: "needed_mu",
        unit: "1",
        description: "needed friction mu_n; empty where no allowed forces balance the robot",
        nullable: true,
        get: |p| p.needed_mu,
    },
    PointColumn {
        name: "available_mu",
        unit: "1",
        description: "available friction: mu_n plus margin",
        nullable: true,
        get: Place::available_mu,
    },
    PointColumn {
        name: "margin",
        unit: "1",
        description: "how far all friction coefficients can fall",
        nullable: true,
        get: |p| p.margin,
    },
    PointColumn {
        name: "speed",
        unit: "m/s",
        description: "mean speed of the wheels' centres of the driven robot; empty with the drive ideal and where it is stuck",
        nullable: true,
        get: |p| p.speed,
    },
    PointColumn::always(
        "clearance",
        "m",
        "least clearance of body and links to the ground; at 0 or below one touches it",
        |p| Some(p.clearance),
    ),
    force("wheel1_normal_force", "sum of N of the front wheel", |p| {
        Some(p.normal_force?[0])
    }),
    force("wheel2_normal_force", "sum of N of the middle wheel", |p| {
        Some(p.normal_force?[1])
    }),
    force("wheel3_normal_force", "sum of N of the rear wheel", |p| {
        Some(p.normal_force?[2])
    }),
    force("wheel1_traction", "sum of T of the front wheel", |p| {
        Some(p.traction?[0])
    }),
    force("wheel2_traction", "sum of T of the middle wheel", |p| {
        Some(p.traction?[1])
    }),
    force("wheel3_traction", "sum of T of the rear wheel", |p| {
        Some(p.traction?[2])
    }),
];

const fn force(
    name: &'static str,
    description: &'static str,
    get: fn(&Place) -> Option<f64>,
) -> PointColumn<Place> {
    PointColumn {
        name,
        unit: "N",
        description,
        nullable: true,
        get,
    }
}

fn count(contacts: usize) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "at most a few contacts")]
    let count = contacts as f64;
    count
}

/// Files of a judged path below a folder, in one format of the table.
pub fn path_files(folder: &Path, format: TableFormat) -> Vec<PathBuf> {
    let table: &[&str] = match format {
        TableFormat::Parquet => &["path.parquet"],
        TableFormat::Csv => &["path.csv", "columns.csv"],
    };
    let figures = ["figures/needed_friction.svg"];
    let names = table.iter().chain(&figures);
    names.map(|name| folder.join(name)).collect()
}

/// Writes the table `path` and the figure `needed_friction` into a folder, which is created where it does not exist.
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
    std::fs::create_dir_all(&figures).map_err(io_error("create", &figures))?;
    if format == TableFormat::Csv {
        write_columns(folder, &[])?;
    }
    let metadata = [
        ("scene", report.scene.clone()),
        ("drive", report.drive.to_owned()),
    ];
    write_points(folder, format, NAME, &COLUMNS, &report.places, &metadata)?;
    write_needed_friction(&figures, setup, report)
}
