//! The filters of `kalman`: Kalman filters for link angles, ground torques, and motion with the
//! readings' errors.

mod checks;
mod motion;
mod side;
mod statics;
#[cfg(test)]
mod tests;

pub(crate) use side::SideState;

use super::wheel::Wheel;
use crate::common::{LONGEST_BEYOND_GATE, ROLLING_SPEED};
use crate::contact::{
    ContactDetector, ContactEstimate, ContactEvidence, RollingResiduals, StandingDetector,
};
use crate::estimate::{Estimate, EstimateError, KalmanReport, Parity, ReadingErrors};
use crate::filters::motion::MotionFilter;
use crate::filters::{Innovation, LinkAngleKalman, PushFilter, TurnFilter, Unevenness};
use crate::flags::Flags;
use crate::frame::{Inputs, LinkReading, SensorFrame};
use crate::friction::{FrictionObserver, FrictionSample, WheelFriction};
use crate::ground::{GroundMemory, GroundMotion};
use crate::health::{HealthMonitor, Innovations};
use crate::nominal::{Instant, Nominal};
use crate::settings::{ContactAngles, KalmanMethod, NoiseBudget};
use crate::start::Carried;
use crate::state;
use crate::statics::{Arms, Equations, Forces, RightSide, solve};
use crate::torque_scale::{Rolling, ScaleFilter};
use robhaz_model::{Geometry, Robot, Vec2};

/// Filters of links, wheels and motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KalmanFilters {
    /// Enabled stages. Not part of the filter state.
    method: KalmanMethod,
    links: [LinkAngleKalman; 2],
    wheels: [Wheel; 3],
    carried: Carried,
    pub motion: MotionFilter,
    pub ground: GroundMemory,
    /// Normal forces of the last estimate, before the bound N >= 0, N.
    last_normal_force: [f64; 3],
    /// Tractions of the last estimate, before the bound N >= 0, N.
    last_traction: [f64; 3],
    /// Standard deviations of these normal forces, N.
    last_sigma: [f64; 3],
    /// Whether each wheel carries load by the last estimate.
    loaded: [bool; 3],
    /// Angle between the specific force and gravity at each inclinometer as of the last estimate,
    /// rad.
    last_force_angle: [f64; 2],
    /// Time for which the parity residual has been beyond its gate without a break, s.
    time_beyond_gate: f64,
    /// For how long no wheel has been able to roll as estimated, s: see [`Self::discard_wrong_states`].
    time_off_line: f64,
    /// Contact state of each wheel.
    contact: [ContactDetector; 3],
    standing: StandingDetector,
    friction: FrictionObserver,
    health: HealthMonitor,
    scale: ScaleFilter,
    /// Of a side of a whole rover: how it rolls, as of the last estimate.
    pub rolling: Option<Rolling>,
    push: PushFilter,
    unevenness: Unevenness,
    turn: TurnFilter,
    pub across: Across,
}

/// What lies across does to a side of a whole rover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Across {
    /// Velocity of each axle relative to Q by turning about other axes than that of the links, m/s.
    pub velocity: [Vec2; 3],
    /// Place of each axle relative to that in the plane of the side, m.
    pub place: [Vec2; 3],
    /// How the slope along each wheel follows from that of the line of the axles: factor, and what is added,
    /// rad, for a steered wheel on a cross slope.
    pub slope: [[f64; 2]; 3],
    /// Acceleration of the body's sensor less that of Q, along, m/s^2: in a turn that begins.
    pub of_sensor: f64,
    /// Whether wheels come where those ahead of them were: not where they are steered far off the line of the
    /// axles.
    pub follow: bool,
    /// Whether there is another side, with which the wheels share the robot: which torque turns which
    /// wheel then shows in both sides only.
    pub shares: bool,
    /// Standard deviation of the speed of each wheel along its plane by steering and dragging, m/s.
    pub slip: [f64; 3],
    /// Whether wheels of one side run apart in a turn that no reading shows.
    pub turns: bool,
    /// Whether the slip of the wheels is that of their T/N: not while they are dragged across, and not
    /// before they have rolled by a radius since a rest, which leaves forces of its own.
    pub settled: bool,
    /// The wheel that comes to where the front wheel was: 1 middle, 2 rear.
    pub trailing: usize,
}

