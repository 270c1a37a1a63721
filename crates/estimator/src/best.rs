//! The filters of `best`: Kalman filters for link angles, ground torques and what hides behind the readings.

use crate::arms::Arms;
use crate::equilibrium::Loads;
use crate::estimate::{Estimate, EstimateError, Parity, ReadingErrors};
use crate::estimator::LONGEST_GAP;
use crate::flags::Flags;
use crate::forces::{RightSide, solve};
use crate::frame::Inputs;
use crate::linkage::LinkAngleKalman;
use crate::motion::{MotionFilter, Rolling, state};
use crate::sensitivity::{Sensitivity, Traction};
use crate::settings::{EstimatorSettings, NoiseBudget};
use crate::told::{Instant, Told};
use crate::torque_observer::{COUNT_SIGMA, TorqueObserver, TorqueObserverParameters};
use crate::visit::visit_fields;
use nalgebra::Matrix4;
use robhaz_model::{Robot, perp};

/// Filters of links, wheels and motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BestFilters {
    pub links: [LinkAngleKalman; 2],
    wheels: [TorqueObserver; 3],
    pub motion: MotionFilter,
    /// Torques read with the last frame, N m.
    last_torque: [f64; 3],
    /// Spin speeds at the last frame, rad/s.
    last_speed: [f64; 3],
    /// How much of the gears' friction acts, -1 to 1: now, and at the frame before.
    turning: [f64; 3],
    last_turning: [f64; 3],
    /// Smoothed derivatives of the spin speeds, rad/s^2.
    pub spin_acceleration: [f64; 3],
    /// Forces of the last estimate, N.
    pub last_normal_force: [f64; 3],
    pub last_traction: [f64; 3],
    /// Time for which the parity residual has been beyond its gate without a break, s.
    misfit: f64,
}

visit_fields!(BestFilters: links, wheels, motion, last_torque, last_speed, turning, last_turning, spin_acceleration,
    last_normal_force, last_traction, misfit);

impl BestFilters {
    /// Smoothing of the spin acceleration, s, with a count of 40 urad; finer ones are smoothed less, down to the second. The inertia of the
    /// wheel discs is small.
    const SMOOTHING: (f64, f64) = (0.02, 0.001);
    /// Speed over which gear friction comes in once the direction is sure, rad/s: 1 mm/s at the rim.
    const FRICTION_SPEED: f64 = 0.01;
    /// Standard deviations of an observed speed below which it tells nothing of its direction; at about twice as many friction is
    /// all there. A wheel at rest whose speed trembles about zero would else seem to turn, now forwards, now backwards, and to tell
    /// that there is no friction.
    const TREMBLING: f64 = 5.0;
    /// Time of misfit after which what was found of motion and errors is thrown away, s: longer than any impact. Else errors
    /// found from false readings would keep the gate shut against the true ones for good.
    const LONGEST_MISFIT: f64 = 1.0;
    /// Walk of a torque while no sensor reads it, N m/sqrt(s).
    const TORQUE_UNSEEN: f64 = 5.0;
    /// Part of the mean load below which a wheel is not believed to roll.
    pub const UNLOADED: f64 = 0.05;

    pub fn new(robot: &Robot, budget: &NoiseBudget) -> Self {
        Self {
            links: [LinkAngleKalman::new(budget); 2],
            wheels: [TorqueObserver::new(); 3],
            motion: MotionFilter::new(budget),
            last_torque: [0.0; 3],
            last_speed: [0.0; 3],
            turning: [0.0; 3],
            last_turning: [0.0; 3],
            spin_acceleration: [0.0; 3],
            last_normal_force: [robot.mean_wheel_load(); 3],
            last_traction: [0.0; 3],
            misfit: 0.0,
        }
    }

    /// The robot may be moving already: for a start after a gap.
    pub fn forget_motion(&mut self) {
        self.wheels = [TorqueObserver::turning(); 3];
        self.motion.forget_velocity();
    }

