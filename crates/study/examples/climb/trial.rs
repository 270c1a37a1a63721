//! One drive up the stairs in the simulator, engine `direct`.

use crate::Outcome;
use robhaz_model::Geometry;
use robhaz_run::{DrivenPlant, TruthClearance};
use robhaz_scene::Scene;
use robhaz_sim::Truth;
use std::path::Path;

/// A control with its keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Constant wheel speed, PI.
    Pi,
    /// Constant wheel speed, soft.
    Soft,
    /// Shared traction, with typical sensors and without contact angles.
    Shared,
}

impl Control {
    pub const ALL: [Self; 3] = [Self::Pi, Self::Soft, Self::Shared];

    /// Name in tables and figures.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pi => "speed, PI",
            Self::Soft => "speed, soft",
            Self::Shared => "shared",
        }
    }

    const fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Pi => &[],
            Self::Soft => &["drive.kp=2", "drive.ki=0"],
            Self::Shared => &["drive.kind=shared", "sensors.grade=typical"],
        }
    }
}

/// Stairs and how they are driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    pub control: Control,
    /// mu_s; mu_d is 0.875 of it, as in the default law.
    pub mu: f64,
    /// Height of a riser, m.
    pub rise: f64,
    /// Length of a tread, m.
    pub run: f64,
}

/// How a trial ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drove {
    pub end: End,
    /// Share of the way that was done, 0 to 1.
    pub share: f64,
    /// Least distance of pin Q to its end stops, rad.
    pub stop_margin: f64,
    /// Least clearance of body and links, m.
    pub clearance: f64,
}

/// Why a trial ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The rear wheel is on the last tread.
    Passed,
    /// It came no farther.
    Stuck,
    /// A bar came too near to the ground, or pin Q to an end stop.
    NoMargin,
    /// The simulation ended: the robot overturned or its linkage folded.
    Overturned,
}

/// Margins that a drive has to keep.
const LEAST_CLEARANCE: f64 = 0.005;
const LEAST_STOP_MARGIN: f64 = 0.035;
/// The robot is stuck when it has not come so much farther (m) in so long (s).
const FARTHER: f64 = 0.005;
const PATIENCE: f64 = 3.0;
/// Longest drive, s.
const LONGEST: f64 = 40.0;
/// Distance of the rear wheel behind the last riser at the end, m.
const BEHIND: f64 = 0.15;
/// Time between two looks at a drive whose control takes no readings, s.
const PERIOD: f64 = 0.01;

impl Trial {
    /// The scene `stairs` with a geometry.
    fn scene(&self, geometry: &Geometry) -> Outcome<Scene> {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/stairs.toml");
        let own = [
            "engine.kind=direct".to_owned(),
            format!("contact.mu_s={}", self.mu),
            format!("contact.mu_d={}", 0.875 * self.mu),
            format!("terrain.rise={}", self.rise),
            format!("terrain.run={}", self.run),
        ];
        let keys = self.control.keys().iter().map(|key| (*key).to_owned());
        let overrides: Vec<String> = own.into_iter().chain(keys).collect();
        let mut scene = Scene::load(Path::new(path), &overrides)?;
        scene.robot.robot.geometry = geometry.clone();
        Ok(scene)
    }

    /// Drives a checked geometry up the stairs.
    pub fn drive(&self, geometry: &Geometry) -> Outcome<Drove> {
        self.followed(geometry, &mut |_| {})
    }

    /// As [`Trial::drive`], with a look at the truth every 10 ms.
    pub fn followed(&self, geometry: &Geometry, look: &mut dyn FnMut(&Truth)) -> Outcome<Drove> {
        let scene = self.scene(geometry)?;
        let mut setup = scene.plant_setup();
        if self.control != Control::Shared {
            setup.period = PERIOD;
        }
        let (_, last) = setup.terrain.extent();
        let goal = last - geometry.axles[2].x + BEHIND;
        let each = (PERIOD / setup.period).round().max(1.0);
        let mut plant = DrivenPlant::new(&scene, &setup)?;
        let mut meter = TruthClearance::of(&scene);
        let mut drove = Drove {
            end: End::Overturned,
            share: 0.0,
            stop_margin: f64::INFINITY,
            clearance: f64::INFINITY,
        };
        let (mut best, mut since, mut sample) = (f64::NEG_INFINITY, 0.0, 0.0);
        while let Ok(truth) = plant.next_truth() {
            sample += 1.0;
            if sample % each != 0.0 {
                continue;
            }
            look(&truth);
            let x = truth.wheels[1].position.x;
            drove.share = drove.share.max((x / goal).clamp(0.0, 1.0));
            let opening = truth.links[0].angle - truth.links[1].angle;
            let stop = &geometry.stop;
            let to_stop = (stop.upper - opening).min(opening - stop.lower);
            drove.stop_margin = drove.stop_margin.min(to_stop);
            if let Some(found) = meter.at_change(&truth) {
                drove.clearance = drove.clearance.min(found.least().1);
            }
            if x > best + FARTHER {
                (best, since) = (x, truth.time);
            }
            let waited = truth.time - since.max(scene.drive.start_time);
            drove.end =
                if drove.clearance < LEAST_CLEARANCE || drove.stop_margin < LEAST_STOP_MARGIN {
                    End::NoMargin
                } else if x >= goal {
                    End::Passed
                } else if waited > PATIENCE || truth.time >= LONGEST {
                    End::Stuck
                } else {
                    continue;
                };
            return Ok(drove);
        }
        drove.end = End::Overturned;
        Ok(drove)
    }

    /// Whether the robot climbs the stairs with its margins. A robot that cannot start has not climbed them.
    pub fn passes(&self, geometry: &Geometry) -> bool {
        self.drive(geometry).is_ok_and(|d| d.end == End::Passed)
    }
}
