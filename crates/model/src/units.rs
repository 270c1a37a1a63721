//! Units of a robot, in which robots of every size on every planet move alike.

use crate::{GRAVITY, Geometry, MassSet, Outline, PinStop, Pins, Robot, sqrt};

/// Mass of one side, kg, of the robot whose units are SI.
/// Definition.
const MASS: f64 = 14.0;

/// Robots that differ in size alone move alike where their Froude number v^2/(g r) is equal. In
/// units in which the wheels' radius is 0.1 m, the robot's mass 14 kg and gravity 9.81 m/s^2, they
/// give the same numbers; for robot A on Earth these units are SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// m
    pub length: f64,
    /// kg
    pub mass: f64,
    /// s
    pub time: f64,
}

impl Units {
    /// Radius of a wheel, m, of the robot whose units are SI; of all robots in their own units.
    /// Definition.
    pub const RADIUS: f64 = 0.1;
    /// Moment of the mean load of one of three wheels at the arm of its radius, N m: r m g/3, in the
    /// robots' own units.
    pub const MEAN_MOMENT: f64 = Self::RADIUS * MASS * GRAVITY / 3.0;

    /// For a robot. SI where a number is not above 0 and finite.
    pub fn of(robot: &Robot) -> Self {
        let length = robot.geometry.wheel_radius / Self::RADIUS;
        let mass = robot.mass.total() / MASS;
        let time = sqrt(length * (GRAVITY / robot.gravity));
        let units = [length, mass, time];
        let usable = units.iter().all(|unit| *unit > 0.0 && unit.is_finite());
        let [length, mass, time] = if usable { units } else { [1.0; 3] };
        Self { length, mass, time }
    }

    /// m/s
    pub fn speed(&self) -> f64 {
        self.length / self.time
    }

    /// N
    pub fn force(&self) -> f64 {
        self.mass * self.length / (self.time * self.time)
    }

    /// N m
    pub fn torque(&self) -> f64 {
        self.force() * self.length
    }

    /// kg m^2
    pub fn inertia(&self) -> f64 {
        self.mass * self.length * self.length
    }

    /// A robot in these units, in which gravity is that of Earth.
    pub fn robot_in(&self, robot: &Robot) -> Robot {
        let (geometry, mass) = (&robot.geometry, &robot.mass);
        let l = self.length;
        let Pins { p, q, r, s } = geometry.pins;
        let [p, q, r, s] = [p, q, r, s].map(|pin| pin / l);
        Robot {
            geometry: Geometry {
                suspension: robot.geometry.suspension,
                wheel_radius: geometry.wheel_radius / l,
                axles: geometry.axles.map(|axle| axle / l),
                carriers: geometry.carriers,
                pins: Pins { p, q, r, s },
                body_cg: geometry.body_cg / l,
                link_cg: geometry.link_cg.map(|cg| cg / l),
                stop: PinStop {
                    stiffness: geometry.stop.stiffness / self.torque(),
                    damping: geometry.stop.damping / (self.torque() * self.time),
                    ..geometry.stop
                },
                outline: Outline {
                    body_lower: geometry.outline.body_lower / l,
                    body_upper: geometry.outline.body_upper / l,
                    half_width: geometry.outline.half_width / l,
                    through: (geometry.outline.through)
                        .map(|points| points.map(|point| point.map(|point| point / l))),
                },
            },
            mass: MassSet {
                body: mass.body / self.mass,
                links: mass.links.map(|link| link / self.mass),
                wheel: mass.wheel / self.mass,
                body_inertia: mass.body_inertia / self.inertia(),
                link_inertias: mass.link_inertias.map(|link| link / self.inertia()),
                wheel_inertia: mass.wheel_inertia / self.inertia(),
                rotor_inertia: mass.rotor_inertia / self.inertia(),
            },
            gravity: GRAVITY,
        }
    }
}
