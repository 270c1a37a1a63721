//! A measured track on its way through the command: copied, run again to the bit, shown as a table,
//! warned of.

use crate::support::{robhaz, root, succeeded, words};
use std::fs;
use std::path::Path;
use std::process::Output;

fn run(folder: &Path, args: &[&str]) -> Output {
    let mut command = robhaz(folder);
    command.arg("run").args(args);
    succeeded(command.args(["--format", "csv", "--rerun", "off"]))
}

/// A kerb of 5 cm with points every 5 cm, as a spreadsheet in German writes it, out of order, with
/// a column too many.
fn kerb(folder: &Path) {
    let mut csv = String::from("Zeit [s];x [mm];Höhe [cm]\r\n");
    for i in (0..40).rev() {
        csv += &format!(
            "0;{};{}\r\n",
            300 + 50 * i,
            if i < 10 { "0" } else { "5,0" }
        );
    }
    fs::write(folder.join("kerb.csv"), csv).unwrap();
    let scene = "[terrain]\nkind = 'heights'\nfile = 'kerb.csv'\nheight_column = 'Höhe'\nsort = 'on'\nsmoothing = '2 cm'\n\
                 [record]\nduration = 6\nrate = 200\ncompare_from = 0.5\n[sensors]\nrate = 200\n";
    fs::write(folder.join("kerb.toml"), scene).unwrap();
}

/// Equivalence: the resolved scene with the copy of its track runs to the same bits, wherever its
/// folder lies and when the original is gone; a run with a copy can be replaced by another one.
#[test]
fn a_run_with_a_track_runs_again_to_the_bit() {
    let dir = tempfile::tempdir().unwrap();
    kerb(dir.path());
    let original = fs::read(dir.path().join("kerb.csv")).unwrap();
    run(dir.path(), &["kerb.toml", "--out", "first"]);
    fs::remove_file(dir.path().join("kerb.csv")).unwrap();
    fs::rename(dir.path().join("first"), dir.path().join("moved")).unwrap();
    run(dir.path(), &["moved/scene.toml", "--out", "again"]);
    // In its own place too.
    run(
        dir.path(),
        &["again/scene.toml", "--out", "again", "--force"],
    );
    let [a, b] = ["moved", "again"].map(|run| dir.path().join(run));
    assert_eq!(fs::read(a.join("track.csv")).unwrap(), original);
    for name in [
        "track.csv",
        "scene.toml",
        "truth.csv",
        "terrain.csv",
        "estimate-kalman.csv",
    ] {
        assert!(
            fs::read(a.join(name)).unwrap() == fs::read(b.join(name)).unwrap(),
            "{name}"
        );
    }
    let scene = fs::read_to_string(a.join("scene.toml")).unwrap();
    assert!(scene.contains("file = \"track.csv\"") && scene.contains("file_hash = \"sha256:"));
    assert!(!scene.contains("points = ["));

    // The table holds the ground of the run: at most 5 cm high, nowhere below 0, with the kerb
    // where the file has it.
    let mut table = csv::Reader::from_path(a.join("terrain.csv")).unwrap();
    assert_eq!(
        table.headers().unwrap(),
        vec!["x", "height", "slope", "curvature"]
    );
    let rows: Vec<Vec<f64>> = table
        .records()
        .map(|row| row.unwrap().iter().map(|c| c.parse().unwrap()).collect())
        .collect();
    // Smoothing leaves rounding.
    assert!(rows.iter().all(|r| r[1] > -1e-12 && r[1] < 0.05 + 1e-12));
    let middle = rows.iter().find(|r| r[1] > 0.025).unwrap();
    assert!((middle[0] - 0.775).abs() < 0.01, "{middle:?}");
    let columns = fs::read_to_string(a.join("columns.csv")).unwrap();
    assert!(columns.contains("terrain,curvature,1/m,"));
}

/// A spline that swings is warned of once, on stderr; the default says nothing.
#[test]
fn a_spline_that_swings_is_warned_of() {
    let dir = tempfile::tempdir().unwrap();
    kerb(dir.path());
    let warnings = |args: &[&str]| {
        let output = run(dir.path(), args);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        error.matches("Warning: kerb: terrain: near x = 0.").count()
    };
    let shipped = root().join("scenes/heights.toml");
    let spline = ["--set", "terrain.interpolation=spline"];
    for (scene, out, set, expected) in [
        ("kerb.toml", "monotone", &[][..], 0),
        ("kerb.toml", "spline", &spline, 1),
        (shipped.to_str().unwrap(), "shipped", &[], 0),
    ] {
        let short = words("--set record.duration=1 --set record.compare_from=0.5");
        let args = [&[scene, "--out", out][..], &short, set].concat();
        assert_eq!(warnings(&args), expected, "{out}");
    }
}
