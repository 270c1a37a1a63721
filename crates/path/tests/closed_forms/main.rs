//! Needed friction against closed forms.

// A test may panic.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod controls;

use robhaz_model::{Bar, GRAVITY, Robot};
use robhaz_path::{DriveKind, Options, PathError, PathReport, PathSetup, Place, Reason, judge};
use robhaz_scene::Scene;
use std::path::Path;

fn setup(text: &str, set: &[&str], options: Options) -> Result<PathSetup, PathError> {
    let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
    let scene = Scene::parse(text, "trial", Path::new(""), &set).unwrap();
    PathSetup::new(&scene, options)
}

fn judged(text: &str, set: &[&str], options: Options) -> PathReport {
    judge(&setup(text, set, options).unwrap()).unwrap()
}

/// A slope that starts at x = 0.7 m and goes on for 3 m.
fn ramp(degrees: f64) -> String {
    format!("[terrain]\nkind = \"ramp\"\nangle = \"{degrees} deg\"\nstart = 0.7\nlength = 3.0\n")
}

fn kerb(rise: f64) -> String {
    format!("[terrain]\nkind = \"step\"\nkerb = {rise}\nstart = 0.7\n")
}

/// The places at which all wheels are on the slope alone.
fn on_slope(report: &PathReport) -> Vec<&Place> {
    let is_on = |p: &&Place| p.wheel_x[2] > 1.0 && p.wheel_x[0] < 2.1;
    let found: Vec<_> = report.places.iter().filter(is_on).collect();
    assert!(found.len() > 20, "{}", found.len());
    found
}

/// Options with a friction coefficient.
fn with_mu(mu: f64) -> Options {
    Options {
        mu: Some(mu),
        ..Options::default()
    }
}

fn driven(drive: DriveKind, mu: f64) -> Options {
    Options {
        drive,
        ..with_mu(mu)
    }
}

/// Closed form: on a uniform slope mu_n = tan(slope) for any robot, since the ground's force must
/// be vertical as a whole. 1e-8: the accuracy of the curve of the centres, and that of the linear
/// programs, 1e-7 N over a load of 44 N.
#[test]
fn a_uniform_slope_needs_its_tangent() {
    for (geometry, degrees) in [("A", 5.0_f64), ("A", 25.0), ("A", -10.0), ("B", 15.0)] {
        let set = format!("robot.geometry={geometry}");
        let report = judged(&ramp(degrees), &[&set], with_mu(0.8));
        for place in on_slope(&report) {
            let needed = place.needed_mu.unwrap();
            let expected = degrees.to_radians().tan().abs();
            assert!((needed - expected).abs() < 1e-8, "{degrees}: {needed}");
            assert!((place.margin.unwrap() - (0.8 - expected)).abs() < 1e-8);
        }
    }
}

/// Closed form: level ground needs no friction, whatever the drive. 1e-8: tolerance of the linear
/// programs over a load of 44 N.
#[test]
fn level_ground_needs_none() {
    for drive in DriveKind::ALL {
        let options = Options {
            distance: Some(0.5),
            drive,
            ..Options::default()
        };
        let report = judged("[terrain]\nkind = \"flat\"\n", &[], options);
        assert!(report.go && report.probability >= 1.0);
        assert!(report.needed_mu.unwrap().abs() < 1e-8, "{report:?}");
        assert!(report.places.last().unwrap().x() >= 0.5);
    }
}

