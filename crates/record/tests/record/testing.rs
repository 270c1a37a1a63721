//! Made-up records and a small scene for the tests of this crate.

use robhaz_estimator::{
    Estimate, EstimateError, EstimatorSettings, Flags, LinkReading, SensorFrame,
};
use robhaz_model::{Pin, Posture, Vec2};
use robhaz_record::{Column, Kind, Summary, SummarySink};
use robhaz_run::{EstimatedTerrain, Frame, RunDescription, RunEnd, Sink};
use robhaz_scene::{EstimatorChoice, RecordChoice, Scene, TerrainChoice};
use robhaz_sim::{BarTruth, ContactList, ContactTruth, PinTruth, Truth, WheelTruth};
use robhaz_terrain::Profile;

/// The end of a complete run of [`scene`].
pub const END: RunEnd = RunEnd {
    ground: Vec::new(),
    start: None,
    duration: 2.0,
    wall: 0.1,
    step: Some(1e-4),
    broken_off: None,
    friction_tests: Vec::new(),
    log: None,
};

/// A record that owns what a [`Frame`] borrows.
pub struct Record {
    pub truth: Truth,
    pub sensors: SensorFrame,
    pub estimates: Vec<Result<Estimate, EstimateError>>,
}

impl Record {
    pub fn frame(&self) -> Frame<'_> {
        Frame {
            clearances: None,
            time: self.truth.time,
            truth: Some(&self.truth),
            sensors: &self.sensors,
            estimates: &self.estimates,
            commands: None,
            both: None,
            ground: EstimatedTerrain::default(),
        }
    }

    /// The same of recorded readings: without truth.
    pub fn without_truth(&self) -> Frame<'_> {
        Frame {
            truth: None,
            ..self.frame()
        }
    }
}

/// Three estimators, the last of them not of the paper; 2 s at 100 Hz, compared from 0.5 s.
pub fn scene() -> Scene {
    let estimator = |name: &str, settings| EstimatorChoice {
        name: name.to_owned(),
        settings,
        damping: None,
    };
    let mut terrain = TerrainChoice::default();
    (terrain.kind, terrain.profile) = ("flat", Profile::Flat);
    Scene {
        name: "trial".to_owned(),
        seed: 7,
        terrain,
        estimators: vec![
            estimator("paper-body", EstimatorSettings::paper_body()),
            estimator("true-mass", EstimatorSettings::true_mass()),
            estimator("mine", EstimatorSettings::kalman()),
        ],
        record: RecordChoice {
            duration: 2.0,
            rate: 100.0,
            compare_from: 0.5,
        },
        ..Scene::default()
    }
}

/// The description of a run of a scene.
pub fn described(scene: &Scene) -> RunDescription {
    RunDescription::of(scene).expect("a nominal robot")
}

/// The description of recorded readings with the estimators of [`scene`].
pub fn log() -> RunDescription {
    RunDescription {
        has_truth: false,
        world: None,
        both: None,
        ..described(&scene())
    }
}

fn one_contact(contact: ContactTruth) -> ContactList {
    let mut list = ContactList::default();
    list.push(contact);
    list
}

/// A truth in which every field has a value of its own.
pub fn truth_at(time: f64) -> Truth {
    let wave = |k: f64| (k + 3.0 * time).sin();
    let bar = |k: f64| BarTruth {
        position: Vec2::new(wave(k), wave(k + 0.1)),
        angle: wave(k + 0.2),
        velocity: Vec2::new(wave(k + 0.3), wave(k + 0.4)),
        rate: wave(k + 0.5),
    };
    let wheel = |k: f64| WheelTruth {
        position: Vec2::new(wave(k), wave(k + 0.1)),
        angle: wave(k + 0.2),
        omega: wave(k + 0.3),
        torque: wave(k + 0.4),
        normal_force: 45.0 + 20.0 * wave(k + 0.5),
        traction: 10.0 * wave(k + 0.6),
        contact_angle: 0.2 * wave(k + 0.7),
        penetration: 1e-3 * wave(k + 0.8),
        slip_speed: wave(k + 0.9),
        slip_limit: 0.02,
        contacts: 1,
        force: Vec2::new(-5.0, 44.0),
        slides: false,
        contact_list: one_contact(ContactTruth {
            point: Vec2::new(wave(k), wave(k + 0.1) - 0.1),
            normal: Vec2::y(),
            normal_force: 45.0 + 20.0 * wave(k + 0.5),
            traction: 10.0 * wave(k + 0.6),
            penetration: 1e-3 * wave(k + 0.8),
            slip_speed: wave(k + 0.9),
            slides: false,
        }),
    };
    let pin = |k: f64| PinTruth {
        position: Vec2::new(wave(k), wave(k + 0.1)),
        force: Vec2::new(10.0 * wave(k + 0.2), 10.0 * wave(k + 0.3)),
    };
    Truth {
        time,
        body: bar(0.0),
        links: [bar(1.0), bar(2.0), bar(3.0)],
        wheels: [wheel(4.0), wheel(5.0), wheel(6.0)],
        pins: [pin(7.0), pin(8.0), pin(9.0), pin(10.0)],
        stop_torque: wave(11.0),
        loop_error: 1e-9,
    }
}

