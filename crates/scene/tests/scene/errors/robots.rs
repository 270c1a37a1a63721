//! Errors of robots: parts, geometry, standing.

use super::{lines, one};
use robhaz_model::{Carrier, Suspension};
use robhaz_scene::Scene;
use std::path::Path;

/// The nominal robot is checked like the simulated one.
#[test]
fn an_invalid_nominal_robot_is_refused() {
    let with = |seed: u32| lines(&format!("seed = {seed}\n[model_error]\nlink_masses = 1"));
    // Each of three masses is negative in 16 % of the draws.
    let found = (0..20).map(with).find(|found| !found.is_empty());
    let found = found.expect("a seed that draws a negative mass");
    let expected = "the nominal masses that [model_error] draws are not valid: links[";
    assert!(
        found[0].starts_with("x.toml:2: model_error: with seed ") && found[0].contains(expected),
        "{found:?}"
    );
}

/// A robot that cannot stand is refused with the real reason, at its key, with the allowed values.
#[test]
fn robots_that_cannot_stand() {
    let found = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
        let error = Scene::parse("", "x.toml", Path::new(""), &sets)
            .expect_err("a robot that cannot stand");
        let lines: Vec<String> = error.problems.iter().map(ToString::to_string).collect();
        assert_eq!(lines.len(), 1, "{lines:?}");
        lines[0].clone()
    };
    for (set, expected) in [
        (
            "robot.geometry.axles=[[0.15, 0.1], [0, 0.1], [-0.3, 0.1]]",
            "robot.geometry.axles: the front and the middle wheel overlap: their axles are 0.1500 m apart; allowed: at least twice \
             the wheel radius, 0.2000 m",
        ),
        (
            "robot.geometry.pins.q=[-0.05, -0.02]",
            "robot.geometry.pins.q: pin Q is not above the ground: its y is -0.02 m; allowed: above 0, where the wheels stand",
        ),
        (
            "robot.geometry.body_cg=[0.03, -0.1]",
            "robot.geometry.body_cg: the centre of mass of body is not above the ground: its y is -0.1 m; allowed: above 0",
        ),
        (
            "robot.geometry.body_cg=[1.0, 0.3]",
            "robot.geometry.body_cg: the robot tips forward: its centre of mass is 42 mm ahead of the front wheel (axle at \
             x = 0.3 m); allowed: between the axles of the rear and the front wheel",
        ),
        (
            "robot.geometry.body_cg=[-0.9, 0.3]",
            "robot.geometry.body_cg: the robot tips backward: its centre of mass is",
        ),
        (
            "robot.geometry.body_cg=[0.6, 0.3]",
            "robot.geometry.body_cg: the linkage folds: on level ground the static normal force of the",
        ),
    ] {
        let line = found(&[set]);
        println!("{line}");
        assert!(
            line.starts_with(&format!("--set {set}: {expected}")),
            "{line}"
        );
    }
    // In a file: its name and line.
    let dir = tempfile::tempdir().expect("a folder");
    let text = include_str!("../../../../../robots/geometry-a.toml")
        .replace("[0.03, 0.30]", "[1.0, 0.30]");
    std::fs::write(dir.path().join("front.toml"), &text).expect("written");
    let error = Scene::parse("robot.geometry = 'front.toml'", "x.toml", dir.path(), &[]);
    let line = error.expect_err("a robot that cannot stand").to_string();
    let number = 1 + text
        .lines()
        .position(|l| l.starts_with("body_cg"))
        .expect("the key");
    let place = format!("front.toml:{number}: body_cg: the robot tips forward");
    assert!(line.contains(&place), "{line}");
}

#[test]
fn robots() {
    one(
        "robot.geometry = 'a'",
        "x.toml:1: robot.geometry: found 'a', allowed: \"A\", \"B\", \"C\", the path of a geometry file ending in .toml, \
         or a table with the keys of such a file; did you mean \"A\"?",
    );
    let found = lines("[robot]\nmass = 'no/such.toml'");
    assert!(found[0].starts_with(
        "x.toml:2: robot.mass: found 'no/such.toml', but no/such.toml cannot be read: "
    ));
    assert!(found[0].contains("; allowed: \"caption\", \"text\", the path of a mass file"));
    let found = lines("[robot.mass]\nbody = 0\nlinks = [1]\nwheel = 1");
    assert!(found.iter().any(|l| l.starts_with("x.toml:2: robot.mass.body: found 0, allowed: a number above 0")));
    assert!(found.iter().any(|l| l.starts_with(
        "x.toml:3: robot.mass.links: found [1] (an array), allowed: [a, b, c], of a bogie [a, b], each"
    )));
    assert!(
        found
            .iter()
            .any(|l| l.starts_with("x.toml:1: robot.mass.rotor_inertia: missing"))
    );
    assert_eq!(found.len(), 6);
}

