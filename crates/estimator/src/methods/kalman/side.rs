//! What the filters of one side give to the equations of a whole rover.

use super::{KalmanFilters, Step};
use crate::frame::Inputs;
use crate::nominal::Nominal;
use crate::state::{self, ACCELERATION, CONTACT_ANGLE, RESISTANCE};
use crate::statics::{CAUSES, DIRECT, causes};
use robhaz_model::{Units, Vec2};

/// State of one side, SI. Angles are against the horizontal, in the plane of the side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SideState {
    /// Angles of links 1 and 2, rad, their rates, rad/s, and accelerations, rad/s^2.
    pub links: [[f64; 3]; 2],
    /// Standard deviation of the links' angles, rad.
    pub angle_sigma: [f64; 2],
    /// Velocity of Q, m/s.
    pub velocity: Vec2,
    /// Acceleration of Q, m/s^2.
    pub acceleration: Vec2,
    /// Spin of the wheels relative to their links, rad/s and rad/s^2.
    pub spin: [[f64; 2]; 3],
    /// Contact angles, rad.
    pub contact_angle: [f64; 3],
    /// Tractions, N.
    pub traction: [f64; 3],
    /// Slip speed of the wheels at T = N, m/s, at least ten times what the gyroscope's noise makes of a
    /// wheel's sideways velocity.
    pub creep: [f64; 3],
    /// Coefficient of the rolling resistance, -.
    pub rolling_resistance: f64,
    /// Deviations of that of each wheel that are no errors of the filters' states, -: of wheels that turn,
    /// signed as their spin, and of wheels that rest.
    pub rolling_left: [[f64; 3]; 2],
    /// Smoothed signs of the spins, by which friction resists: -1 to 1.
    pub friction_share: [f64; 3],
    /// Standard deviation of the torque of an end stop between links 1 and 2, N m.
    pub stop_torque: f64,
    /// Covariance of the errors of acceleration x, y, contact angles, rolling resistance and tractions.
    pub covariance: [[f64; CAUSES]; CAUSES],
    /// Standard deviations of the tractions by what is no input, N.
    pub noise: [f64; 3],
    /// Derivatives of acceleration x, y, contact angles, rolling resistance and tractions by the
    /// filters' uncertain inputs.
    by_inputs: [[f64; state::INPUTS]; CAUSES],
}

impl SideState {
    /// Derivatives by the filters' uncertain inputs of what has these derivatives by acceleration x,
    /// y, contact angles, rolling resistance and tractions.
    pub fn gradient(&self, by_causes: &[f64; CAUSES]) -> [f64; state::INPUTS] {
        let mut gradient = [0.0; state::INPUTS];
        for (by_inputs, by_cause) in self.by_inputs.iter().zip(by_causes) {
            for (entry, by_input) in gradient.iter_mut().zip(by_inputs) {
                *entry += by_cause * by_input;
            }
        }
        gradient
    }
}

impl KalmanFilters {
    /// Takes the tractions anew, after the motion's states were corrected.
    pub fn retake(&self, nominal: &Nominal, step: &mut Step) {
        step.right.tractions = self.tractions(nominal);
    }

    /// The state after `step`.
    pub fn side_state(
        &self,
        units: &Units,
        nominal: &Nominal,
        inputs: &Inputs,
        step: &Step,
    ) -> SideState {
        let (time, force, budget) = (units.time, units.force(), &nominal.settings.budget);
        let acceleration = units.length / (time * time);
        let links = self.links.each_ref().map(|link| {
            let (rate, turning) = (link.smooth_rate / time, link.acceleration / (time * time));
            [link.angle(), rate, turning]
        });
        let mut covariance = causes(&step.right.tractions, &|a, b| {
            self.motion.input_covariance(a, b)
        });
        let resistance = self.resistance(nominal);
        // An estimated contact angle is less the error that the filter's state has; rolling resistance
        // is a part of the state's.
        let unit = |k: usize| match k {
            k if ACCELERATION.all().contains(&k) => acceleration,
            k if CONTACT_ANGLE.all().contains(&k) => -1.0,
            k if RESISTANCE.all().contains(&k) => resistance.coefficient_rate(),
            _ => force,
        };
        for (a, row) in covariance.iter_mut().enumerate() {
            for (b, entry) in row.iter_mut().enumerate() {
                *entry *= unit(a) * unit(b);
            }
        }
        let mut by_inputs = [[0.0; state::INPUTS]; CAUSES];
        for (cause, row) in by_inputs.iter_mut().enumerate() {
            if cause < DIRECT {
                row[cause] = unit(cause);
            }
        }
        for (i, traction) in step.right.tractions.iter().enumerate() {
            for (k, derivative) in traction.gradient(i) {
                by_inputs[DIRECT + i][k] += derivative * force;
            }
        }
        let least_creep = 10.0 * budget.rate_noise * 2.0 * Units::RADIUS;
        SideState {
            links,
            angle_sigma: (self.links.each_ref()).map(|link| link.angle_sigma(budget)),
            velocity: self.motion.velocity() * units.speed(),
            acceleration: self.motion.acceleration() * acceleration,
            spin: (self.wheels.each_ref()).map(|wheel| {
                let spin = wheel.settled_speed().unwrap_or(0.0);
                [spin / time, wheel.acceleration / (time * time)]
            }),
            contact_angle: [0, 1, 2].map(|i| self.contact_angle(i, inputs)),
            traction: (step.right.tractions.each_ref()).map(|t| t.value * force),
            creep: [0, 1, 2].map(|i| self.motion.creep(i).max(least_creep) * units.speed()),
            rolling_resistance: resistance.coefficient(),
            rolling_left: self.rolling_left(nominal),
            stop_torque: nominal.stop_torque(links.map(|[angle, ..]| angle)) * units.torque(),
            friction_share: self.wheels.each_ref().map(|wheel| wheel.friction_share),
            covariance,
            noise: (step.right.tractions.each_ref()).map(|t| robhaz_model::sqrt(t.noise()) * force),
            by_inputs,
        }
    }
}
