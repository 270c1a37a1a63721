//! Faults of an inertial sensor in the body and of the angle of pin Q, at the rates that rovers
//! have: each is found under the name of its reading, and honest readings have none.

use super::common::faults::normal;
use super::common::{Failure, checked};
use rayon::prelude::*;
use robhaz_estimator::SensorFrame;
use robhaz_log::check::{Report, Verdict};
use robhaz_model::{BodyMount, BodyReading, Carrier, Geometry, Suspension};
use robhaz_run::DrivenPlant;
use robhaz_scene::Scene;
use std::f64::consts::PI;
use std::path::Path;

/// A drive of a rover with its own sensors, and what the sensors of its body have read.
struct Drive {
    scene: Scene,
    frames: Vec<SensorFrame>,
    body: Vec<BodyReading>,
}

impl Drive {
    fn of(rover: &str) -> Result<Self, Failure> {
        Self::with(rover, &[])
    }

    /// The same with other keys.
    fn with(rover: &str, keys: &[&str]) -> Result<Self, Failure> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
        let keys = ["engine.kind=direct", "seed=1"].iter().chain(keys);
        let keys: Vec<String> = keys.map(|key| (*key).to_owned()).collect();
        let scene = Scene::load(&path.join(format!("{rover}.toml")), &keys)?;
        let mut sensors = scene.sensors();
        let mut plant = DrivenPlant::new(&scene, &scene.plant_setup())?;
        let mut frames = Vec::new();
        while frames
            .last()
            .is_none_or(|f: &SensorFrame| f.time < scene.record.duration)
        {
            let mut frame = sensors.read(&plant.next_truth()?);
            frame.contact_angle = [None; 3];
            frames.push(frame);
        }
        let Suspension::Bogie { body } = scene.robot.robot.geometry.suspension else {
            return Err("no bogie".into());
        };
        let read = |f: &SensorFrame| {
            let own = [f.link1, f.link2][body.index()];
            let pin = f.link1.inclination.zip(f.link2.inclination);
            BodyReading {
                inclination: own.inclination,
                rate: own.rate,
                pin: pin.map(|(a, b)| a - b),
                wheels: f.wheel_angle,
            }
        };
        let body = frames.iter().map(read).collect();
        Ok(Self {
            scene,
            frames,
            body,
        })
    }

    /// What `check` says of the log with changed readings of the body.
    fn report(&self, change: impl Fn(&mut [BodyReading])) -> Result<Report, Failure> {
        let mut body = self.body.clone();
        change(&mut body);
        let spec = &self.scene.sensors.spec;
        let robot = self.scene.nominal_robot()?;
        let mut mount = BodyMount::new(&robot.geometry, spec.pin_noise).keeping_jumps();
        let mut frames = self.frames.clone();
        for (frame, reading) in frames.iter_mut().zip(&body) {
            [frame.link1, frame.link2] = mount.links(frame.time, reading);
        }
        checked(&self.scene, true, &frames)
    }
}

/// One of the readings of the body.
type Part = fn(&mut BodyReading) -> &mut Option<f64>;

const INCLINATION: Part = |b| &mut b.inclination;
const RATE: Part = |b| &mut b.rate;
const PIN: Part = |b| &mut b.pin;

/// A change of one reading, by its value, the number of its sample and a normal random number.
type Fault = fn(f64, usize, f64) -> f64;

fn noisy(x: f64, random: f64, degrees: f64) -> f64 {
    x + random * degrees.to_radians()
}

const SCALED: [(&str, Fault); 3] = [
    ("turn round sign", |x, _, _| -x),
    ("deg", |x, _, _| x.to_degrees()),
    ("rad", |x, _, _| x.to_radians()),
];
const NOISE: (&str, Fault) = ("noise", |x, _, random| noisy(x, random, 1.0));
const DEAD: (&str, Fault) = ("cable and driver", |_, _, _| 0.0);
/// A worn wiper, or a byte that is lost now and then.
const SPIKES: (&str, Fault) = ("wiper", |x, k, _| {
    if k % 50 == 17 {
        x + 15f64.to_radians()
    } else {
        x
    }
});

fn change(body: &mut [BodyReading], part: Part, fault: Fault) {
    let mut random = normal();
    for (k, reading) in body.iter_mut().enumerate() {
        let value = part(reading);
        *value = value.map(|x| fault(x, k, random()));
    }
}