/// Closed form: the front wheel of robot A against the edge of a kerb, the others on the level.
///
/// The edge is at the contact angle g, cos g = (r - h)/r. The best tractions use the same share m
/// of N at all wheels. The forces in x and y give `m W = N1 sin g (1 + m^2)`. The moments of link 1
/// about Q, from which the axle is at (a, b), give
/// `N1 (a cos g + b sin g + m (a sin g - b cos g + r)) = a N1_level`. With N1 eliminated a
/// quadratic equation in m is left.
#[test]
fn a_kerb_under_the_front_wheel() {
    let robot = Robot::default_a();
    let g = &robot.geometry;
    let (radius, axle) = (g.wheel_radius, g.axles[0] - g.pins.q);
    let (a, b) = (axle.x, axle.y);
    let weight = robot.mass.total() * GRAVITY;
    let level = Options {
        distance: Some(0.01),
        ..Options::default()
    };
    let at_rest = judged("[terrain]\nkind = \"flat\"\n", &[], level);
    let n1_level = at_rest.places[0].normal_force.unwrap()[0];
    assert!((n1_level - 43.58).abs() < 0.006, "{n1_level}");
    for height in [0.02, 0.05, 0.07] {
        let cos = (radius - height) / radius;
        let sin = (1.0 - cos * cos).sqrt();
        let square = weight * (a * sin - b * cos + radius) - a * n1_level * sin;
        let linear = weight * (a * cos + b * sin);
        let constant = -a * n1_level * sin;
        let root = (linear * linear - 4.0 * square * constant).sqrt();
        let expected = (root - linear) / (2.0 * square);
        let report = judged(&kerb(height), &[], Options::default());
        // The place at which the wheel is on the edge alone is the one after that with both
        // contacts.
        let two = |p: &Place| p.contacts[0] == 2;
        let both = report.places.iter().position(two).unwrap();
        let behind = &report.places[both..];
        let place = behind.iter().find(|p| !two(p)).unwrap();
        assert_eq!(place.contacts, [1; 3]);
        let needed = place.needed_mu.unwrap();
        // The kink is found within 1e-10 m, and the angle changes by 10 rad/m there.
        assert!(
            (needed - expected).abs() < 1e-7,
            "{height}: {needed} {expected}"
        );
        // With both contacts less friction is needed, and none before: the tread carries the load.
        let with_both = report.places[both].needed_mu.unwrap();
        // The search of the linear programs is coarse where a contact carries next to nothing.
        assert!(with_both < 1e-4, "{height}: {with_both}");
    }
}

/// Closed form: on a uniform slope the robot tips backwards where its centre of mass is above the
/// rear contact. Tractions along the slope have no moment about that contact.
#[test]
fn a_steep_slope_tips_the_robot_at_the_exact_angle() {
    let robot = Robot::default_a();
    let (g, m) = (&robot.geometry, &robot.mass);
    let bars = Bar::ALL.iter().map(|bar| (m.of(*bar).0, g.cg(*bar)));
    let parts = bars.chain(g.axles.iter().map(|axle| (m.wheel, *axle)));
    let centre = parts
        .map(|(mass, at)| at * (mass / m.total()))
        .sum::<robhaz_model::Vec2>();
    let angle = ((centre.x - g.axles[2].x) / centre.y).atan().to_degrees();
    for (offset, tips) in [(-0.02, false), (0.02, true)] {
        // Enough friction and torque, so that nothing else fails.
        let report = judged(
            &ramp(angle + offset),
            &["drive.torque_limit=100"],
            with_mu(5.0),
        );
        for place in on_slope(&report) {
            let found = place.failure.filter(|f| f.reason == Reason::Tipping);
            assert_eq!(found.is_some(), tips, "{:?}", place.failure);
            assert!(
                found.is_none_or(|f| f.by.is_some_and(|by| by > 0.0 && by < 1.0)),
                "{found:?}"
            );
        }
        assert!(!tips || report.probability == 0.0);
    }
}

/// Closed form: on a slope the three tractions sum up to W sin(slope). A torque limit below a third
/// of that fails, by the difference; one above it passes.
#[test]
fn the_torque_limit_bounds_the_slope() {
    let robot = Robot::default_a();
    let third = robot.mass.total() * GRAVITY * 20.0_f64.to_radians().sin() / 3.0 * 0.1;
    let judged_with = |limit: f64| {
        let set = format!("drive.torque_limit={limit}");
        judged(&ramp(20.0), &[&set], with_mu(2.0))
    };
    // What no friction mends has no margin.
    let short = judged_with(third - 0.01);
    assert!(short.margin.is_none() && short.margin_x.is_none() && short.probability == 0.0);
    for place in on_slope(&short) {
        let failure = place.failure.unwrap();
        assert_eq!(failure.reason, Reason::Torque);
        // Tolerance of the linear programs: 1e-7 N.
        assert!((failure.by.unwrap() - 0.01).abs() < 1e-6, "{failure:?}");
    }
    for place in on_slope(&judged_with(third + 0.01)) {
        assert_eq!(place.failure, None);
        let most = place.traction.unwrap().into_iter().fold(0.0, f64::max);
        assert!(most * 0.1 <= third + 0.01 + 1e-7);
        // Nearly equal tractions need more friction than the best ones.
        assert!(place.needed_mu.unwrap() > 20.0_f64.to_radians().tan() + 0.01);
    }
    // The friction of the gear is added to that.
    let limit = format!("drive.torque_limit={}", third + 0.49);
    for drive in DriveKind::ALL {
        let options = Options {
            drive,
            ..with_mu(2.0)
        };
        let set = [&limit, "drive.gear_friction=0.5"];
        let failure = judged(&ramp(20.0), &set, options).first_failure.unwrap();
        assert_eq!(failure.reason, Reason::Torque, "{drive:?}");
        let free = judged(&ramp(20.0), &[&limit], options);
        assert!(free.go, "{drive:?}: {:?}", free.first_failure);
    }
    let report = judged(
        &ramp(20.0),
        &[&limit, "drive.gear_friction=0.5"],
        with_mu(2.0),
    );
    for place in on_slope(&report) {
        assert!((place.failure.unwrap().by.unwrap() - 0.01).abs() < 1e-6);
    }
}

