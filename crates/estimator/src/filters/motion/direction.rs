//! Measurement: the direction of a wheel's velocity. The centre of the wheel moves along the ground,
//! so the contact angles of three wheels must fit one velocity of Q.
//!
//! | | |
//! |---|---|
//! | innovation | 0 less the speed away from the ground, `n(gamma_i) . v_i`, and that of penetration, m/s |
//! | states | velocity of Q, contact angle (or its error), speed of penetration |
//! | noise | gyroscope, averaged over some way where the angle is unknown; its bias; given angle: penetration |
//! | gate | [`GATE`]; unknown angles: beyond [`SIGNIFICANT`] the wheel has met an edge |
//! | channels | gyroscope, given contact angle, the other wheels' encoders |

use super::filter::MotionFilter;
use super::rolling::Sample;
use super::tuning;
use crate::contact::ContactVelocity;
use crate::deviation::{GATE, SIGNIFICANT};
use crate::filters::GaussMarkov;
use crate::filters::Innovation;
use crate::filters::{Expected, Measurement};
use crate::settings::{ContactAngles, NoiseBudget};
use crate::state::{CONTACT_ANGLE, COUNT, PENETRATION, VELOCITY};
use robhaz_model::{Vec2, perp};

impl MotionFilter {
    /// Least speed of the rim over that of its wheel's centre of a wheel that rolls, -: a wheel that
    /// spins has more, one that is dragged less.
    /// Guard.
    const LEAST_TURN: f64 = 0.5;

    /// The measurement of one wheel. With a `budget` its row does not contain the contact angle, whose
    /// error is then one of the measurement, as correlated as the budget has it.
    fn direction(&self, sample: &Sample<'_>, budget: Option<&NoiseBudget>) -> Measurement<4, 4> {
        let (i, wheel, velocity) = (sample.i, sample.wheel, sample.velocity);
        let speed = velocity.smooth_speed;
        let (of_angle, unknown) = match budget {
            None => (speed, GaussMarkov::new(0.0, 1.0)),
            Some(budget) => {
                let (_, sigma) = self.input(CONTACT_ANGLE.of(i));
                (
                    0.0,
                    GaussMarkov::new(speed * sigma, budget.contact_angle_time),
                )
            }
        };
        // An unknown angle follows the wheel within the time of the penetration, which is a state then.
        let process = self.penetration_process();
        let (derivative, penetration) = match self.angles {
            ContactAngles::Given => (0.0, process),
            ContactAngles::Unknown => (1.0, GaussMarkov::new(0.0, process.time)),
        };
        Measurement {
            row: [
                (VELOCITY.of(0), -velocity.direction.y),
                (VELOCITY.of(1), velocity.direction.x),
                (PENETRATION.of(i), derivative),
                (CONTACT_ANGLE.of(i), of_angle),
            ],
            innovation: -velocity.away - self.filter.x[PENETRATION.of(i)],
            white: wheel.joint_noise * wheel.joint_noise,
            correlated: [
                wheel.noise(sample.dt),
                GaussMarkov::new(wheel.bias_sigma, tuning::SLIP.time),
                penetration,
                unknown,
            ],
            inflation: self.inflation_of_rolling(sample.dt),
            gate: GATE,
        }
    }

    /// Variance by which both rolling constraints count less after an impact or at an edge, at
    /// samples every `dt` (s), m^2/s^2.
    pub(super) fn inflation_of_rolling(&self, dt: f64) -> f64 {
        let noise = match self.angles {
            ContactAngles::Given => tuning::IMPACT_NOISE,
            ContactAngles::Unknown => tuning::EDGE_NOISE,
        };
        if self.modes.is_after_impact() {
            noise.white(dt)
        } else {
            0.0
        }
    }

