//! Eq. (8) with the estimated loads, contact angles and tractions; its parity residual; and what a
//! linkage costs that turns faster than its filters follow, as on facets and corners.

use super::KalmanFilters;
use crate::common::DRIVING_SPEED;
use crate::deviation::root_sum_square;
use crate::estimate::{EstimateError, Parity};
use crate::filters::motion::ParityResidual;
use crate::filters::{GaussMarkov, LinkAngleKalman};
use crate::flags::Flags;
use crate::frame::{Inputs, SHORTEST_STEP};
use crate::nominal::{Instant, Nominal};
use crate::resistance::Resistance;
use crate::state;
use crate::statics::{
    Arms, Equations, Equilibrium, Forces, LinkageMotion, Loads, OtherSide, RightSide, Sensitivity,
    Traction, sensitivity,
};
use nalgebra::Matrix4;
use robhaz_model::{Geometry, Vec2, cross};

impl KalmanFilters {
    /// Eq. (8) for the estimated loads and contact angles.
    #[inline(always)]
    pub(super) fn equations(
        &self,
        nominal: &Nominal,
        inputs: &Inputs,
        arms: Arms,
        link_angles: [f64; 2],
    ) -> Result<Equations, EstimateError> {
        let accelerations = self.links.each_ref().map(|link| link.acceleration);
        let loads = self.loads(nominal, &arms, accelerations);
        let angle = |i| self.contact_angle(i, inputs);
        let contact_angle = [angle(0), angle(1), angle(2)];
        let coefficient = self.resistance(nominal).coefficient();
        let ahead = self.rolling_arms(nominal).map(|arm| coefficient * arm);
        nominal.equations(arms, link_angles, loads, &contact_angle, &ahead)
    }

    /// Gravity, and inertia if `method.inertia`, for angular accelerations of links 1 and 2,
    /// rad/s^2.
    pub(super) fn loads(&self, nominal: &Nominal, arms: &Arms, accelerations: [f64; 2]) -> Loads {
        let heavier = self.scale.applied;
        if !self.method.inertia {
            return Loads::at_rest(&nominal.masses).of_heavier(heavier);
        }
        let robot = &nominal.robot;
        let rates = self.links.each_ref().map(|link| link.smooth_rate);
        let motion = LinkageMotion {
            q: self.motion.acceleration(),
            turning: arms.turning(rates, accelerations),
            spin: self.wheels.each_ref().map(|wheel| wheel.acceleration),
        };
        let carriers = &robot.geometry.carriers;
        let (mass, masses, gravity) = (&robot.mass, &nominal.masses, robot.gravity);
        Loads::moving(mass, masses, arms, carriers, &motion, gravity).of_heavier(heavier)
    }

    /// Given contact angle of wheel `i` (0 where none is given) minus its estimated error, rad.
    pub(super) fn contact_angle(&self, i: usize, inputs: &Inputs) -> f64 {
        inputs.contact_angle[i].value - self.motion.input(state::CONTACT_ANGLE.of(i)).0
    }

    /// Tractions corrected for the estimated errors of the torque readings.
    pub(super) fn tractions(&self, nominal: &Nominal) -> [Traction; 3] {
        let resistance = self.resistance(nominal);
        let traction = |i: usize| {
            let (wheel, load) = (&self.wheels[i], self.load(nominal, i));
            let torque = wheel.steady_torque(nominal.settings.viscous_damping);
            let resisted = wheel.resisted(&resistance, load);
            let error = self.motion.torque_error(i, torque, resisted);
            wheel.traction(nominal, &resistance, load, error)
        };
        [traction(0), traction(1), traction(2)]
    }

    /// Gear friction and rolling resistance as of now.
    pub(super) fn resistance(&self, nominal: &Nominal) -> Resistance {
        let sum = self.motion.input(state::RESISTANCE.of(0));
        Resistance::new(&nominal.settings.budget, sum)
    }

    /// Load of wheel `i` as of the last estimate over the mean one; not below 0.
    pub(super) fn load(&self, nominal: &Nominal, i: usize) -> f64 {
        self.last_normal_force[i].max(0.0) / nominal.mean_load
    }

    /// [`Wheel::rolling_left`] of each wheel: those of all that turn err alike, and those that rest.
    pub(super) fn rolling_left(&self, nominal: &Nominal) -> [[f64; 3]; 2] {
        let resistance = self.resistance(nominal);
        let left = (self.wheels.each_ref()).map(|wheel| wheel.rolling_left(&resistance));
        [0, 1].map(|k: usize| left.map(|of_wheel| of_wheel[k]))
    }

    /// Distances by which N acts ahead of the contacts at a coefficient of rolling resistance of 1, m:
    /// the wheel radius times the smoothed sign of the spin.
    pub(super) fn rolling_arms(&self, nominal: &Nominal) -> [f64; 3] {
        let radius = nominal.robot.geometry.wheel_radius;
        (self.wheels.each_ref()).map(|wheel| radius * wheel.friction_share)
    }

