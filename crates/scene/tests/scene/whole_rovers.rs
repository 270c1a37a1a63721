//! Rovers with both sides: what lies across, and steering hardware.
#![allow(
    clippy::expect_used,
    reason = "helpers of tests may stop at the first surprise"
)]

use robhaz_model::{Coupling, Vec2, WholeRover};
use robhaz_scene::{RobotChoice, Scene};
use std::path::Path;

/// A six-wheeled rover of which four wheels steer (github.com/mgonzs13/ros2_rover): masses of
/// 0.25 kg but for the body, wheels of 0.06 m.
const ROVER: &str = r#"
[robot.geometry]
wheel_radius = 0.06
axles = [[0.2863, 0.06], [0, 0.06], [-0.2553, 0.06]]
carriers = ["link1", "link2", "link2"]
body_cg = [0.0037, 0.2075]
link_cg = [[0.0747, 0.2193], [-0.1063, 0.1573]]
steering_height = 0.1914
suspension = { kind = "bogie", body = "link1" }
pins = { q = [-0.1063, 0.1573] }
stop = { lower = -0.785, upper = 0.785 }
[robot.mass]
body = 0.5
links = [0.25, 0.25]
wheel = 0.25
steering = [0.25, 0, 0.25]
body_inertia = 0.0081
link_inertias = [0.0135, 0.0108]
wheel_inertia = 0.00045
rotor_inertia = 0.0005
"#;
const ACROSS: &str = r#"
[robot.across]
coupling = "differential"
pivot = [0.0037, 0.2075]
half_tracks = [0.2, 0.25, 0.21]
"#;

fn parse(text: &str) -> Result<Scene, String> {
    let scene = Scene::parse(text, "x.toml", Path::new("."), &[]);
    scene.map_err(|error| error.to_string())
}