/// Faults in words: test, channel, remedy.
fn faults(report: &Report) -> Vec<String> {
    let words = |f: &robhaz_log::check::Finding| {
        let remedy = f.remedy.clone().unwrap_or_default();
        format!("{} | {} | {remedy}", f.test, f.channel)
    };
    report.faults().map(words).collect()
}

/// Each fault of each reading is found with its remedy; the coarse encoders of one rover do not hide
/// that it stands at the start.
#[test]
fn each_fault_of_the_body_is_found() -> Result<(), Failure> {
    for rover in ["open-source-rover", "sojourner"] {
        let drive = Drive::of(rover)?;
        let honest = drive.report(|_| ())?;
        assert_eq!(faults(&honest), Vec::<String>::new(), "{rover}");
        let at_rest = honest.findings.iter().filter(|f| f.test == "noise at rest");
        let at_rest: Vec<_> = at_rest.map(|f| (f.channel.as_str(), f.verdict)).collect();
        for name in ["body_rate", "body_inclination", "pin_angle"] {
            assert!(
                at_rest.contains(&(name, Verdict::Ok)),
                "{rover}: {at_rest:?}"
            );
        }
        let mut cases: Vec<(&str, Part, &str, Fault)> = Vec::new();
        for (name, part) in [
            ("body_inclination", INCLINATION),
            ("body_rate", RATE),
            ("pin_angle", PIN),
        ] {
            for (remedy, fault) in SCALED.into_iter().chain([NOISE, DEAD]) {
                cases.push((name, part, remedy, fault));
            }
        }
        cases.push(("pin_angle", PIN, SPIKES.0, SPIKES.1));
        let missed: Vec<String> = cases
            .into_par_iter()
            .map(|(name, part, remedy, fault)| {
                let found = faults(&drive.report(|body| change(body, part, fault))?);
                let names = |f: &String| f.contains(name) && f.contains(remedy);
                let is_found = found.iter().any(names);
                Ok((!is_found).then(|| format!("{rover}: {name}, {remedy}: {found:?}")))
            })
            .collect::<Result<Vec<Option<String>>, Failure>>()?
            .into_iter()
            .flatten()
            .collect();
        assert!(missed.is_empty(), "{missed:#?}");
    }
    Ok(())
}

/// Keeps each value from half of the drive on.
fn stick(body: &mut [BodyReading], part: Part) {
    let half = body.len() / 2;
    let held = *part(&mut body[half]);
    body[half..].iter_mut().for_each(|b| *part(b) = held);
}

/// One reading that is wrong, a reading that stays from the middle of the drive on, and one that is
/// late, are named.
#[test]
fn single_stuck_and_late_readings_of_the_body_are_found() -> Result<(), Failure> {
    let drive = Drive::of("open-source-rover")?;
    let middle = drive.body.len() / 2;
    let named = |report: Report, name: &str, test: &str| {
        let found = faults(&report);
        let is_found = found
            .iter()
            .any(|f| f.contains(name) && f.starts_with(test));
        assert!(is_found, "{name}, {test}: {found:?}");
    };
    let single = drive.report(|body| {
        body[middle].pin = body[middle].pin.map(|x| x + 15f64.to_radians());
    })?;
    named(single, "pin_angle", "spikes");
    for (name, part) in [
        ("body_inclination", INCLINATION),
        ("body_rate", RATE),
        ("pin_angle", PIN),
    ] {
        named(drive.report(|body| stick(body, part))?, name, "stuck");
        // Of the pin, see the next test.
        if name != "pin_angle" {
            // 0.1 s.
            named(drive.report(|body| delay(body, part, 5))?, name, "delay");
        }
    }
    Ok(())
}

/// A reading that is late by a number of samples.
fn delay(body: &mut [BodyReading], part: Part, samples: usize) {
    for k in (samples..body.len()).rev() {
        let before = *part(&mut body[k - samples]);
        *part(&mut body[k]) = before;
    }
}

