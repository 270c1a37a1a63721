//! Needed friction against closed forms.

// A test may panic.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use robhaz_path::{DriveKind, Options, PathReport, PathSetup, Reason, judge};
use robhaz_scene::Scene;
use std::path::Path;

fn scene(text: &str, set: &[&str]) -> Scene {
    let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
    Scene::parse(text, "trial", Path::new(""), &set).unwrap()
}

fn judged(text: &str, set: &[&str], options: Options) -> PathReport {
    judge(&PathSetup::new(&scene(text, set), options).unwrap()).unwrap()
}

/// A slope that starts level at x = 0.7 m and goes on for 3 m.
fn ramp(degrees: f64) -> String {
    format!("[terrain]\nkind = \"ramp\"\nangle = \"{degrees} deg\"\nstart = 0.7\nlength = 3.0\n")
}

#[test]
fn probe() {
    for text in [ramp(15.0), "[terrain]\nkind = \"step\"\nkerb = \"50 mm\"\nstart = 0.7\n".to_owned(),
        "[terrain]\nkind = \"stairs\"\nrise = \"80 mm\"\nrun = \"300 mm\"\ncount = 4\nstart = 0.7\n".to_owned(), String::new(),
        "[terrain]\nkind = \"step\"\nkerb = \"150 mm\"\nstart = 0.7\n".to_owned(), "[terrain]\nkind = \"rough\"\nclass = \"E\"\nextent = 10\n".to_owned()] {
        let start = std::time::Instant::now();
        let scene = scene(&text, &[]);
        let setup = PathSetup::new(&scene, Options::default()).unwrap();
        let report = judge(&setup);
        let time = start.elapsed();
        match report {
            Ok(report) => println!("{}\n{} places, {time:?}", report.text().lines().last().unwrap(), report.places.len()),
            Err(e) => println!("{e}"),
        }
    }
}