    /// Right-hand side of eq. (8) for the estimated tractions, with its sensitivity at the last
    /// forces.
    pub(super) fn right_side(&self, nominal: &Nominal, equations: &Equations) -> RightSide {
        let tractions = self.tractions(nominal);
        let inertial = self.method.inertia.then_some(&nominal.masses);
        let lever = nominal.settings.moment_lever;
        let geometry = &nominal.robot.geometry;
        let equilibrium = &equations.equilibrium;
        let about = (&self.last_normal_force, &self.last_traction);
        let rate = self.resistance(nominal).coefficient_rate();
        let ahead = self.rolling_arms(nominal).map(|arm| rate * arm);
        RightSide {
            value: equilibrium.right_side(&tractions.map(|t| t.value)),
            sensitivity: sensitivity(
                geometry, equations, &tractions, about, &ahead, inertial, lever,
            ),
            tractions,
            loads: nominal.load_noise(equations),
        }
    }

    /// Adds the push of the other side of a robot with two to the covariance of the rows. What the
    /// parity residual shows of it counts while the robot drives. Returns the variance of the
    /// residual by it, N^2.
    pub(super) fn consider_push(
        &mut self,
        instant: &Instant<'_>,
        equations: &Equations,
        right: &mut RightSide,
    ) -> f64 {
        let nominal = instant.nominal;
        let Some(other) = &nominal.other_side else {
            return 0.0;
        };
        let (geometry, lever) = (&nominal.robot.geometry, nominal.settings.moment_lever);
        let [by_push, turns] = other.by_push(&equations.arms, &geometry.carriers, lever);
        let seen_by = equations.parity_direction.map_or(0.0, |w| w.dot(&by_push));
        let square = seen_by * seen_by;
        let drives = self.motion.velocity().norm_squared() > DRIVING_SPEED * DRIVING_SPEED;
        if let Some(w) = equations.parity_direction
            && drives
            && square > 0.0
        {
            let residual = w.dot(&right.value);
            let noise = right.noise_along(&equations.equilibrium, &w);
            let seen = (residual * residual - noise) / square;
            self.push.update(seen, instant.dt);
        }
        let variance = self.push.variance();
        let of_push = by_push * by_push.transpose() + turns * turns.transpose();
        right.loads += of_push * variance;
        square * variance
    }

    /// Adds what ground that is uneven across does to one side of a robot with two four-bars to the covariance of N.
    pub(super) fn consider_twist(
        &mut self,
        instant: &Instant<'_>,
        equations: &Equations,
        forces: &mut Forces,
    ) {
        /// Least compression of a wheel under its load, over its radius: hard rubber, 1 mm of 100 mm.
        /// Textbook.
        const HARD: f64 = 0.01;
        let nominal = instant.nominal;
        let Some(other) = nominal.other_side.filter(OtherSide::twists) else {
            return;
        };
        let (arms, geometry) = (&equations.arms, &nominal.robot.geometry);
        let height = MiddleWheel::new(geometry, arms);
        let sigma = self.links.each_ref().map(LinkAngleKalman::settled_sigma);
        let way = robhaz_model::sqrt(self.motion.velocity().norm_squared()) * instant.dt;
        let noise = height.sigma(sigma);
        let given = nominal.settings.compression;
        let given = given.max(HARD * geometry.wheel_radius);
        self.unevenness
            .update(height.above, noise * noise, given, way, height.length);
        let bias = nominal.settings.budget.inclination_bias;
        let square = self.unevenness.square(height.sigma([bias; 2]));
        let lever = nominal.settings.moment_lever;
        let rows = other.by_twist(arms, &geometry.carriers, lever, (square, given));
        forces.consider(&equations.inverse, &rows);
    }

    /// Tests the parity residual against its predicted standard deviation. If `method.parity`, the
    /// residual corrects the states, and the right-hand side is corrected to first order with H_N
    /// unchanged. Unmodelled load adds to the noise; `of_push` is the residual's variance by the push
    /// of the other side, N^2.
    ///
    /// Returns the residual and the flags that it raises; `None` where the contacts leave the
    /// parity undefined.
    pub(super) fn check_parity(
        &mut self,
        instant: &Instant<'_>,
        equations: &Equations,
        right: &mut RightSide,
        of_push: f64,
    ) -> Option<(Parity, Flags)> {
        let w = equations.parity_direction?;
        let residual = ParityResidual {
            value: w.dot(&right.value),
            gradient: right.sensitivity.map(|column| w.dot(&column)),
            variance: right.noise_along(&equations.equilibrium, &w),
            observed: [0, 1, 2].map(|i: usize| {
                let traction = &right.tractions[i];
                let along = w.dot(&equations.equilibrium.h_t[i]);
                GaussMarkov::new(along.abs() * traction.observed, traction.lasts)
            }),
            of_push,
        };
        let before = self.motion.inputs();
        let correct = self.method.parity && instant.dt > 0.0;
        let dt = instant.dt.max(SHORTEST_STEP);
        let (innovation, within_gate) = self.motion.check_parity(&residual, dt, correct);

        right.loads += Matrix4::from_diagonal_element(self.motion.unmodelled_load());
        if correct && within_gate {
            let after = self.motion.inputs();
            for (k, column) in right.sensitivity.iter().enumerate() {
                right.value += column * (after[k] - before[k]);
            }
            right.tractions = self.tractions(instant.nominal);
        }
        let beyond = self.time_beyond_gate + instant.dt;
        self.time_beyond_gate = if within_gate { 0.0 } else { beyond };
        let parity = Parity {
            value: residual.value,
            sigma: libm::sqrt(innovation.variance),
        };
        Some((parity, Flags::OUT_OF_RANGE.when(!within_gate)))
    }