/// A late pin shows in the ground that the wheels pass one after the other. Slip makes as much of
/// 3 % of the way between two axles: two rovers at their own 50 Hz and 0.1 to 0.2 m/s show it from 0.2
/// s on, ten samples, and one that is longer than what is looked for, 0.3 s, is not called right.
/// At 8 and 10 Hz slower rovers show none up to seconds.
#[test]
fn a_late_pin_is_found_at_the_rate_of_the_rover() -> Result<(), Failure> {
    for rover in ["open-source-rover", "exomy"] {
        let drive = Drive::of(rover)?;
        for (samples, expected) in [
            (0, Verdict::Ok),
            (10, Verdict::Fault),
            (14, Verdict::Fault),
            (30, Verdict::CannotTell),
        ] {
            let report = drive.report(|body| delay(body, PIN, samples))?;
            let mut delays = report.findings.iter().filter(|f| f.test == "delay");
            let pin = delays.find(|f| f.channel.starts_with("pin_angle"));
            let verdict = pin.ok_or("no finding of the pin")?.verdict;
            assert_eq!(verdict, expected, "{rover}, {samples} samples: {pin:?}");
        }
    }
    Ok(())
}

/// Readings that contradict each other without another finding are a fault, also where wheels turn
/// by 0.07 rad between readings.
#[test]
fn a_contradiction_at_a_low_rate_is_a_fault() -> Result<(), Failure> {
    let drive = Drive::of("open-source-rover")?;
    let report = drive.report(|body| change(body, INCLINATION, NOISE.1))?;
    let found = faults(&report);
    assert!(
        found.iter().any(|f| f.starts_with("agreement of all")),
        "{found:?}"
    );
    Ok(())
}

/// A pin whose zero is off by 10 deg, and one that hangs from the middle of the drive on, with its noise: both are named.
/// An honest one is zero on the way, and turns with the ground.
#[test]
fn a_pin_shows_its_zero_and_that_it_hangs() -> Result<(), Failure> {
    for rover in ["open-source-rover", "exomy", "sojourner"] {
        let drive = Drive::of(rover)?;
        let of_pin = |report: &Report, test: &str| {
            let mut found = report.findings.iter().filter(|f| f.test == test);
            found.next().map(|f| (f.verdict, f.numbers[0].value))
        };
        let (zero, turns) = ("zero over the way", "turns with the ground");
        let honest = drive.report(|_| ())?;
        let verdict = of_pin(&honest, zero).map(|(verdict, _)| verdict);
        assert_eq!(verdict, Some(Verdict::Ok), "{rover}");
        assert_eq!(of_pin(&honest, turns), None, "{rover}");
        let off = drive.report(|body| change(body, PIN, |x, _, _| x + 10f64.to_radians()))?;
        let (verdict, mean) = of_pin(&off, zero).ok_or("no zero")?;
        assert!(
            verdict == Verdict::Fault && (mean - 10.0).abs() < 0.6,
            "{rover}: {mean}"
        );
        let noise = drive.scene.sensors.spec.pin_noise.to_degrees();
        let hangs = drive.report(|body| {
            stick(body, PIN);
            let half = body.len() / 2;
            let mut random = normal();
            for reading in &mut body[half..] {
                reading.pin = reading.pin.map(|x| noisy(x, random(), noise));
            }
        })?;
        let found = of_pin(&hangs, turns).map(|(verdict, _)| verdict);
        assert_eq!(found, Some(Verdict::Fault), "{rover}: {:?}", faults(&hangs));
    }
    Ok(())
}

/// The finding of a test.
fn found<'a>(report: &'a Report, test: &str) -> Option<&'a robhaz_log::check::Finding> {
    report.findings.iter().find(|f| f.test == test)
}

/// Front and rear wheel exchanged, encoder and torque together, are named with the columns, as the link with one wheel
/// turns that one; as they are, the same figure says that they are not.
#[test]
fn front_and_rear_wheel_show_on_which_links_they_are() -> Result<(), Failure> {
    const TEST: &str = "wheels on their links";
    for rover in ["open-source-rover", "exomy", "sojourner", "curiosity"] {
        let mut drive = Drive::of(rover)?;
        let honest = drive.report(|_| ())?;
        let own = found(&honest, TEST).ok_or("no finding")?;
        assert_eq!(own.verdict, Verdict::Ok, "{rover}: {own:?}");
        for frame in &mut drive.frames {
            frame.wheel_angle.swap(0, 2);
            frame.motor_torque.swap(0, 2);
        }
        let report = drive.report(|_| ())?;
        let exchanged = found(&report, TEST).ok_or("no finding")?;
        assert_eq!(exchanged.verdict, Verdict::Fault, "{rover}: {exchanged:?}");
        let remedy = exchanged.remedy.as_deref().unwrap_or_default();
        for name in ["angle", "motor_torque"] {
            let words = format!("exchange the columns of wheel1_{name} and wheel3_{name}");
            assert!(remedy.contains(&words), "{rover}: {remedy}");
        }
        // Corrected, they fit.
        let others = faults(&report);
        assert_eq!(others.len(), 1, "{rover}: {others:?}");
    }
    Ok(())
}