impl Across {
    /// Of a robot in the plane.
    pub const NONE: Self = Self {
        velocity: [Vec2::new(0.0, 0.0); 3],
        place: [Vec2::new(0.0, 0.0); 3],
        slope: [[1.0, 0.0]; 3],
        of_sensor: 0.0,
        follow: true,
        shares: false,
        slip: [0.0; 3],
        turns: false,
        settled: true,
        trailing: 1,
    };
}

/// What an instant brings before its forces are known.
pub(crate) struct Step {
    pub equations: Equations,
    pub right: RightSide,
    rolling: [Option<RollingResiduals>; 3],
    innovations: Innovations,
    parity: Option<(Parity, Flags)>,
}

impl KalmanFilters {
    /// For the torques of a robot against its weight: see [`checks::scale_filter`].
    pub fn scale_filter(nominal: &Nominal, trailing: usize) -> ScaleFilter {
        checks::scale_filter(&nominal.robot, &nominal.settings.budget, trailing)
    }

    /// Largest force of a wheel that can be true, over the mean load: five times the weight of the
    /// robot. An impact that the filters follow, over some 20 ms, adds m v/20 ms to the weight:
    /// five weights at 1 m/s.
    /// Guard.
    const LARGEST_FORCE: f64 = 15.0;

    /// Creates the filters of a robot at rest.
    pub fn new(robot: &Robot, method: KalmanMethod, budget: &NoiseBudget) -> Self {
        let mean_load = robot.mean_wheel_load();
        Self {
            method,
            links: [LinkAngleKalman::new(budget); 2],
            wheels: [Wheel::new(); 3],
            carried: Carried::default(),
            motion: MotionFilter::new(budget, method.contact_angles),
            ground: GroundMemory::new(&robot.geometry),
            last_normal_force: [mean_load; 3],
            last_traction: [0.0; 3],
            last_sigma: [0.0; 3],
            loaded: [true; 3],
            last_force_angle: [0.0; 2],
            time_beyond_gate: 0.0,
            time_off_line: 0.0,
            contact: [ContactDetector::default(); 3],
            standing: StandingDetector::default(),
            friction: FrictionObserver::default(),
            health: HealthMonitor::default(),
            scale: checks::scale_filter(robot, budget, Across::NONE.trailing),
            rolling: None,
            push: PushFilter::new(3.0 * mean_load),
            unevenness: Unevenness::default(),
            turn: TurnFilter::default(),
            across: Across::NONE,
        }
    }

    /// Time since the last frame by the wheels, s, if all of them have turned further than they can
    /// in the `dt` (s) of the time stamps: the clock was set back. A robot that stops cannot be
    /// distinguished from a clock that was set forward.
    pub fn time_of_wheels(
        &self,
        nominal: &Nominal,
        inputs: &Inputs,
        frame: &SensorFrame,
        dt: f64,
    ) -> Option<f64> {
        if !(dt > 0.0) {
            return None;
        }
        let (mut turned, mut speed) = (0.0, 0.0);
        for i in 0..3 {
            let (wheel, angle) = (&self.wheels[i], frame.wheel_angle[i]?);
            turned += wheel.too_far(nominal, &inputs.motor_torque[i], angle, dt)?;
            speed += wheel.settled_speed()?.abs();
        }
        // Infinite at rest.
        Some(turned / speed)
    }

    /// Whether the robot has been carried or inclined by hand since the filters have started.
    pub fn is_carried(&mut self, inputs: &Inputs) -> bool {
        let started = self.links.iter().all(|link| link.started);
        let wheels = inputs.encoder.map(|encoder| encoder.angle.value);
        let links = self.links.each_ref().map(LinkAngleKalman::angle);
        started && self.carried.take(wheels, links)
    }

    /// Speed by the encoders, m/s, if a frame reads the angle of a link that was lost: what is known of the motion, which
    /// false rates may have carried anywhere.
    pub fn speed_at_found_link(&self, geometry: &Geometry, frame: &SensorFrame) -> Option<f64> {
        let mut links = self.links.iter().zip([&frame.link1, &frame.link2]);
        let found = links.any(|(link, read)| link.is_lost() && read.inclination.is_some());
        found.then(|| self.encoder_speed(geometry))
    }

    /// Takes over what lasts from `before` after a gap: the memory of the ground, whose section
    /// ends, the torques' scale, and the velocity about which the constraints of rolling are
    /// linearised. All velocities are unknown, because the robot may be moving.
    pub fn take_over(&mut self, before: &Self) {
        for wheel in &mut self.wheels {
            wheel.reset_speed();
        }
        if before.motion.is_coupled() {
            // Not that of a start: the other side may go on.
            self.motion.set_guests([[0.0; state::COUNT]; state::COUNT]);
        }
        self.motion.reset_velocity_variance();
        self.motion.assume_velocity(before.motion.velocity());
        self.ground = before.ground;
        self.ground.drop_left();
        self.ground.end_section();
        self.scale = before.scale;
        self.scale.interrupt();
    }