/// Closed form: on a slope with a torque limit the robot goes as fast as viscous damping lets it,
/// omega = (limit - r W sin(slope)/3)/B. 2 %: the slope is 3 m long.
#[test]
fn damping_slows_a_robot_down_at_its_torque_limit() {
    let third = Robot::default_a().mass.total() * GRAVITY * 15.0_f64.to_radians().sin() / 3.0 * 0.1;
    let expected = 0.1 * (1.4 - third) / 0.5;
    let set = ["drive.torque_limit=1.4", "drive.viscous_damping=0.5"];
    for drive in [DriveKind::Shared, DriveKind::Speed] {
        let report = judged(&ramp(15.0), &set, driven(drive, 0.8));
        assert!(report.go);
        for place in on_slope(&report).iter().rev().take(20) {
            let speed = place.speed.unwrap();
            assert!((speed / expected - 1.0).abs() < 0.02, "{speed} {expected}");
        }
    }
}

/// Closed form: a stretch with its own friction coefficient has its own margin. Property: at its
/// ends, where wheels have different coefficients, the margin lies between.
#[test]
fn a_stretch_has_its_own_margin() {
    let text = ramp(15.0) + "[[terrain.stretch]]\nfrom = 1.5\nto = 9.0\nmu_s = 0.4\nmu_d = 0.3\n";
    let report = judged(&text, &[], Options::default());
    let tan = 15.0_f64.to_radians().tan();
    let mut mixed = 0;
    for place in on_slope(&report) {
        let margin = place.margin.unwrap();
        if place.wheel_x[0] < 1.45 {
            assert!((margin - (0.8 - tan)).abs() < 1e-9);
        } else if place.wheel_x[2] > 1.55 {
            assert!((margin - (0.4 - tan)).abs() < 1e-9);
        } else if place.wheel_x[0] > 1.55 && place.wheel_x[2] < 1.45 {
            assert!(
                margin > 0.4 - tan + 0.01 && margin < 0.8 - tan - 0.01,
                "{margin}"
            );
            assert!((place.needed_mu.unwrap() - tan).abs() < 1e-9);
            mixed += 1;
        }
    }
    assert!(mixed > 10, "{mixed}");
}

/// Closed form: a mean that is given holds outside the friction stretches. Ice of 0.05 on a slope
/// of 15 deg, whose tangent is 0.27, stays no-go whatever friction is given, and the text names the
/// ice.
#[test]
fn a_given_mean_leaves_the_ice() {
    let ice = "[[terrain.stretch]]\nfrom = 1.5\nto = 9.0\nmu_s = 0.05\nmu_d = 0.05\n";
    let report = judged(&(ramp(15.0) + ice), &[], with_mu(0.5));
    assert!(!report.go);
    let tan = 15.0_f64.to_radians().tan();
    for place in on_slope(&report) {
        let expected = match place.wheel_x {
            [front, ..] if front < 1.45 => 0.5,
            [.., rear] if rear > 1.55 => 0.05,
            _ => continue,
        };
        // As in `a_uniform_slope_needs_its_tangent`.
        assert!((place.margin.unwrap() - (expected - tan)).abs() < 1e-8);
    }
    let text = report.text();
    let said = "Available friction: 0.5; the friction stretches of the scene keep their own: 0.05 from x = 1.500 to 9.000 m";
    assert!(text.contains(said), "{text}");
    let without = judged(&ramp(15.0), &[], with_mu(0.5)).text();
    assert!(!without.contains("stretches"), "{without}");
}