/// On ground without waves no wheel shows its link.
#[test]
fn level_ground_does_not_show_the_links_of_the_wheels() -> Result<(), Failure> {
    let drive = Drive::with("open-source-rover", &["terrain.kind=flat"])?;
    let report = drive.report(|_| ())?;
    let own = found(&report, "wheels on their links").ok_or("no finding")?;
    assert_eq!(own.verdict, Verdict::CannotTell, "{own:?}");
    Ok(())
}

/// A robot file whose body, or whose middle wheel, is on the other link is named, and no remedy of readings with it.
#[test]
fn a_linkage_that_is_stated_wrong_is_named() -> Result<(), Failure> {
    type Mistake = fn(&mut Geometry);
    let changes: [(&str, Mistake); 2] = [
        ("suspension.body", |geometry| {
            if let Suspension::Bogie { body } = geometry.suspension {
                geometry.make_bogie(other(body));
            }
        }),
        ("carriers", |geometry| {
            geometry.carriers[1] = other(geometry.carriers[1]);
        }),
    ];
    for rover in ["open-source-rover", "exomy"] {
        for (name, change) in &changes {
            let mut drive = Drive::of(rover)?;
            change(&mut drive.scene.robot.robot.geometry);
            let found = faults(&drive.report(|_| ())?);
            let [only] = &found[..] else {
                return Err(format!("{rover}, {name}: {found:?}").into());
            };
            assert!(
                only.contains("| robot file |") && only.contains(name),
                "{rover}, {name}: {only}"
            );
        }
    }
    Ok(())
}

fn other(carrier: Carrier) -> Carrier {
    match carrier {
        Carrier::Link1 => Carrier::Link2,
        Carrier::Link2 => Carrier::Link1,
    }
}

/// The gravity of the moon stated for a log of the earth, and that of the earth for one of the moon: the inclinometers
/// show it, as the distance by the encoders is right.
#[test]
fn another_gravity_is_named() -> Result<(), Failure> {
    for (of_log, stated) in [("earth", 1.62), ("moon", 9.81)] {
        let gravity = format!("robot.gravity={of_log}");
        let mut drive = Drive::with("open-source-rover", &[&gravity])?;
        let own = faults(&drive.report(|_| ())?);
        assert_eq!(own, Vec::<String>::new(), "{of_log}");
        let true_one = drive.scene.robot.robot.gravity;
        drive.scene.robot.robot.gravity = stated;
        let report = drive.report(|_| ())?;
        let faults = faults(&report);
        let is_named = faults.len() == 1 && faults[0].contains("`gravity` of the robot file");
        assert!(is_named, "{of_log}: {faults:?}");
        let scale = report.faults().next().ok_or("no fault")?.numbers[0].value;
        assert!((scale * stated / true_one - 1.0).abs() < 0.2, "{scale}");
    }
    Ok(())
}

/// Columns of speeds that are described as angles are named with their unit; angles are none.
#[test]
fn speeds_are_no_angles() -> Result<(), Failure> {
    const TEST: &str = "angle or speed";
    for rover in ["open-source-rover", "curiosity"] {
        let drive = Drive::of(rover)?;
        assert!(found(&drive.report(|_| ())?, TEST).is_none(), "{rover}");
        for (unit, of_unit) in [
            ("rad/s", 1.0),
            ("deg/s", 1f64.to_radians()),
            ("rpm", PI / 30.0),
        ] {
            let mut speeds = Drive::of(rover)?;
            for (k, frame) in speeds.frames.iter_mut().enumerate() {
                let next = &drive.frames[(k + 1).min(drive.frames.len() - 1)];
                let before = &drive.frames[k.saturating_sub(1)];
                let step = next.time - before.time;
                for (i, angle) in frame.wheel_angle.iter_mut().enumerate() {
                    let turn = next.wheel_angle[i].zip(before.wheel_angle[i]);
                    *angle = turn.map(|(b, a)| (b - a) / step / of_unit);
                }
            }
            let report = speeds.report(|_| ())?;
            let faults = faults(&report);
            let words = format!("state unit = \"{unit}\"");
            let is_named = faults
                .iter()
                .any(|f| f.starts_with(TEST) && f.contains(&words));
            assert!(is_named, "{rover}, {unit}: {faults:?}");
        }
    }
    Ok(())
}