    /// Advances all filters to one instant and estimates the forces: link angles, motion, eq. (8),
    /// parity, least squares.
    ///
    /// # Errors
    /// [`EstimateError::Linkage`], [`EstimateError::Singular`].
    pub fn estimate(&mut self, instant: &Instant<'_>) -> Result<Estimate, EstimateError> {
        let step = self.advance(instant)?;
        let inputs = |a, b| self.motion.input_covariance(a, b);
        let (nominal, equations, right) = (instant.nominal, &step.equations, &step.right);
        let direction = equations.parity_direction.as_ref();
        let weighted = direction.filter(|_| self.method.whitening);
        let mut forces = solve(equations, weighted, right, inputs);
        for left in self.rolling_left(nominal) {
            forces.consider(&equations.inverse, &nominal.by_rolling_resistance(&left));
        }
        let turning = self
            .links
            .each_ref()
            .map(LinkAngleKalman::unmodelled_acceleration);
        self.consider_turning(turning, nominal, equations, &right.sensitivity, &mut forces);
        self.consider_angles(instant, equations, &mut forces);
        Ok(self.conclude(instant, step, forces))
    }

    /// Advances all filters to one instant, up to the equations of the forces.
    ///
    /// # Errors
    /// [`EstimateError::Linkage`], [`EstimateError::Singular`].
    #[inline(always)]
    pub fn advance(&mut self, instant: &Instant<'_>) -> Result<Step, EstimateError> {
        let nominal = instant.nominal;
        let mut innovations = Innovations::default();
        let (link_angles, inclination) = self.update_links(instant, &mut innovations);
        let arms = Arms::new(&nominal.robot.geometry, link_angles[0], link_angles[1])
            .map_err(EstimateError::Linkage)?;
        let rolling = self.update_motion(instant, &arms, &inclination, &mut innovations);
        self.update_ground(instant, &arms);

        let equations = self.equations(nominal, instant.inputs, arms, link_angles)?;
        let mut right = self.right_side(nominal, &equations);
        let of_push = self.consider_push(instant, &equations, &mut right);
        let parity = self.check_parity(instant, &equations, &mut right, of_push);
        innovations.parity = parity.map(|(parity, _)| parity.nis());
        Ok(Step {
            equations,
            right,
            rolling,
            innovations,
            parity,
        })
    }

    /// Contact, health, friction and the estimate, for the forces that the equations of `step` give.
    #[inline(always)]
    pub fn conclude(&mut self, instant: &Instant<'_>, step: Step, mut forces: Forces) -> Estimate {
        let nominal = instant.nominal;
        let settings = &nominal.settings;
        let Step {
            equations,
            right,
            rolling,
            innovations,
            parity,
        } = step;
        self.discard_wrong_states(&settings.budget, &equations.arms, instant);
        self.last_normal_force = forces.normal;
        self.last_traction = forces.traction;
        self.last_sigma = [0, 1, 2].map(|i| forces.sigma_normal(i));
        let stated = 1.0 / self.scale.applied;
        // Of a few samples: no filter is to take the forces before for that wrong.
        let impact = self
            .links
            .each_ref()
            .map(LinkAngleKalman::impact_acceleration);
        self.consider_turning(impact, nominal, &equations, &right.sensitivity, &mut forces);
        self.consider_twist(instant, &equations, &mut forces);
        let loaded =
            |i: usize| nominal.carries_load(forces.normal[i] * stated, self.last_sigma[i] * stated);
        self.loaded = [loaded(0), loaded(1), loaded(2)];
        let mut contact = [ContactEstimate::default(); 3];
        for (i, contact) in contact.iter_mut().enumerate() {
            let evidence = ContactEvidence {
                unloaded: !self.loaded[i],
                ratio: forces.traction[i] / nominal.at_least(forces.normal[i]),
                rolling: rolling[i],
                angles: self.method.contact_angles,
            };
            *contact = self.contact[i].update(&evidence, instant.dt);
        }
        self.find_scale(instant, &equations.arms, &contact);
        let health = self.check_health(instant, &innovations, &contact);

        let mut flags = instant.flags | Nominal::unloaded(self.loaded);
        flags |= Flags::SPINS_IN_PLACE.when(self.standing.stands);
        flags |=
            nominal.at_stop(equations.link_angles) | parity.map_or(Flags::NONE, |(_, flags)| flags);
        flags |= Flags::CONTRADICTION.when(!health.faulty.is_empty());
        if settings.nonnegative {
            forces.bound();
        }
        let largest = Self::LARGEST_FORCE * nominal.mean_load;
        flags |= Flags::OUT_OF_RANGE.when(forces.inflate_beyond(largest));
        forces.keep_proper();
        let contact_angle = [0, 1, 2].map(|i| self.contact_angle(i, instant.inputs));
        let tangents = &equations.equilibrium.tangents;
        let seen = (&contact, &rolling);
        let friction = self.observe_friction(nominal, &forces, tangents, seen, flags, instant.dt);
        let mut estimate =
            nominal.assemble(&equations, &forces, &right.value, contact_angle, flags);
        estimate.parity = parity.map(|(parity, _)| parity);
        let found = self.scale.found(3.0 * nominal.mean_load);
        let contact_angle_error = [0, 1, 2].map(|i| self.motion.input(state::CONTACT_ANGLE.of(i)));
        let links = self.links.each_ref();
        estimate.kalman = Some(KalmanReport {
            covariance: forces.covariance,
            contact_angle_sigma: contact_angle_error.map(|(_, sigma)| sigma),
            angle_sigma: links.map(|link| link.angle_sigma(&settings.budget)),
            reading_errors: self.reading_errors(nominal, contact_angle_error),
            contact,
            friction,
            health,
            torque_scale: nominal.other_side.is_none().then_some(found),
        });
        estimate.scale_forces(1.0 / self.scale.applied, self.scale.deviation);
        estimate
    }

