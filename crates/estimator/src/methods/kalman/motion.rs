//! Motion of the robot from the rolling wheels and its acceleration in the readings of the
//! inclinometers, or its standstill.

use super::KalmanFilters;
use crate::common::ROLLING_SPEED;
use crate::contact::{RollingResiduals, SLIPPING_RATIO, StandingDetector};
use crate::deviation::{WITHIN, root_sum_square};
use crate::filters::motion::{CREEP, LINEAR_RATIO, RollingWheel, SLIP, SensedAcceleration};
use crate::filters::{Innovation, LinkAngleKalman};
use crate::frame::Inputs;
use crate::health::Innovations;
use crate::nominal::{Instant, Nominal};
use crate::settings::ContactAngles;
use crate::statics::Arms;
use robhaz_model::{Bar, GRAVITY, Geometry, Robot, perp};

impl KalmanFilters {
    /// Least vertical specific force whose direction is that of gravity, m/s^2: half of gravity.
    /// Guard.
    const LEAST_UPWARD: f64 = 0.5 * GRAVITY;

    /// Finds out whether the wheels spin in place. When that begins, the section of the ground
    /// ends; when it ends, the robot may be moving.
    fn detect_standing(&mut self, instant: &Instant<'_>, arms: &Arms, slopes: &[f64; 3]) {
        let nominal = instant.nominal;
        let before = self.standing.stands;
        let link_angles = self.links.each_ref().map(LinkAngleKalman::angle);
        let rim_speed = |i| self.rim_speed(i, &nominal.robot.geometry).unwrap_or(0.0);
        let rim_speeds = [0, 1, 2].map(rim_speed);
        let deviation = |i: usize| (self.contact_angle(i, instant.inputs) - slopes[i]).abs();
        let deviation = (deviation(0) + deviation(1) + deviation(2)) / 3.0;
        let weight = 3.0 * nominal.mean_load;
        let mut push = self.last_traction.iter().sum::<f64>() / weight;
        if nominal.other_side.is_some() {
            // What the other side may hold shows no obstacle.
            let held = WITHIN * robhaz_model::sqrt(self.push.variance()) / weight;
            push = libm::copysign((push.abs() - held).max(0.0), push);
        }
        let pushes = push.abs() > SLIPPING_RATIO;
        let spin: f64 = self.wheels.iter().map(|wheel| wheel.acceleration).sum();
        let acceleration = nominal.robot.geometry.wheel_radius * spin / (3.0 * GRAVITY);
        let slope = slopes.iter().sum::<f64>() / 3.0;
        let resisted = StandingDetector::resisted(push, acceleration, slope);
        let deviation = deviation.max(resisted);
        let (axles, dt) = (&arms.axles, instant.dt);
        let standing = &mut self.standing;
        let stands = standing.update(link_angles, axles, rim_speeds, deviation, pushes, dt);
        if stands && !before {
            self.ground.end_section();
        } else if before && !stands {
            self.motion.reset_velocity_variance();
        }
    }