    /// How much of the gears' friction acts on a wheel that spins with `speed`, known to `sigma` (rad/s): -1 to 1.
    fn turning(speed: f64, sigma: f64) -> f64 {
        let trembling = Self::TREMBLING * sigma;
        let sure = (speed.abs() - trembling).max(0.0);
        let all_there = Self::FRICTION_SPEED * Self::FRICTION_SPEED + trembling * trembling;
        libm::copysign((sure / libm::sqrt(all_there)).min(1.0), speed)
    }

    /// What the last readings show of accelerations, m/s^2: of the rims, all together, and of the axle that its link swings most.
    fn shown_accelerations(&self, robot: &Robot, arms: &Arms) -> (f64, f64) {
        let geometry = &robot.geometry;
        let spin: f64 = self.spin_acceleration.iter().sum();
        let speed = libm::sqrt(self.motion.velocity().norm_squared());
        let mut swung = 0.0_f64;
        for (carrier, axle) in geometry.carriers.iter().zip(&arms.axles) {
            let (rate, acceleration) = self.links[carrier.index()].turning();
            let along = libm::sqrt(axle.norm_squared()) * acceleration.abs();
            swung = swung.max(along + speed * rate.abs());
        }
        (geometry.wheel_radius * spin / 3.0, swung)
    }

    /// Link angles: the first step of a frame.
    pub fn turn(&mut self, budget: &NoiseBudget, inputs: &Inputs, dt: f64) -> [f64; 2] {
        let forward = self.motion.acceleration().x;
        for i in 0..2 {
            let (rate, inclination) = (inputs.rate[i], inputs.inclination[i]);
            let read = rate.fresh().then_some(rate.value);
            let link = &mut self.links[i];
            if link.started() {
                let tilt = inclination.fresh().then_some(inclination.value);
                link.update(budget, dt, read, tilt, forward);
            } else {
                link.start(inclination.value, inclination.age, read.unwrap_or(0.0));
            }
        }
        [self.links[0].angle(), self.links[1].angle()]
    }

    /// Ground torques and motion, in the posture of `arms`: the second step.
    pub fn roll(
        &mut self,
        robot: &Robot,
        settings: &EstimatorSettings,
        inputs: &Inputs,
        arms: &Arms,
        dt: f64,
    ) {
        let budget = &settings.budget;
        if dt > 0.0 {
            let seen = inputs.contact_angle.map(|angle| angle.fresh());
            let (pushed, shaken) = self.shown_accelerations(robot, arms);
            self.motion.predict(budget, dt, seen, pushed, shaken);
        }
        for i in 0..3 {
            self.observe_wheel(i, robot, settings, inputs, dt);
            let loaded = self.last_normal_force[i] > Self::UNLOADED * robot.mean_wheel_load();
            if dt > 0.0 && loaded {
                let rolling = self.rolling(i, robot, settings, inputs, arms);
                self.motion.roll(budget, i, &rolling, dt, settings.rolling);
            }
        }
    }

    /// Spin and ground torque of wheel `i`.
    fn observe_wheel(
        &mut self,
        i: usize,
        robot: &Robot,
        settings: &EstimatorSettings,
        inputs: &Inputs,
        dt: f64,
    ) {
        let budget = &settings.budget;
        let link = &self.links[robot.geometry.carriers[i].index()];
        let torque = inputs.motor_torque[i];
        let parameters = TorqueObserverParameters {
            wheel_inertia: robot.mass.wheel_inertia,
            rotor_inertia: robot.mass.rotor_inertia,
            viscous_damping: settings.viscous_damping,
            encoder_sigma: encoder_sigma(budget, self.last_speed[i]),
            torque_sigma: budget.torque_noise,
            step: budget.gear_friction * (self.turning[i] - self.last_turning[i]),
            unseen: if torque.fresh() {
                0.0
            } else {
                Self::TORQUE_UNSEEN
            },
        };
        let wheel = &mut self.wheels[i];
        if inputs.new_zero[i] {
            wheel.forget_angle();
        }
        if inputs.wheel_angle[i].age > LONGEST_GAP {
            *wheel = TorqueObserver::turning();
        } else if dt > 0.0 {
            let mean = 0.5 * (torque.value + self.last_torque[i]);
            wheel.predict(&parameters, dt, mean, link.turning().1);
        }
        self.last_torque[i] = torque.value;
        self.last_turning[i] = self.turning[i];
        if inputs.wheel_angle[i].fresh() {
            wheel.measure(&parameters, inputs.wheel_angle[i].value);
        }
        let speed = wheel.speed();
        if dt > 0.0 && wheel.settled() {
            let (longest, shortest) = Self::SMOOTHING;
            let smoothing = longest * (parameters.encoder_sigma / COUNT_SIGMA);
            let weight = dt / (smoothing.max(shortest).min(longest) + dt);
            let rate = (speed - self.last_speed[i]) / dt;
            self.spin_acceleration[i] += weight * (rate - self.spin_acceleration[i]);
        }
        self.last_speed[i] = speed;
        self.turning[i] = Self::turning(speed, wheel.speed_sigma());
    }

