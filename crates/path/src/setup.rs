//! What is judged: robot, ground, available friction and drive, from a scene.

use robhaz_model::{Robot, named};
use robhaz_scene::Scene;
use robhaz_sim::friction::{FrictionLaw, Slip};
use robhaz_terrain::{Profile, Terrain};

named! {
    /// How the tractions are distributed over the wheels.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum DriveKind {
        /// The best distribution: the one with the least needed friction.
        #[default]
        Ideal = "ideal",
        /// `drive.kind = "shared"`: the same T/N at every wheel. Driven along the path.
        Shared = "shared",
        /// `drive.kind = "speed"`: every wheel turns with the set speed, tractions by slip. Driven
        /// along the path.
        Speed = "speed",
    }
}

/// Options of a judgement.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// Mean of the available friction coefficient outside the scene's friction stretches, -; `None`
    /// takes the scene's mu_s.
    pub mu: Option<f64>,
    /// Standard deviation of the available friction coefficient, -.
    pub mu_sigma: f64,
    /// Distribution of the tractions.
    pub drive: DriveKind,
    /// Distance that the middle wheel travels, m; `None` goes on until the rear wheel has passed
    /// the profile.
    pub distance: Option<f64>,
}

/// Reason why a path cannot be judged.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct PathError(pub(crate) String);

/// Robot, ground and limits of a path.
#[derive(Clone)]
pub struct PathSetup {
    /// The scene: robot, drive and friction are the true ones.
    pub scene: Scene,
    /// The ground.
    pub terrain: Terrain,
    /// Options.
    pub options: Options,
    /// Distance that the middle wheel travels, m.
    pub distance: f64,
}

/// Largest tractions of a wheel that the motor allows, N. Losses of the gear help to brake. Where
/// they are above the torque limit, `driving` is below 0: the wheel has to be dragged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tractions {
    /// Backwards.
    pub braking: f64,
    /// Forward.
    pub driving: f64,
}

impl Tractions {
    /// No limit.
    pub const FREE: Self = Self {
        braking: f64::INFINITY,
        driving: f64::INFINITY,
    };

    /// A traction (N) within them.
    pub fn within(&self, traction: f64) -> f64 {
        traction.max(-self.braking).min(self.driving)
    }
}

/// Distance behind the profile that the rear wheel travels, over the wheel radius.
const BEHIND: f64 = 2.0;
/// Largest friction coefficient and standard deviation, -.
pub(crate) const LARGEST_MU: f64 = 10.0;
/// Longest path, m.
const LONGEST: f64 = 1e3;

impl PathSetup {
    /// The path of a scene.
    ///
    /// # Errors
    /// [`PathError`] when an option is out of range or no path lies ahead.
    pub fn new(scene: &Scene, options: Options) -> Result<Self, PathError> {
        let refused = |text: String| Err(PathError(text));
        // In this form the conditions refuse NaN as well.
        if let Some(mu) = options.mu
            && !(0.0..=LARGEST_MU).contains(&mu)
        {
            return refused(format!(
                "the mean of the friction coefficient (--mu) is {mu}; it must be 0 to {LARGEST_MU}"
            ));
        }
        let sigma = options.mu_sigma;
        if !(0.0..=LARGEST_MU).contains(&sigma) {
            return refused(format!(
                "the standard deviation of the friction coefficient (--mu-sigma) is {sigma}; it must be 0 to {LARGEST_MU}"
            ));
        }
        let speed = scene.drive.speed;
        if speed < 0.0 {
            return refused(format!(
                "drive.speed is {speed} m/s; a path is judged forward: to drive it back, mirror the ground and the robot"
            ));
        }
        if options.drive != DriveKind::Ideal && (speed.is_nan() || speed <= 0.0) {
            return refused(format!(
                "drive.speed is {speed} m/s; a robot that is driven along the path (--drive shared, --drive speed) needs one above 0"
            ));
        }
        let robot = &scene.robot.robot;
        let fastest = (scene.drive.torque_limit - scene.drive.gear_friction)
            / scene.drive.viscous_damping
            * robot.geometry.wheel_radius;
        if options.drive != DriveKind::Ideal && fastest <= 0.0 {
            return refused("drive.torque_limit must be above drive.gear_friction".to_owned());
        }
        if options.drive != DriveKind::Ideal && speed >= fastest {
            return refused(format!(
                "drive.speed is {speed} m/s; it must be below {fastest:.4} m/s, where damping and gear friction take all of drive.torque_limit"
            ));
        }
        let terrain = scene.terrain.build(robot);
        let distance = match options.distance {
            Some(distance) if distance > 0.0 && distance <= LONGEST => distance,
            Some(distance) => {
                return refused(format!(
                    "the distance (--distance) is {distance} m; it must be above 0 and at most 1000 m"
                ));
            }
            None => to_the_end(robot, &terrain, &scene.terrain.profile)?,
        };
        Ok(Self {
            scene: scene.clone(),
            terrain,
            options,
            distance,
        })
    }