    /// Adds what the angles of links err by that are not read for a while to the covariance of N: they move the
    /// arms of weight and forces.
    pub(super) fn consider_angles(
        &self,
        instant: &Instant<'_>,
        equations: &Equations,
        forces: &mut Forces,
    ) {
        let (normal, traction) = (forces.normal, forces.traction);
        let right_side = |equations: &Equations| {
            let mut rows = equations.equilibrium.right_side(&traction);
            for (column, n) in equations.equilibrium.h_n.iter().zip(normal) {
                rows -= column * n;
            }
            rows
        };
        let (nominal, now) = (instant.nominal, right_side(equations));
        for (k, link) in self.links.iter().enumerate() {
            if !link.is_uncertain() {
                continue;
            }
            let mut angles = equations.link_angles;
            if let Some(angle) = angles.get_mut(k) {
                *angle += link.settled_sigma();
            }
            let [theta1, theta2] = angles;
            // A linkage that does not close there has no such angle.
            let turned = Arms::new(&nominal.robot.geometry, theta1, theta2).ok();
            let turned =
                turned.and_then(|arms| self.equations(nominal, instant.inputs, arms, angles).ok());
            if let Some(turned) = turned {
                forces.consider(&equations.inverse, &(right_side(&turned) - now));
            }
        }
    }

    /// Adds what errors of the links' angular accelerations with these standard deviations (rad/s^2)
    /// cost to the covariance of N.
    ///
    /// A wheel that is thrown up turns its link, and Q moves with it unless another wheel holds the
    /// link there: no sensor shows how much. So beside the inertia of the turning linkage counts an
    /// acceleration of Q in any direction, by the longest arm from Q to an axle of that link.
    pub(super) fn consider_turning(
        &self,
        [s1, s2]: [f64; 2],
        nominal: &Nominal,
        equations: &Equations,
        sensitivity: &Sensitivity,
        forces: &mut Forces,
    ) {
        if !self.method.inertia {
            return;
        }
        let (arms, carriers) = (&equations.arms, &nominal.robot.geometry.carriers);
        let lever = nominal.settings.moment_lever;
        let links = self.links.each_ref();
        let [a1, a2] = links.map(|link| link.acceleration);
        for (link, sigma, accelerations) in [(0, s1, [a1 + s1, a2]), (1, s2, [a1, a2 + s2])] {
            if !(sigma > 0.0) {
                continue;
            }
            let loads = self.loads(nominal, arms, accelerations);
            let (displaced, _) = Equilibrium::load_side(arms, carriers, &loads, lever);
            forces.consider(&equations.inverse, &(displaced - equations.equilibrium.f));
            let mut arm = 0.0_f64;
            for (axle, carrier) in arms.axles.iter().zip(carriers) {
                if carrier.index() == link {
                    arm = arm.max(robhaz_model::sqrt(axle.norm_squared()));
                }
            }
            for by_acceleration in &sensitivity[state::ACCELERATION.all()] {
                forces.consider(&equations.inverse, &(by_acceleration * (arm * sigma)));
            }
        }
    }
}

/// Where the axle of the middle wheel is, against the line of the others.
struct MiddleWheel {
    /// Height above that line, less that on flat ground, m.
    above: f64,
    /// Its derivatives by the angles of both links, m.
    by_angle: [f64; 2],
    /// Length of that line, m.
    length: f64,
}

impl MiddleWheel {
    fn new(geometry: &Geometry, arms: &Arms) -> Self {
        let length =
            |[front, _, rear]: [Vec2; 3]| robhaz_model::sqrt((front - rear).norm_squared());
        let above = |axles: [Vec2; 3]| {
            let [front, middle, rear] = axles;
            cross(front - rear, middle - rear) / length(axles)
        };
        let [front, middle, rear] = arms.axles;
        let (line, length) = (front - rear, length(arms.axles));
        let part = line.dot(&(middle - rear)) / (length * length);
        let mut by_angle = [0.0; 2];
        let shares = [-part, 1.0, part - 1.0];
        for ((axle, share), carrier) in arms.axles.iter().zip(shares).zip(geometry.carriers) {
            if let Some(by_angle) = by_angle.get_mut(carrier.index()) {
                *by_angle += share * axle.dot(&line) / length;
            }
        }
        Self {
            above: above(arms.axles) - above(geometry.axles),
            by_angle,
            length,
        }
    }

    /// Standard deviation of the height for those of both angles, rad.
    fn sigma(&self, [first, second]: [f64; 2]) -> f64 {
        root_sum_square(self.by_angle[0] * first, self.by_angle[1] * second)
    }
}