/// A bogie has a body on one of its links, one pin, two links.
#[test]
fn bogies() {
    let geometry = "[robot.geometry]\nwheel_radius = 0.1\naxles = [[0.3, 0.1], [0, 0.1], [-0.3, 0.1]]\n\
        carriers = [\"link1\", \"link2\", \"link2\"]\nbody_cg = [0.05, 0.3]\n";
    let masses = "[robot.mass]\nbody = 6\nlinks = [1, 1]\nwheel = 1\nbody_inertia = 0.1\nlink_inertias = [0.1, 0.1]\n\
        wheel_inertia = 0.01\nrotor_inertia = 0.1\n";
    let pins = "[robot.geometry.pins]\nq = [-0.15, 0.2]\n";
    let bogie = "[robot.geometry.suspension]\nkind = \"bogie\"\nbody = \"link1\"\n";
    let whole = [geometry, pins, bogie, masses].concat();
    let good = Scene::parse(&whole, "x.toml", Path::new("."), &[]).expect("a bogie");
    let suspension = good.robot.robot.geometry.suspension;
    assert_eq!(
        suspension,
        Suspension::Bogie {
            body: Carrier::Link1
        }
    );
    // The resolved scene is the same robot.
    let again = Scene::parse(&good.to_toml("x"), "y.toml", Path::new("."), &[]).expect("resolved");
    assert_eq!(again.robot.robot, good.robot.robot);
    for (from, to, expected) in [
        (
            "body = \"link1\"\n",
            "",
            "x.toml:8: robot.geometry.suspension: ",
        ),
        (
            "body = \"link1\"",
            "body = \"link4\"",
            "x.toml:10: robot.geometry.suspension.body: found \"link4\"",
        ),
        (
            "kind = \"bogie\"\n",
            "",
            "x.toml:9: robot.geometry.suspension.body: found \"link1\", but only the body of",
        ),
        (
            "q = [-0.15, 0.2]",
            "q = [-0.15, 0.2]\np = [0, 0.2]",
            "x.toml:8: robot.geometry.pins.p: found [0, 0.2]",
        ),
        (
            "links = [1, 1]",
            "links = [1, 1, 1]",
            "x.toml:16: robot.mass.link_inertias: ",
        ),
        (
            "kind = \"bogie\"\nbody = \"link1\"",
            "kind = \"four-bar\"",
            "x.toml:6: robot.geometry.pins: ",
        ),
        (
            "body_cg = [0.05, 0.3]",
            "body_cg = [0.05, 0.3]\nlink_cg = [[0, 0.1], [0, 0.1], [0, 0.1]]",
            "x.toml:6: robot.geometry.link_cg: ",
        ),
        (
            masses,
            "",
            "masses are those of 3 links, but a robot with suspension.kind = \"bogie\" has 2",
        ),
    ] {
        let found = lines(&whole.replace(from, to));
        let line = &found[0];
        assert!(
            line.starts_with(expected) || line.ends_with(expected),
            "{found:#?}"
        );
    }
}

/// Problems that `Geometry::check` finds are reported at their line in the robot's file.
#[test]
fn impossible_geometries() {
    let good = include_str!("../../../../../robots/geometry-a.toml");
    let dir = tempfile::tempdir().unwrap();
    let check = |from: &str, to: &str, key: &str, message: &str| {
        let text = good.replace(from, to);
        assert_ne!(text, good);
        let line = 1 + text[..text.find(to).unwrap()].matches('\n').count();
        std::fs::write(dir.path().join("bad.toml"), text).unwrap();
        let scene = Scene::parse("robot.geometry = 'bad.toml'", "x.toml", dir.path(), &[]);
        let found = scene.unwrap_err().to_string();
        let start = format!("{}:{line}: {key}: ", dir.path().join("bad.toml").display());
        assert!(found.starts_with(&start), "{found}");
        assert!(found.contains(message), "{found}");
    };
    check(
        "p = [0.15, 0.22]",
        "p = [-0.25, 0.2]",
        "pins.p",
        "pin P lies on the line",
    );
    check(
        "\"link2\", \"link2\"]",
        "\"link1\", \"link1\"]",
        "carriers",
        "link2 carries no wheel",
    );
    check(
        "[0.0, 0.10], [-0.30",
        "[-0.3, 0.10], [-0.30",
        "axles",
        "front, middle, rear",
    );
    check(
        "wheel_radius = 0.10",
        "axes = 3\nwheel_radius = 0.10",
        "axes",
        "did you mean axles?",
    );
    check(
        "\"35 deg\"",
        "\"-35 deg\"",
        "stop.upper",
        "allowed: a number above 0",
    );
    check(
        "[0.0, 0.10], [-0.30, 0.10]]",
        "[0.0, 0.10], [-0.30, 0.11]]",
        "axles",
        "stand on y = 0",
    );
}