    /// Wheel `i` as the filter of the motion sees it.
    fn rolling(
        &self,
        i: usize,
        robot: &Robot,
        settings: &EstimatorSettings,
        inputs: &Inputs,
        arms: &Arms,
    ) -> Rolling {
        let (geometry, budget) = (&robot.geometry, &settings.budget);
        let (link, wheel) = (&self.links[geometry.carriers[i].index()], &self.wheels[i]);
        let (n, t) = (self.last_normal_force[i], self.last_traction[i]);
        let r = geometry.wheel_radius;
        let (ground_torque, torque_sigma) = wheel.ground_torque();
        let across = perp(arms.axles[i]);
        let arm = libm::sqrt(across.norm_squared());
        let told = wheel.settled() && inputs.wheel_angle[i].age <= Inputs::STALE_AFTER;
        Rolling {
            relative: across * link.rate(),
            smooth_relative: across * link.turning().0,
            angle: inputs.contact_angle[i].value,
            rim_speed: told.then(|| r * (wheel.speed() - link.rate())),
            ratio: (t / n).clamp(-1.0, 1.0),
            moment_of_load: r * n,
            turning: self.turning[i],
            relative_sigma: (arm * link.rate_bias().1, arm * budget.rate_noise),
            torque: ground_torque + settings.viscous_damping * wheel.speed(),
            torque_sigma,
        }
    }

    /// Contact angle of wheel `i` with the error found taken off, rad.
    pub fn contact_angle(&self, i: usize, given: f64) -> f64 {
        given - self.motion.filter.x[state::CONTACT_ANGLE + i]
    }

    /// Traction of wheel `i` with the errors found taken off. Friction in a gear whose direction is unknown may hold any part of it.
    pub fn traction(&self, i: usize, settings: &EstimatorSettings, wheel_radius: f64) -> Traction {
        let x = &self.motion.filter.x;
        let (torque, observed) = self.wheels[i].ground_torque();
        let (speed, viscous_damping) = (self.last_speed[i], settings.viscous_damping);
        // The torque read but for what accelerates the rotor: smooth, and good enough to scale an error of 2 %.
        let read = torque + viscous_damping * speed;
        let turning = self.turning[i];
        let errors = x[state::TORQUE_OFFSET + i]
            + x[state::GEAR_FRICTION] * turning
            + x[state::TORQUE_GAIN + i] * read;
        let inverse = 1.0 / wheel_radius;
        let held = settings.budget.gear_friction * settings.budget.gear_friction;
        let sigma = libm::sqrt(observed * observed + (1.0 - turning * turning) * held);
        Traction {
            value: (torque - errors) * inverse,
            sigma: sigma * inverse,
            by_offset: -inverse,
            by_friction: -turning * inverse,
            by_gain: -read * inverse,
        }
    }