/// Closed form: stairs that are longer than the robot need at every step what one step needs; 30
/// of them climb 0.3 m. 1e-6: the accuracy of the place of a kink, 1e-10 m, over the 1 mm by which
/// the contacts of a kerb of 10 mm change from place to place.
#[test]
fn long_stairs_need_at_every_step_the_same() {
    let stairs = |count: u32| {
        let text = format!(
            "[terrain]\nkind = \"stairs\"\nrise = 0.01\nrun = 0.7\ncount = {count}\nstart = 0.7\n"
        );
        judged(&text, &[], Options::default())
    };
    let (one, many) = (stairs(1), stairs(30));
    assert!(many.go, "{:?}", many.first_failure);
    let last = many.places.last().unwrap();
    // Level behind the last step: the centre of the front wheel is a radius above it.
    assert!((last.wheel_y[0] - 0.4).abs() < 1e-9, "{last:?}");
    let (a, b) = (one.needed_mu.unwrap(), many.needed_mu.unwrap());
    assert!((a - b).abs() < 1e-6, "{a} {b}");
}

/// Closed form: level ground needs no friction, so ice takes none of the margin, and with any
/// deviation of the coefficients the robot passes; the ice under one wheel or under all.
#[test]
fn ice_on_level_ground_takes_no_margin() {
    for (mu, to) in [(0.02, 0.6), (0.0, 0.6), (0.02, 3.0)] {
        let set = format!("terrain.stretch=[{{from=0.5,to={to},mu_s={mu},mu_d={mu}}}]");
        for drive in DriveKind::ALL {
            let options = Options {
                distance: Some(1.0),
                mu_sigma: 0.05,
                drive,
                ..Options::default()
            };
            let report = judged("[terrain]\nkind = \"flat\"\n", &[&set], options);
            assert!(report.go, "{drive:?} {mu}: {:?}", report.first_failure);
            assert!(
                (report.margin.unwrap() - 0.8).abs() < 1e-9,
                "{drive:?} {mu}"
            );
            assert!(report.probability > 0.9999, "{drive:?} {mu}");
        }
    }
}

/// Closed form: of a wheel on ice, mu = 0, the others hold a slope. On 5 deg the ice of 0.25 m takes
/// from the margin what the load of its wheel is: at most a half (the middle wheel bears 48 of 137
/// N), so that it is far above the margin 0 of the ice itself. A wheel needs more than the tangent.
#[test]
fn the_other_wheels_hold_one_on_ice() {
    let ice = "[[terrain.stretch]]\nfrom = 1.5\nto = 1.6\nmu_s = 0.0\nmu_d = 0.0\n";
    let tan = 5.0_f64.to_radians().tan();
    let report = judged(&(ramp(5.0) + ice), &[], Options::default());
    let mut on_ice = 0;
    for place in on_slope(&report) {
        let margin = place.margin.unwrap();
        let contact = |x: &f64| x + 0.1 * 5.0_f64.to_radians().sin();
        if place
            .wheel_x
            .iter()
            .map(contact)
            .any(|x| (1.5..1.6).contains(&x))
        {
            assert!(
                margin < 0.8 - 1.2 * tan && margin > 0.8 - 2.0 * tan,
                "{margin}"
            );
            on_ice += 1;
        } else {
            assert!((margin - (0.8 - tan)).abs() < 1e-8, "{margin}");
        }
    }
    assert!(on_ice > 20, "{on_ice}");
}

/// Property: more friction never turns go into no-go; the step is at the needed friction.
/// Probability: one half at the needed friction, 0.8413 one standard deviation above.
#[test]
fn go_is_monotone_in_mu() {
    let needed = judged(&kerb(0.05), &[], Options::default())
        .needed_mu
        .unwrap();
    for (factor, go) in [(0.5, false), (0.999, false), (1.001, true), (2.0, true)] {
        assert_eq!(
            judged(&kerb(0.05), &[], with_mu(factor * needed)).go,
            go,
            "{factor}"
        );
    }
    for (mu, probability) in [(needed, 0.5), (needed + 0.1, 0.8413)] {
        let options = Options {
            mu_sigma: 0.1,
            ..with_mu(mu)
        };
        let found = judged(&kerb(0.05), &[], options).probability;
        assert!((found - probability).abs() < 1e-4, "{found}");
    }
}