    /// Corrects the states by the direction of one wheel's velocity. Without given contact angles a
    /// wheel beyond [`SIGNIFICANT`] has met an edge. Returns the innovation before the correction.
    pub(super) fn correct_direction_of_wheel(
        &mut self,
        budget: &NoiseBudget,
        sample: &Sample<'_>,
    ) -> Innovation {
        let (i, velocity, dt) = (sample.i, sample.velocity, sample.dt);
        let given = self.angles == ContactAngles::Given;
        // Below the speed at which a velocity has a direction, noise would pass for slopes. And the
        // velocity of a wheel that does not turn is that of a robot that settles or is hit, not a
        // way along the ground.
        let least = (self.least_speed()).max(Self::LEAST_TURN * velocity.smooth_speed.abs());
        let turns = |rim: f64| rim.abs() > least;
        let rolls =
            self.rolls(&velocity) && sample.wheel.turns && sample.wheel.rim_speed.is_none_or(turns);
        let correct = sample.correct && (given || rolls);

        let mut measurement = self.direction(sample, None);
        let mut expected = self.filter.expect(&measurement);
        let found = self.away(i, &velocity, &measurement, &expected);
        if correct && !given && found.nis() > SIGNIFICANT * SIGNIFICANT {
            self.meet_edge(i, &velocity);
            measurement.inflation = self.inflation_of_rolling(dt);
            expected = self.filter.expect(&measurement);
        }
        if correct {
            self.correct(&measurement, &expected, dt);
        } else {
            let velocity_alone = self.direction(sample, Some(budget));
            let expected = self.filter.expect(&velocity_alone);
            self.correct(&velocity_alone, &expected, dt);
        }
        if !given {
            let angle = &mut self.filter.x[CONTACT_ANGLE.of(i)];
            *angle = angle.clamp(-tuning::STEEPEST, tuning::STEEPEST);
        }
        found
    }

    /// The speed away from the ground as the contact states and health judge it: with any speed of
    /// penetration that the ground may cause, not the estimated one, which follows each sample.
    fn away(
        &self,
        i: usize,
        velocity: &ContactVelocity,
        measurement: &Measurement<4, 4>,
        expected: &Expected<COUNT>,
    ) -> Innovation {
        if self.angles == ContactAngles::Given {
            return expected.innovation;
        }
        let stationary = self.penetration_process().sigma;
        Innovation {
            value: -velocity.away,
            variance: self.variance_without(expected, PENETRATION.of(i))
                + measurement.at_once()
                + stationary * stationary,
        }
    }

    /// Variance of a predicted measurement by the states without `state`, whose derivative is 1.
    fn variance_without(&self, expected: &Expected<COUNT>, state: usize) -> f64 {
        let Expected { projection, .. } = expected;
        projection.variance - 2.0 * projection.ph[state] + self.filter.p[state][state]
    }

    /// The velocity of wheel `i` does not lie along its ground, and no contact angle is given.
    ///
    /// A velocity away from the ground shows that the wheel has met an edge: its contact angle
    /// becomes as uncertain as the angle between both. A velocity into the ground is impossible:
    /// another wheel has met an edge, and the velocity of Q is wrong by that much. Without this
    /// distinction a wheel that meets a kerb looks like the other wheels on a downward slope.
    fn meet_edge(&mut self, i: usize, velocity: &ContactVelocity) {
        self.modes.set_impact();
        let away = velocity.away;
        if away > 0.0 {
            let change = (away / velocity.speed).clamp(-tuning::STEEPEST, tuning::STEEPEST);
            self.filter.p[CONTACT_ANGLE.of(i)][CONTACT_ANGLE.of(i)] += change * change;
        } else {
            self.inflate_velocity(perp(velocity.direction) * away);
        }
    }

    /// Adds the square of `error` (m/s) to the covariance of the velocity.
    pub(super) fn inflate_velocity(&mut self, error: Vec2) {
        for (i, a) in [error.x, error.y].into_iter().enumerate() {
            for (j, b) in [error.x, error.y].into_iter().enumerate() {
                self.filter.p[VELOCITY.of(i)][VELOCITY.of(j)] += a * b;
            }
        }
    }
}