    /// Everything that the readings say.
    pub fn estimate(
        &mut self,
        told: &Told,
        instant: &Instant<'_>,
    ) -> Result<Estimate, EstimateError> {
        let (robot, settings) = (&told.robot, &told.settings);
        let (geometry, budget) = (&robot.geometry, &settings.budget);
        let mut flags = instant.flags;
        let angles = self.turn(budget, instant.inputs, instant.dt);
        let arms = Arms::new(geometry, angles[0], angles[1]).map_err(EstimateError::Linkage)?;
        self.roll(robot, settings, instant.inputs, &arms, instant.dt);

        let contact_angle =
            [0, 1, 2].map(|i| self.contact_angle(i, instant.inputs.contact_angle[i].value));
        let loads = if settings.inertia {
            let [(w1, a1), (w2, a2)] = self.links.map(|link| link.turning());
            let turning = arms.turning([w1, w2], [a1, a2]);
            let q = self.motion.acceleration();
            let spin = &self.spin_acceleration;
            Loads::moving(
                &robot.mass,
                &told.masses,
                &arms,
                &geometry.carriers,
                q,
                &turning,
                spin,
            )
        } else {
            Loads::at_rest(&told.masses)
        };
        let statics = told.statics(arms, angles, loads, &contact_angle)?;
        let equilibrium = &statics.equilibrium;

        let tractions = [0, 1, 2].map(|i| self.traction(i, settings, geometry.wheel_radius));
        let mut right = RightSide {
            value: equilibrium.right_side(&tractions.map(|t| t.value)),
            sensitivity: &Sensitivity::new(told, &statics, &tractions),
            tractions: &tractions,
            loads: told.load_noise(&statics),
        };

        // The parity residual corrects the states; right side and tractions follow them.
        let mut parity = None;
        let mut corrected = tractions;
        if let Some(w) = statics.parity {
            let value = w.dot(&right.value);
            let along = right.sensitivity.along(&w);
            let variance = w.dot(&(right.noise(equilibrium) * w));
            let before = self.motion.filter.x;
            let correct = settings.parity && instant.dt > 0.0;
            let (innovation, within_gate) =
                self.motion
                    .parity(&along, value, variance, instant.dt.max(1e-6), correct);
            let unexplained = self.motion.unexplained();
            right.loads += Matrix4::from_diagonal_element(unexplained);
            for (k, column) in right.sensitivity.columns.iter().enumerate() {
                let place = state::ACCELERATION + k;
                right.value += column * (self.motion.filter.x[place] - before[place]);
            }
            for (i, traction) in corrected.iter_mut().enumerate() {
                *traction = self.traction(i, settings, geometry.wheel_radius);
            }
            if within_gate {
                self.misfit = 0.0;
            } else {
                flags |= Flags::OUT_OF_RANGE;
                self.misfit += instant.dt;
            }
            parity = Some(Parity {
                value,
                sigma: libm::sqrt(innovation.variance),
            });
        }
        right.tractions = &corrected;
        let use_parity = statics.parity.filter(|_| settings.whitening);
        let mut forces = solve(
            equilibrium,
            &statics.inverse,
            use_parity,
            &right,
            &self.motion,
        );
        let value = right.value;
        if self.misfit > Self::LONGEST_MISFIT {
            self.motion = MotionFilter::new(budget);
            self.motion.forget_velocity();
            self.misfit = 0.0;
        }
        self.last_normal_force = forces.normal;
        self.last_traction = forces.traction;
        flags |= told.unloaded(&forces.normal) | told.at_stop(angles);
        if settings.nonnegative {
            forces.without_pull();
        }

        let (motion, links) = (&self.motion, &self.links);
        let mut estimate = told.estimate(instant, &statics, &forces, &value, parity, flags);
        estimate.covariance = Some(forces.covariance);
        estimate.angle_sigma = Some([links[0].angle_sigma(budget), links[1].angle_sigma(budget)]);
        estimate.reading_errors = Some(ReadingErrors {
            torque_offset: [0, 1, 2].map(|i| motion.found(state::TORQUE_OFFSET + i)),
            gear_friction: motion.found(state::GEAR_FRICTION),
            contact_angle: [0, 1, 2].map(|i| motion.found(state::CONTACT_ANGLE + i)),
            rate_bias: links.map(|link| link.rate_bias()),
        });
        Ok(estimate)
    }
}