    /// Advances the link angles, rad. A filter that has not started yet starts. Returns the angles,
    /// and the innovations of the inclinometers, rad.
    fn update_links(
        &mut self,
        instant: &Instant<'_>,
        innovations: &mut Innovations,
    ) -> ([f64; 2], [Option<f64>; 2]) {
        let budget = &instant.nominal.settings.budget;
        let mut innovation_of = [None; 2];
        for i in 0..2 {
            let (rate, inclination) = (instant.inputs.rate[i], instant.inputs.inclination[i]);
            let readings = LinkReading {
                rate: rate.now(),
                inclination: inclination.now(),
                ..LinkReading::default()
            };
            let force_angle = self.last_force_angle[i];
            let link = &mut self.links[i];
            link.joint_noise = instant.inputs.joint_noise[i];
            if link.started {
                link.jump(budget, rate.late, rate.left_out(), instant.dt);
                let innovation = link.update(budget, instant.dt, &readings, force_angle);
                innovation_of[i] = innovation.map(|innovation| innovation.value);
                innovations.inclination[i] = innovation.as_ref().map(Innovation::nis);
            } else {
                let rate = readings.rate.unwrap_or(0.0);
                link.start(inclination.value, inclination.age, rate);
            }
        }
        let angles = self.links.each_ref().map(LinkAngleKalman::angle);
        (angles, innovation_of)
    }

    /// Advances the memory of the ground, in the posture of `arms`. What it shows of the direction
    /// of the velocity corrects the motion.
    fn update_ground(&mut self, instant: &Instant<'_>, arms: &Arms) {
        let nominal = instant.nominal;
        let (robot, budget) = (&nominal.robot, &nominal.settings.budget);
        if !self.across.follow || self.links.iter().any(LinkAngleKalman::is_lost) {
            // Such ground is none to hold later wheels to.
            self.ground.end_section();
        }
        let angle = |i: usize| {
            let (_, sigma) = self.motion.input(state::CONTACT_ANGLE.of(i));
            (self.contact_angle(i, instant.inputs), sigma)
        };
        let compression = nominal.settings.compression;
        // The motion filter takes wheels to roll with their unloaded radius.
        let scale = 1.0 - compression / robot.geometry.wheel_radius;
        let motion = GroundMotion {
            dt: instant.dt,
            velocity: self.motion.velocity() * scale,
            velocity_covariance: self.motion.velocity_covariance(),
            axles: [0, 1, 2].map(|i| arms.axles[i] + self.across.place[i]),
            contact_angle: [angle(0), angle(1), angle(2)],
            touches: self.loaded,
        };
        let bias = budget.inclination_bias;
        let passed = self.ground.update(&robot.geometry, bias, &motion);
        for i in 0..3 {
            let known = passed[i].then(|| self.ground.mapped_slope(i)).flatten();
            if let Some((slope, variance)) = known {
                let given = instant.inputs.contact_angle[i].value;
                self.motion.correct_contact_angle(i, given, slope, variance);
            }
        }
        if let Some((error, variance)) = self.ground.take_direction_error(bias) {
            let change = self.motion.correct_direction(error, variance);
            self.ground.drift.direction_corrected(change);
        }
    }