    /// Speed of the robot by the encoders of the wheels that have settled, m/s, as if no link turned: 0 without any.
    pub(super) fn encoder_speed(&self, geometry: &Geometry) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for spin in self.wheels.iter().filter_map(|wheel| wheel.settled_speed()) {
            (sum, count) = (sum + geometry.wheel_radius * spin, count + 1.0);
        }
        if count > 0.0 { sum / count } else { 0.0 }
    }

    /// Slopes of the line between the wheels, rad: [`Arms::expected_slopes`], as a steered wheel sees them.
    pub(super) fn slopes_of_line(&self, arms: &Arms) -> [f64; 3] {
        let mut slopes = arms.expected_slopes();
        for (slope, [factor, added]) in slopes.iter_mut().zip(self.across.slope) {
            *slope = *slope * factor + added;
        }
        slopes
    }

    /// Speed of the rim of wheel `i` relative to its axle, m/s, forward positive. `None` before its
    /// observer has settled.
    fn rim_speed(&self, i: usize, geometry: &Geometry) -> Option<f64> {
        let link_rate = self.links[geometry.carriers[i].index()].rate;
        let spin = self.wheels[i].settled_speed();
        spin.map(|spin| geometry.wheel_radius * (spin - link_rate))
    }

    /// Advances motion and wheels, and applies the rolling constraints of loaded wheels, in the
    /// posture of `arms`, unless the wheels spin in place. `inclination` are the innovations of the
    /// inclinometers, rad. Returns the residuals of these constraints.
    pub(super) fn update_motion(
        &mut self,
        instant: &Instant<'_>,
        arms: &Arms,
        inclination: &[Option<f64>; 2],
        innovations: &mut Innovations,
    ) -> [Option<RollingResiduals>; 3] {
        let (nominal, inputs, dt) = (instant.nominal, instant.inputs, instant.dt);
        let (robot, settings) = (&nominal.robot, &nominal.settings);
        let slopes = self.slopes_of_line(arms);
        self.detect_standing(instant, arms, &slopes);
        if dt > 0.0 {
            let fresh = inputs.contact_angle.map(|angle| angle.fresh());
            let measured = self.measured_accelerations(robot, arms);
            self.motion
                .predict(&settings.budget, dt, fresh, &slopes, measured);
        } else {
            self.motion.start_at(&slopes);
        }
        for i in 0..3 {
            let alpha = self.links[robot.geometry.carriers[i].index()].acceleration;
            let wheel = &mut self.wheels[i];
            let innovation = wheel.update(nominal, inputs, i, alpha, dt);
            innovations.encoder[i] = innovation.as_ref().map(Innovation::nis);
        }
        let stands = self.standing.stands;
        if stands {
            self.motion.stand(nominal.mean_load);
        } else if dt > 0.0 && self.method.rolling {
            self.correct_acceleration(nominal, inclination, dt);
        }
        let speed = self.motion.speed();
        for link in &mut self.links {
            link.follow_ground(speed, dt);
        }
        let rolls = |i: usize| dt > 0.0 && self.loaded[i];
        let wheel = |i: usize| rolls(i).then(|| self.rolling_wheel(instant, i, arms));
        let wheels: [_; 3] = core::array::from_fn(wheel);
        let residuals = if stands {
            [0, 1, 2].map(|i| wheels[i].map(|wheel| self.motion.spin_in_place(i, &wheel, dt)))
        } else {
            let correct = self.method.rolling;
            let found = self.motion.roll(&settings.budget, &wheels, dt, correct);
            innovations.direction = found.map(|found| found.map(|found| found.direction_nis()));
            found
        };
        if !stands {
            innovations.slip = slip_nis(&residuals);
            if nominal.other_side.is_some() && !self.across.shares {
                self.follow_turn(nominal, &wheels, &residuals, dt);
            }
        }
        self.last_force_angle = self.force_angle(arms);
        residuals
    }

    /// Accelerations that the last readings show, m/s^2. Of the rims: mean over the wheels of r
    /// domega/dt, from the encoders; opposite signs cancel. Of the links: largest over the wheels
    /// of arm |alpha| + |v_Q| |omega|, from the gyroscopes: the tangential acceleration of the
    /// axle, and the normal acceleration of Q on a curved path; not negative.
    fn measured_accelerations(&self, robot: &Robot, arms: &Arms) -> [f64; 2] {
        let geometry = &robot.geometry;
        let spin: f64 = self.wheels.iter().map(|wheel| wheel.acceleration).sum();
        let speed = self.motion.speed();
        let mut links = 0.0_f64;
        for (carrier, axle) in geometry.carriers.iter().zip(&arms.axles) {
            let link = &self.links[carrier.index()];
            let tangential = robhaz_model::sqrt(axle.norm_squared()) * link.acceleration.abs();
            links = links.max(tangential + speed * link.smooth_rate.abs());
        }
        [geometry.wheel_radius * spin / 3.0, links]
    }

    /// Wheel `i` as the rolling constraints take it, with the forces of the last estimate.
    fn rolling_wheel(&self, instant: &Instant<'_>, i: usize, arms: &Arms) -> RollingWheel {
        let (nominal, inputs) = (instant.nominal, instant.inputs);
        let (geometry, settings) = (&nominal.robot.geometry, &nominal.settings);
        let (link, wheel) = (&self.links[geometry.carriers[i].index()], &self.wheels[i]);
        let (n, t) = (self.last_normal_force[i], self.last_traction[i]);
        let n = nominal.at_least(n);
        let r = geometry.wheel_radius;
        // What all wheels of one side of two slip may be a push of the other one; both together tell it from that.
        let is_shown = nominal.other_side.is_none() || self.across.shares;
        let resisted = if is_shown {
            wheel.resisted(&self.resistance(nominal), self.load(nominal, i))
        } else {
            0.0
        };
        // In the plane slip measurements soon reduce the error of T/N, and the product with it. Beside another side
        // turns and pushes make wheels slip, too.
        let product_time = match nominal.other_side {
            None => self.motion.product_time(),
            Some(_) => SLIP.time,
        };
        let across = perp(arms.axles[i]);
        let arm = robhaz_model::sqrt(across.norm_squared());
        // An unknown contact angle follows the gyroscope's noise, the error of a given one does not.
        let (rate, noise_time) = match self.method.contact_angles {
            ContactAngles::Given => (link.rate, 0.0),
            ContactAngles::Unknown => {
                let speed = self.motion.speed();
                (link.ground_rate, LinkAngleKalman::ground_time(speed))
            }
        };
        let read = inputs.encoder[i].angle.age <= Inputs::STALE_AFTER;
        RollingWheel {
            relative: across * rate + self.across.velocity[i],
            smooth_relative: across * link.smooth_rate + self.across.velocity[i],
            bias_sigma: arm * link.rate_bias_sigma(),
            noise_sigma: arm * settings.budget.rate_noise,
            joint_noise: arm * link.joint_noise,
            across_sigma: self.across.slip[i],
            settled: self.across.settled,
            noise_time,
            angle: inputs.contact_angle[i].value,
            rim_speed: self.rim_speed(i, geometry).filter(|_| read),
            turns: (wheel.settled_speed()).is_none_or(|spin| (r * spin).abs() > ROLLING_SPEED),
            ratio: (t / n).clamp(-1.0, 1.0),
            product_time,
            load_sigma: self.last_sigma[i] / n,
            moment_of_load: r * n,
            resisted,
            torque: wheel.steady_torque(settings.viscous_damping),
            torque_sigma: wheel.ground_torque().1,
            rim_sigma: r * wheel.observer.speed().1,
        }
    }

    /// Finds how far the wheels of one side of a robot with two run apart in a turn.
    fn follow_turn(
        &mut self,
        nominal: &Nominal,
        wheels: &[Option<RollingWheel>; 3],
        residuals: &[Option<RollingResiduals>; 3],
        dt: f64,
    ) {
        /// Relative error of a rolling radius under load, -.
        /// Textbook.
        const RADIUS: f64 = 1e-3;
        let (mut slip, mut creep) = ([0.0; 3], [0.0; 3]);
        let mut of_offset = 0.0_f64;
        let budget = &nominal.settings.budget;
        for i in 0..3 {
            let (Some(wheel), Some(found)) = (&wheels[i], residuals[i].and_then(|r| r.slip)) else {
                return;
            };
            if wheel.ratio.abs() > LINEAR_RATIO {
                // It may slide.
                return;
            }
            // By the torque as read: what the states have made of it may already explain a turn.
            let speed = self.motion.creep(i).max(libm::exp(CREEP));
            let over_load = speed / wheel.moment_of_load;
            slip[i] = found.beyond_creep + found.creep;
            creep[i] = wheel.torque * over_load;
            of_offset = of_offset.max(budget.torque_offset * over_load);
        }
        self.turn.update(slip, creep, dt);
        let radius = root_sum_square(budget.wheel_radius, RADIUS) * self.motion.speed();
        let error = root_sum_square(of_offset, radius);
        self.across.slip = [self.turn.sigma(error); 3];
        self.across.turns = self.turn.turns(error);
    }

    /// Corrects the motion by the innovations of the inclinometers (rad), `dt` seconds after the
    /// last sample.
    fn correct_acceleration(&mut self, nominal: &Nominal, innovation: &[Option<f64>; 2], dt: f64) {
        let budget = &nominal.settings.budget;
        if !budget.specific_force {
            return;
        }
        let upward = (GRAVITY + self.motion.acceleration().y).max(Self::LEAST_UPWARD);
        let noise = upward * budget.inclinometer_noise();
        let readings = [0, 1].map(|k: usize| {
            let link = &self.links[k];
            innovation[k].map(|angle| {
                let of_place = budget.inclination_place * link.acceleration;
                let of_lag = upward * link.late(budget);
                SensedAcceleration {
                    innovation: upward * angle,
                    white: noise * noise,
                    of_angle: upward * link.settled_sigma(),
                    of_turning: root_sum_square(of_place, of_lag),
                }
            })
        });
        self.motion.correct_acceleration(&readings, dt);
    }

    /// Angle between the specific force and gravity at the centres of mass of links 1 and 2, rad,
    /// in the posture of `arms`.
    fn force_angle(&self, arms: &Arms) -> [f64; 2] {
        [(0, Bar::Link1), (1, Bar::Link2)].map(|(k, bar): (usize, Bar)| {
            let (link, arm) = (&self.links[k], arms.centres[bar as usize]);
            let rate = link.smooth_rate;
            let force =
                self.motion.acceleration() + perp(arm) * link.acceleration - arm * (rate * rate);
            let along = force.x + self.across.of_sensor;
            along / (GRAVITY + force.y).max(Self::LEAST_UPWARD)
        })
    }
}

/// Normalised innovations squared of the speed constraints, each relative to the middle one of the
/// three wheels: an error of the robot's speed is common to all and shows no wheel. See
/// [`SlipResidual::nis_beside`]. `None` unless all three constraints apply.
fn slip_nis(residuals: &[Option<RollingResiduals>; 3]) -> [Option<f64>; 3] {
    let slip = |r: &Option<RollingResiduals>| r.and_then(|r| r.slip);
    let [Some(a), Some(b), Some(c)] = residuals.each_ref().map(slip) else {
        return [None; 3];
    };
    let ordered = a.beyond_creep < b.beyond_creep;
    let (low, high) = if ordered { (a, b) } else { (b, a) };
    let middle = if c.beyond_creep < low.beyond_creep {
        low
    } else if c.beyond_creep > high.beyond_creep {
        high
    } else {
        c
    };
    [a, b, c].map(|slip| Some(slip.nis_beside(&middle)))
}