/// Standard deviation of a wheel angle, rad: the count, uniform over its width, and the time stamp's error at this speed.
fn encoder_sigma(budget: &NoiseBudget, speed: f64) -> f64 {
    // 1/sqrt(12) of a count; a twentieth of a micrometre at the rim at least, so that an exact angle does not make the filter deaf.
    const UNIFORM: f64 = 0.288_675_134_594_812_9;
    const LEAST: f64 = 5e-7;
    let count = if budget.encoder_counts > 0.0 {
        2.0 * core::f64::consts::PI / budget.encoder_counts * UNIFORM
    } else {
        0.0
    };
    libm::hypot(count.max(LEAST), speed * budget.jitter)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{LinkReading, SensorFrame};
    use crate::motion::SENSITIVE;
    use crate::testing::Random;
    use crate::{Estimator, Flags};
    use proptest::prelude::*;

    proptest! {
        /// The columns are the derivatives of `y - H_N N` (N held) by each state, everything recomputed from the changed state.
        /// Central differences at h = 1e-6 err by 1e-9 of 100 N; what is linear errs by rounding over h, 1e-8.
        #[test]
        fn sensitivity_is_the_derivative(
            theta in prop::array::uniform2(-0.25_f64..0.25), slopes in prop::array::uniform3(-0.4_f64..0.4),
            states in prop::collection::vec(-0.1_f64..0.1, SENSITIVE), torques in prop::array::uniform3(-3.0_f64..3.0),
            speeds in prop::array::uniform3(-0.02_f64..0.02),
        ) {
            let told = Told::new(&Robot::default_a(), EstimatorSettings::best());
            let geometry = &told.robot.geometry;
            let mut filters = BestFilters::new(&told.robot, &told.settings.budget);
            for i in 0..3 {
                let parameters = TorqueObserverParameters {
                    wheel_inertia: 0.0075, rotor_inertia: 0.0864, viscous_damping: 0.15,
                    encoder_sigma: 1e-5, torque_sigma: 0.1, step: 0.0, unseen: 0.0,
                };
                filters.wheels[i].measure(&parameters, 0.0);
                for k in 1..200 {
                    filters.wheels[i].predict(&parameters, 1e-3, torques[i], 0.0);
                    filters.wheels[i].measure(&parameters, speeds[i] * 1e-3 * f64::from(k));
                }
                filters.last_speed[i] = speeds[i];
                filters.turning[i] = BestFilters::turning(speeds[i], 1e-4);
            }
            for (k, value) in states.iter().enumerate() {
                filters.motion.filter.x[state::ACCELERATION + k] = *value;
            }
            let arms = Arms::new(geometry, theta[0], theta[1]).expect("inside the stops");
            let statics_of = |filters: &BestFilters| {
                let turning = arms.turning([0.3, -0.2], [1.0, 2.0]);
                let loads = Loads::moving(&told.robot.mass, &told.masses, &arms, &geometry.carriers,
                    filters.motion.acceleration(), &turning, &[0.0; 3]);
                let angles = [0, 1, 2].map(|i| filters.contact_angle(i, slopes[i]));
                let tractions = [0, 1, 2].map(|i| filters.traction(i, &told.settings, geometry.wheel_radius));
                let statics = told.statics(arms, theta, loads, &angles).expect("regular");
                (statics, tractions)
            };
            let (statics, tractions) = statics_of(&filters);
            let found = Sensitivity::new(&told, &statics, &tractions);
            let right = statics.equilibrium.right_side(&tractions.map(|t| t.value));
            let normal = statics.inverse.solve(&right);
            let h = 1e-6;
            for k in 0..SENSITIVE {
                let at = |change: f64| {
                    let mut filters = filters;
                    filters.motion.filter.x[state::ACCELERATION + k] += change;
                    let (statics, tractions) = statics_of(&filters);
                    let e = &statics.equilibrium;
                    let mut left = e.right_side(&tractions.map(|t| t.value));
                    for i in 0..3 {
                        left -= e.h_n[i] * normal[i];
                    }
                    left
                };
                let difference = (at(h) - at(-h)) / (2.0 * h);
                prop_assert!((found.columns[k] - difference).norm() < 1e-5, "state {k}: {} {difference}", found.columns[k]);
            }
        }
    }

    /// Readings of a robot at rest on level ground. Inclinometers and gyroscopes have their white noise; torques have none, which would
    /// let the observed speeds tremble around zero and so tell of friction in gears that do not turn.
    fn at_rest(
        time: f64,
        torque: [f64; 3],
        budget: &NoiseBudget,
        random: &mut Random,
    ) -> SensorFrame {
        let mut link = || LinkReading {
            inclination: Some(budget.inclination_noise * random.normal()),
            rate: Some(budget.rate_noise * random.normal()),
        };
        let (link1, link2) = (link(), link());
        SensorFrame {
            time,
            wheel_angle: [Some(0.0); 3],
            motor_torque: torque.map(Some),
            link1,
            link2,
            contact_angle: [Some(0.0); 3],
        }
    }

    /// At rest, without the laws of rolling, only the parity tells of torque offsets, and on level ground it holds their sum
    /// (the horizontal row; moments about Q weigh them alike within the arms' differences). The sum is found; of their differences, of
    /// gear friction (nothing turns) and of gains the filter keeps its prior: standard deviations do not fall, values stay.
    #[test]
    fn what_can_be_known_is_found_and_the_rest_keeps_its_prior() {
        let settings = EstimatorSettings {
            rolling: false,
            ..EstimatorSettings::best()
        };
        let budget = &settings.budget;
        let mut estimator = Estimator::new(&Robot::default_a(), settings);
        let mut random = Random::new();
        let offsets = [0.15, 0.05, 0.10];
        let mut last = None;
        for k in 0..20_000 {
            let frame = at_rest(1e-3 * f64::from(k), offsets, budget, &mut random);
            let estimate = estimator.update(&frame).expect("complete frames");
            assert_eq!(estimate.flags, Flags::NONE, "{k}");
            last = Some(estimate);
        }
        let errors = last
            .and_then(|e| e.reading_errors)
            .expect("best finds errors");
        let found = errors.torque_offset;
        let sum: f64 = found.iter().map(|f| f.0).sum();
        let sum_of_sigma: f64 = found.iter().map(|f| f.1).sum();
        // Contact angles off by 2 deg under 45 N push as 0.27 N m over all wheels would; over 20 s they average to a tenth.
        assert!((sum - 0.3).abs() < 0.06, "{found:?}");
        let p = offset_covariance(&estimator);
        let variance = |u: [f64; 3]| {
            let mut sum = 0.0;
            for i in 0..3 {
                for j in 0..3 {
                    sum += u[i] * u[j] * p[i][j];
                }
            }
            sum
        };
        let prior = budget.torque_offset * budget.torque_offset;
        assert!(
            variance([1.0; 3]) < 0.1 * 3.0 * prior,
            "{}",
            variance([1.0; 3])
        );
        assert!(
            variance([1.0, 0.0, -1.0]) > 0.8 * 2.0 * prior,
            "{}",
            variance([1.0, 0.0, -1.0])
        );
        assert!((found[0].0 - found[2].0).abs() < 0.02, "{found:?}");
        assert!(sum_of_sigma > 2.0 * budget.torque_offset);
        let (friction, sigma) = errors.gear_friction;
        // The first frames, before the observed speeds have settled, tell a little.
        assert!(
            friction.abs() < 0.01 && sigma > 0.99 * budget.gear_friction,
            "{friction} +- {sigma}"
        );
    }

    /// Covariance of the torque offsets of an estimator `best`.
    fn offset_covariance(estimator: &Estimator) -> [[f64; 3]; 3] {
        let p = &estimator.best_filters().expect("best").motion.filter.p;
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| p[state::TORQUE_OFFSET + i][state::TORQUE_OFFSET + j]))
    }
}