    /// Needed friction, onset of slip, bounds of the friction.
    fn observe_friction(
        &mut self,
        nominal: &Nominal,
        forces: &Forces,
        tangents: &[Vec2; 3],
        (contact, rolling): (&[ContactEstimate; 3], &[Option<RollingResiduals>; 3]),
        flags: Flags,
        dt: f64,
    ) -> [WheelFriction; 3] {
        /// Part of the offsets' standard deviation in the differences of three offsets, sqrt(2/3).
        /// Their sum is known from the balance of the robot. Their differences show in the slip of
        /// gripping wheels, but not where a hard wheel does not creep.
        /// Definition.
        const DIFFERENCES: f64 = 0.816_496_580_927_726;
        // The other side takes part in the balance of a robot with two.
        let unknown = nominal.other_side.map_or(DIFFERENCES, |_| 1.0);
        let budget = &nominal.settings.budget;
        let radius = nominal.robot.geometry.wheel_radius;
        let offsets = [0, 1, 2].map(|i| self.motion.input(state::TORQUE_OFFSET.of(i)).0);
        let mean = offsets.iter().sum::<f64>() / 3.0;
        let sample = FrictionSample {
            forces,
            tangents,
            contact,
            slip_density: rolling.map(|rolling| Some(rolling?.slip?.density)),
            clear: !flags.intersects(Flags::UNRELIABLE),
            removed: offsets.map(|offset| (offset - mean) / radius),
            systematic: unknown * budget.torque_offset / radius,
            mean_load: nominal.mean_load,
            dt,
        };
        self.friction.update(&sample, &mut self.ground)
    }

    /// Starts the motion filter anew when the parity residual has been beyond its gate for too
    /// long, or the ground under every wheel has been found far off the line between the wheels while they roll. The places
    /// of the ground were computed from its velocity: a new section starts.
    fn discard_wrong_states(&mut self, budget: &NoiseBudget, arms: &Arms, instant: &Instant<'_>) {
        /// Angle between the ground of each wheel and the line between the wheels, rad: ground that all wheels pass
        /// has, on average, the slope of that line.
        /// Guard.
        const OFF_LINE: f64 = core::f64::consts::FRAC_PI_4;
        let slopes = self.slopes_of_line(arms);
        let speed = self.encoder_speed(&instant.nominal.robot.geometry);
        let rolls = !self.standing.stands && libm::fabs(speed) > ROLLING_SPEED;
        let off_line = |i: usize| (self.contact_angle(i, instant.inputs) - slopes[i]).abs();
        let leaves_line = rolls && [0, 1, 2].into_iter().all(|i| off_line(i) > OFF_LINE);
        self.time_off_line = if leaves_line {
            self.time_off_line + instant.dt
        } else {
            0.0
        };
        if self.time_beyond_gate.max(self.time_off_line) > LONGEST_BEYOND_GATE {
            self.motion = MotionFilter::new(budget, self.method.contact_angles);
            self.motion.reset_velocity_variance();
            self.motion.start_at(&slopes);
            let (sine, cosine) = libm::sincos(slopes[1]);
            let velocity = Vec2::new(cosine, sine) * speed;
            self.motion.assume_velocity(velocity);
            self.ground.end_section();
            (self.time_beyond_gate, self.time_off_line) = (0.0, 0.0);
        }
    }

    /// The estimated errors of the readings, with those of the contact angles (rad).
    fn reading_errors(&self, nominal: &Nominal, contact_angle: [(f64, f64); 3]) -> ReadingErrors {
        let motion = &self.motion;
        let [gear_friction, rolling_resistance] = self.resistance(nominal).parts();
        let given = self.method.contact_angles == ContactAngles::Given;
        ReadingErrors {
            torque_offset: [0, 1, 2].map(|i| motion.input(state::TORQUE_OFFSET.of(i))),
            gear_friction,
            rolling_resistance,
            contact_angle: given.then_some(contact_angle),
            rate_bias: self.links.each_ref().map(LinkAngleKalman::rate_bias),
        }
    }
}