    /// The robot: true geometry and masses.
    pub(crate) fn robot(&self) -> &Robot {
        &self.scene.robot.robot
    }

    /// Mean of the available friction coefficient outside the friction stretches, -.
    pub(crate) fn mu(&self) -> f64 {
        self.options.mu.unwrap_or(self.scene.friction.mu_s)
    }

    /// Mean of the available friction coefficient at x (m), -.
    pub fn mu_at(&self, x: f64) -> f64 {
        let mut stretches = self.scene.terrain.stretches.iter();
        let stretch = stretches.find(|s| s.from <= x && x < s.to);
        stretch.map_or(self.mu(), |s| s.mu_s)
    }

    /// Friction of a wheel that slides at a slip speed (m/s) over the available friction, by the
    /// law of the scene, -.
    pub(crate) fn sliding(&self, slip: f64) -> f64 {
        let law = &self.scene.friction;
        if law.mu_s > 0.0 {
            law.sliding_coefficient(slip) / law.mu_s
        } else {
            1.0
        }
    }

    /// T/N of a wheel with an available friction, by the law of the scene, and whether it slides.
    pub(crate) fn creeping(&self, mu: f64, slip: &Slip) -> (f64, bool) {
        let law = FrictionLaw {
            mu_s: mu,
            mu_d: mu * self.sliding(f64::INFINITY),
            ..self.scene.friction
        };
        let slides = slip.speed().abs() > law.slip_limit(slip);
        (law.coefficient(slip), slides)
    }

    /// Losses of gear and wheel module at a speed of the rim (m/s), N at the rim.
    pub(crate) fn losses(&self, speed: f64) -> f64 {
        let (drive, radius) = (&self.scene.drive, self.robot().geometry.wheel_radius);
        (drive.gear_friction + drive.viscous_damping * speed / radius) / radius
    }

    /// Largest tractions of a wheel whose rim has this speed (m/s).
    pub(crate) fn tractions(&self, speed: f64) -> Tractions {
        let motor = self.scene.drive.torque_limit / self.robot().geometry.wheel_radius;
        let losses = self.losses(speed);
        Tractions {
            braking: motor + losses,
            driving: motor - losses,
        }
    }
}

/// Distance until the rear wheel has passed the profile, m.
fn to_the_end(robot: &Robot, terrain: &Terrain, profile: &Profile) -> Result<f64, PathError> {
    let rear = robot.geometry.axles[2].x;
    let (_, end) = terrain.extent();
    let distance = end - rear + BEHIND * robot.geometry.wheel_radius;
    if matches!(profile, Profile::Flat) || end <= rear {
        return Err(PathError(format!(
            "there is no path ahead: [terrain] is level from x = {rear:.3} m on; --distance judges level ground, too"
        )));
    }
    if distance > LONGEST {
        return Err(PathError(format!(
            "[terrain] ends {distance:.1} m ahead, and a path has at most 1000 m: --distance D judges its first D m"
        )));
    }
    Ok(distance)
}