/// A crest as sharp as the end stop allows no further: pin Q would be beyond its stop.
#[test]
fn a_sharp_crest_meets_the_end_stop() {
    let text = "[terrain]\nkind = \"cosbump\"\n";
    let free = judged(text, &[], with_mu(5.0));
    let largest = free
        .places
        .iter()
        .map(|p| p.opening)
        .fold(f64::NEG_INFINITY, f64::max);
    let mut narrow = setup(text, &[], with_mu(5.0)).unwrap();
    narrow.scene.robot.robot.geometry.stop.upper = largest - 0.01;
    let report = judge(&narrow).unwrap();
    let failure = report.first_failure.unwrap();
    assert_eq!(failure.reason, Reason::EndStop);
    assert!(failure.by.unwrap() > 0.0 && failure.by.unwrap() <= 0.01 && !report.go);
}

/// Bad options are refused.
#[test]
fn bad_options_are_refused() {
    let refused = |found: Result<PathSetup, PathError>, words: &str| {
        let text = found.err().unwrap().to_string();
        assert!(text.contains(words), "{text}");
    };
    let refuse = |text: &str, options, words: &str| refused(setup(text, &[], options), words);
    refuse("", with_mu(10.5), "(--mu) is 10.5;");
    refuse("", with_mu(-0.3), "(--mu) is -0.3;");
    refuse("", with_mu(f64::NAN), "(--mu) is NaN;");
    let sigma = Options {
        mu_sigma: -1.0,
        ..Options::default()
    };
    refuse("", sigma, "(--mu-sigma) is -1;");
    let distance = Options {
        distance: Some(0.0),
        ..Options::default()
    };
    refuse("", distance, "(--distance) is 0 m;");
    let flat = "[terrain]\nkind = \"flat\"\n";
    refuse(flat, Options::default(), "no path ahead");
    // 0.15 N m s and 10 N m: 66.7 rad/s on wheels of 0.1 m.
    let fast = "[drive]\nspeed = 7\n";
    refuse(fast, driven(DriveKind::Speed, 0.8), "below 6.6667 m/s");
    let still = setup(
        &kerb(0.05),
        &["drive.speed=0"],
        driven(DriveKind::Shared, 0.8),
    );
    refused(still, "drive.speed is 0 m/s;");
    let behind = "[terrain]\nkind = \"step\"\nkerb = 0.05\nstart = -2.0\n";
    refuse(behind, Options::default(), "no path ahead");
    // Ground that is longer than a path names no option that was not given; a given distance judges
    // its start.
    let long = "[terrain]\nkind = \"rough\"\nclass = \"B\"\nextent = 1000\n";
    refuse(long, Options::default(), "at most 1000 m: --distance D");
    // The middle wheel starts inside a deep trench.
    let trench = "[terrain]\nkind = \"ditch\"\nstart = -0.25\nwidth = 0.5\ndepth = 2.0\n";
    let found = judge(&setup(trench, &[], Options::default()).unwrap());
    assert!(found.is_err(), "{:?}", found.unwrap().places[0]);
}

/// By hand: on level ground no wheel slides, even without friction, and every drive says go. On a
/// slope a friction coefficient that is 5e-5 too small is not "above by 0.000".
#[test]
fn limiting_cases_are_in_words() {
    let level = "[terrain]\nkind = \"flat\"\n";
    for drive in [DriveKind::Ideal, DriveKind::Shared, DriveKind::Speed] {
        let options = Options {
            distance: Some(0.5),
            ..driven(drive, 0.0)
        };
        let report = judged(level, &[], options);
        let text = report.text();
        assert!(report.go && !text.contains("slides"), "{drive:?}: {text}");
    }
    let mu = 15.0_f64.to_radians().tan() - 5e-5;
    let text = judged(&ramp(15.0), &[], with_mu(mu)).text();
    assert!(text.contains("by less than 0.001"), "{text}");
}

/// A scene that drives back is no path forward: no drive judges it.
#[test]
fn a_path_back_is_refused() {
    for drive in [DriveKind::Ideal, DriveKind::Shared, DriveKind::Speed] {
        let found = setup(&kerb(0.05), &["drive.speed=-0.2"], driven(drive, 0.8));
        let message = found.err().map(|e| e.to_string()).unwrap_or_default();
        assert!(message.contains("judged forward"), "{drive:?}: {message}");
    }
}