fn shipped(name: &str) -> Scene {
    let file = format!("{}/../../robots/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    Scene::load(Path::new(&file), &[]).expect("a rover of robots/")
}

/// Closed form: moments about Q of bogie and rocker give N at rest. Spread over all wheels, the
/// steering makes N wrong by -11, 24 and -10 %; over its wheels, by nothing. Tolerance: positions
/// are rounded to 0.1 mm, N to 5 mN.
#[test]
fn steering_belongs_to_the_links() {
    let loads = |text: &str| {
        let robot = parse(text).expect("a rover").robot.robot;
        robot.static_loads().expect("determined")
    };
    let spread = ROVER
        .replace("steering = [0.25, 0, 0.25]\n", "")
        .replace("wheel = 0.25", "wheel = 0.4167");
    let (right, averaged) = (loads(ROVER), loads(&spread));
    for (k, (expected, error)) in [(7.41_f64, -11.0_f64), (6.72, 24.0), (7.95, -10.0)]
        .into_iter()
        .enumerate()
    {
        assert!((right[k] - expected).abs() < 0.005, "{right:?}");
        let found = 100.0 * (averaged[k] / right[k] - 1.0);
        assert!((found - error).abs() < 0.5, "{found}");
    }
    // Above its axle, it turns with the link: inertia by the parallel axis theorem.
    let robot = parse(ROVER).expect("a rover").robot.robot;
    let apart = Vec2::new(0.2863 - 0.0747, 0.1914 - 0.2193);
    let inertia = 0.0135 + 0.125 * apart.norm_squared();
    assert!((robot.mass.link_inertias[0] - inertia).abs() < 1e-15);
    assert!((robot.geometry.link_cg[0] - Vec2::new(0.1805, 0.20535)).norm() < 1e-12);
}

/// Closed forms of what a file need not state: mean tracks, a box, rods, a disc.
#[test]
fn what_lies_across_has_defaults() {
    let scene = parse(&[ROVER, ACROSS].concat()).expect("a rover");
    let found = scene.robot.whole_rover().expect("both sides");
    let side = scene.robot.robot.clone();
    let outline = side.geometry.outline;
    let sizes = outline.body_upper - outline.body_lower;
    let box_of = |length: f64| (length.powi(2) + 0.4_f64.powi(2)) / 12.0;
    let [yaw1, yaw2, _] = side.mass.link_inertias;
    let expected = WholeRover {
        side,
        coupling: Coupling::Differential,
        pivot: Vec2::new(0.0037, 0.2075),
        half_tracks: [0.2, 0.25, 0.21],
        link_places: [0.2, 0.23],
        body_place: 0.0,
        coupling_stop: WholeRover::NO_STOP,
        body_inertia: [box_of(sizes.y), box_of(sizes.x)],
        link_inertias: [[0.0, yaw1], [0.0, yaw2]],
        wheel_inertia: 0.000225,
    };
    let close = |a: f64, b: f64| (a - b).abs() < 1e-15;
    for k in 0..2 {
        assert!(close(found.link_places[k], expected.link_places[k]));
        assert!(close(found.body_inertia[k], expected.body_inertia[k]));
    }
    let (link_places, body_inertia) = (expected.link_places, expected.body_inertia);
    let found = WholeRover {
        link_places,
        body_inertia,
        ..found
    };
    assert_eq!(found, expected);
    assert!(
        parse(ROVER)
            .expect("one side")
            .robot
            .whole_rover()
            .is_none()
    );
}

/// Every shipped rover says what lies across, and comes back from its resolved scene.
#[test]
fn shipped_rovers_have_both_sides() {
    for name in ["open-source-rover", "exomy", "curiosity", "sojourner"] {
        let scene = shipped(name);
        let rover = scene.robot.whole_rover().expect("both sides");
        assert_eq!(rover.check(), Ok(()));
        let triple = name == "exomy";
        assert_eq!(rover.coupling == Coupling::RearBogie, triple, "{name}");
        let again = parse(&scene.to_toml("robhaz 0.1.0")).expect("a resolved scene");
        assert_eq!(again.robot, scene.robot, "{name}");
        let weighed = scene.robot.weighed(scene.robot.robot.clone());
        assert_eq!(weighed.whole_rover(), Some(rover), "{name}");
    }
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/exomy.toml");
    let robot = RobotChoice::load(Path::new(file)).expect("a robot");
    assert_eq!(robot.whole_rover(), shipped("exomy").robot.whole_rover());
}

/// What cannot be is refused at its key.
#[test]
fn faults_across_are_refused() {
    let line = |text: &str, key: &str| {
        let lines: Vec<&str> = text.lines().collect();
        1 + lines
            .iter()
            .rposition(|l| l.starts_with(key))
            .expect("the key")
    };
    for (from, to, key, expected) in [
        (
            "coupling = \"differential\"",
            "coupling = \"gear\"",
            "coupling",
            "found \"gear\", allowed: \"differential\", \"rear-bogie\"",
        ),
        (
            "half_tracks = [0.2, 0.25, 0.21]",
            "half_tracks = [0.2, 0, 0.21]",
            "half_tracks",
            "found 0, allowed: a number above 0",
        ),
        (
            "pivot = [0.0037, 0.2075]\n",
            "body_place = 0.2\npivot = [0.0037, 0.2075]\n",
            "body_place",
            "found 0.2, but the rover tips sideways, with a wheel at 0.2 m from the middle; allowed: nearer",
        ),
        (
            "pivot = [0.0037, 0.2075]\n",
            "body_inertia = [81, 0.01]\npivot = [0.0037, 0.2075]\n",
            "body_inertia",
            "found [81, 0.01], but 81 kg m^2 is beyond",
        ),
        (
            "pivot = [0.0037, 0.2075]\n",
            "",
            "[robot.across]",
            "missing, and it has no default; allowed: [x, y]",
        ),
    ] {
        let text = [ROVER, &ACROSS.replace(from, to)].concat();
        let error = parse(&text).expect_err("a fault");
        let place = format!("x.toml:{}: robot.across.", line(&text, key));
        assert!(
            error.starts_with(&place) && error.contains(expected),
            "{error}"
        );
    }
    let error = parse(ACROSS).expect_err("a four-bar");
    let expected = "x.toml:3: robot.across.coupling: found \"differential\", but the robot is a four-bar: how two of them share the body's moment";
    assert!(error.starts_with(expected), "{error}");
}
