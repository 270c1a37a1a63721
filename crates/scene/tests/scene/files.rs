//! The shipped files: every scene and every robot loads, and has the values of the crates'
//! defaults.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at the first surprise"
)]

use robhaz_model::{Geometry, MassSet, Posture};
use robhaz_scene::Scene;
use std::path::{Path, PathBuf};

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn toml_files(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(top().join(folder)).unwrap();
    let mut files: Vec<_> = entries.map(|e| e.unwrap().path()).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == "toml"));
    files.sort();
    files
}

fn opens_with_comment(file: &Path) -> bool {
    std::fs::read_to_string(file).unwrap().starts_with("# ")
}

fn parse(text: &str) -> Scene {
    Scene::parse(text, "scene.toml", &top(), &[]).unwrap()
}

#[test]
fn every_shipped_scene_loads_under_its_own_name() {
    let files = toml_files("scenes");
    assert!(files.len() >= 4);
    for file in files {
        let scene = Scene::load(&file, &[]).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(scene.name, file.file_stem().unwrap().to_str().unwrap());
        assert!(opens_with_comment(&file), "{}", file.display());
    }
}

#[test]
fn every_shipped_robot_file_loads() {
    for file in toml_files("robots") {
        let stem = file.file_stem().unwrap().to_str().unwrap();
        let part = stem.split('-').next().unwrap();
        let of_part = || parse(&format!("[robot]\n{part} = 'robots/{stem}.toml'"));
        let (name, expected) = match part {
            "geometry" => (of_part().robot.geometry_name, format!("robots/{stem}.toml")),
            "mass" => (of_part().robot.mass_name, format!("robots/{stem}.toml")),
            // A rover is a scene of its own.
            _ => {
                let scene = Scene::load(&file, &[]).unwrap_or_else(|e| panic!("{e}"));
                (scene.robot.geometry_name, stem.to_owned())
            }
        };
        assert_eq!(name, expected);
        assert!(opens_with_comment(&file), "{stem}");
        assert!(std::fs::read_to_string(&file).unwrap().contains("DERIVED"));
    }
}

/// Geometry C meets the constraints that it was searched with: it stands with loads equal within 15
/// %, and the front wheel has a reach of at least 0.18 m inside the stops, over which the loop
/// closes.
#[test]
fn geometry_c_meets_its_constraints() {
    let robot = parse("robot.geometry = 'C'").robot.robot;
    let loads = robot.static_loads().unwrap();
    let mean = robot.mean_wheel_load();
    for load in loads {
        assert!((load - mean).abs() < 0.075 * mean, "{loads:?}");
    }
    let geometry = &robot.geometry;
    let heights = (0..=75).map(|k| {
        let angle =
            geometry.stop.lower + (geometry.stop.upper - geometry.stop.lower) * f64::from(k) / 75.0;
        let posture = Posture::close(geometry, angle, 0.0).unwrap();
        let height = |wheel| posture.axle_from_q(geometry, wheel).y;
        height(0) - height(1)
    });
    let reach = heights.fold(0.0, f64::max);
    assert!(reach >= 0.18, "{reach}");
}

/// The names A, B, caption and text are read from the shipped files; they have the model's values
/// to a relative 1e-15.
#[test]
fn built_in_robots_are_those_of_the_model() {
    for (name, expected) in [("A", Geometry::a()), ("B", Geometry::b())] {
        let scene = parse(&format!("robot.geometry = '{name}'"));
        let found = scene.robot.robot.geometry;
        assert_eq!(found.carriers, expected.carriers, "{name}");
        let numbers = |g: &Geometry| {
            let points = [g.pins.p, g.pins.q, g.pins.r, g.pins.s, g.body_cg];
            let points = points.into_iter().chain(g.axles).chain(g.link_cg);
            let stop = [g.stop.lower, g.stop.upper, g.stop.stiffness, g.stop.damping];
            let scalars = stop.into_iter().chain([g.wheel_radius]);
            points
                .flat_map(|p| [p.x, p.y])
                .chain(scalars)
                .collect::<Vec<_>>()
        };
        assert_close(&numbers(&found), &numbers(&expected));
    }
    for (name, expected) in [("caption", MassSet::caption()), ("text", MassSet::text())] {
        let found = parse(&format!("robot.mass = '{name}'")).robot.robot.mass;
        let numbers = |m: &MassSet| {
            let arrays = m.links.into_iter().chain(m.link_inertias);
            let scalars = [
                m.body,
                m.wheel,
                m.body_inertia,
                m.wheel_inertia,
                m.rotor_inertia,
            ];
            arrays.chain(scalars).collect::<Vec<_>>()
        };
        assert_close(&numbers(&found), &numbers(&expected));
    }
}

fn assert_close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= 1e-15 * e.abs(), "{f} {e}");
    }
}

#[test]
fn an_empty_file_is_the_default_scene_and_smooth_is_that_scene() {
    assert_eq!(parse(""), Scene::default());
    let smooth = Scene::load(&top().join("scenes/smooth.toml"), &[]).unwrap();
    let default = Scene {
        name: "smooth".to_owned(),
        ..Scene::default()
    };
    assert_eq!(smooth, default);
}

#[test]
fn the_file_stem_names_the_scene_unless_the_file_does() {
    let name = |text: &str, file| {
        let scene = Scene::parse(text, file, Path::new(""), &[]);
        scene.unwrap().name
    };
    assert_eq!(name("", "a/b/Kerb 50mm.toml"), "kerb-50mm");
    assert_eq!(name("name = 'kerb_50'", "x.toml"), "kerb_50");
}

#[test]
fn paths_are_relative_to_the_scene_file() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::create_dir(dir.path().join("sub")).unwrap();
    let mass = std::fs::read_to_string(top().join("robots/mass-caption.toml")).unwrap();
    let heavier = mass.replace("body = 5.0", "body = '6000 g'");
    std::fs::write(dir.path().join("sub/heavy.toml"), heavier).unwrap();
    let scene = dir.path().join("x.toml");
    std::fs::write(&scene, "[robot]\nmass = 'sub/heavy.toml'").unwrap();
    let scene = Scene::load(&scene, &[]).unwrap();
    assert!((scene.robot.robot.mass.body - 6.0).abs() < 1e-15);
    assert_eq!(scene.robot.mass_name, "sub/heavy.toml");
}

#[test]
fn link_cgs_can_be_given() {
    let text = std::fs::read_to_string(top().join("robots/geometry-a.toml")).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let with = text.replace("# link_cg", "link_cg");
    assert_ne!(with, text);
    std::fs::write(dir.path().join("g.toml"), with).unwrap();
    let text = "robot.geometry = 'g.toml'";
    let scene = Scene::parse(text, "x.toml", dir.path(), &[]).unwrap();
    let found = scene.robot.robot.geometry.link_cg[0];
    assert!((found.x - 0.1333).abs() < 1e-15 && (found.y - 0.1533).abs() < 1e-15);
}

/// The comment in the shipped file has the values of the rule, to its four decimals.
#[test]
fn the_commented_link_cgs_are_the_mean_rule() {
    let [a, b, c] = Geometry::a().link_cg;
    let shown = [0.1333, 0.1533, -0.15, 0.125, -0.25, 0.21];
    for (found, shown) in [a.x, a.y, b.x, b.y, c.x, c.y].iter().zip(shown) {
        assert!((found - shown).abs() < 5e-5, "{found} {shown}");
    }
}