/// An estimate whose normal forces are `error` (N) too high on every wheel.
pub fn good_estimate(truth: &Truth, error: f64) -> Estimate {
    let q = truth.pin(Pin::Q).position;
    Estimate {
        time: truth.time,
        normal_force: truth.wheels.map(|w| w.normal_force + error),
        traction: truth.wheels.map(|w| w.traction - 0.5 * error),
        contact_angle: truth.wheels.map(|w| w.contact_angle),
        posture: Posture {
            body: truth.body.angle,
            links: truth.links.map(|l| l.angle),
        },
        pin_from_q: truth.pins.map(|p| p.position - q),
        pin_force: truth.pins.map(|p| p.force),
        residual: [0.1, 0.2, 0.3, 0.4],
        parity: None,
        kalman: None,
        flags: Flags::NONE,
    }
}

/// A record with three estimates, 2, 1 and 4 N too high.
pub fn frame_of(time: f64) -> Record {
    let truth = truth_at(time);
    let estimates = [2.0, 1.0, 4.0]
        .map(|error| Ok(good_estimate(&truth, error)))
        .to_vec();
    record_of(truth, estimates)
}

/// A record of which no estimator can make anything.
pub fn failed_frame(time: f64) -> Record {
    let refusal = EstimateError::Singular;
    record_of(truth_at(time), vec![Err(refusal); 3])
}

/// A record of given truth and estimates.
pub fn record_of(truth: Truth, estimates: Vec<Result<Estimate, EstimateError>>) -> Record {
    let link = |i: usize| LinkReading {
        inclination: Some(truth.links[i].angle),
        rate: Some(truth.links[i].rate),
        rate_error: 0.0,
    };
    Record {
        sensors: SensorFrame {
            time: truth.time,
            wheel_angle: truth.wheels.map(|w| Some(w.angle)),
            motor_torque: truth.wheels.map(|w| Some(w.torque)),
            link1: link(0),
            link2: link(1),
            contact_angle: truth.wheels.map(|w| Some(w.contact_angle)),
            ..SensorFrame::default()
        },
        truth,
        estimates,
    }
}

/// Records of the whole of [`scene`]; between 1.0 and 1.2 s there are no estimates, and some
/// readings are lost.
pub fn records() -> Vec<Record> {
    (0..=200)
        .map(|k| {
            let time = f64::from(k) / 100.0;
            if (1.0..1.2).contains(&time) {
                failed_frame(time)
            } else {
                frame_of(time)
            }
        })
        .enumerate()
        .map(|(k, mut record)| {
            if k % 7 == 0 {
                record.sensors.motor_torque[1] = None;
                record.sensors.link2.rate = None;
            }
            record
        })
        .collect()
}

/// The value of a column in a record; `None` where it is missing.
pub fn value_of(column: &Column, frame: &Frame<'_>) -> Option<f64> {
    let mut values = Vec::new();
    column.add(std::slice::from_ref(frame), &mut values);
    let is_there = |v: &f64| v.is_finite() || column.kind != Kind::Optional;
    values.pop().filter(is_there)
}

/// The summary of a complete run of [`scene`] without records.
pub fn finished() -> Summary {
    let mut sink = SummarySink::new();
    sink.begin(&described(&scene())).expect("begins");
    sink.end(Some(&END)).expect("ends");
    sink.summary().expect("a finished run")
}
