//! The torques against the weight: the ratio of the torques to those that the described robot
//! needs.
//!
//! A payload makes it greater just as torques do that are read too large. Only the prior tells them
//! apart: the budget's error of the masses. Within that prior the masses take their share of what
//! the [`WorkBalance`] finds; what a scale or an unstated payload may change beyond that is
//! considered in the stated deviations alone. Beyond the prior the forces are those of the
//! described masses with scaled torques, and their deviations contain what a payload would change.

mod balance;

pub(crate) use balance::Rolling;
use balance::WorkBalance;

/// The torques against the weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorqueScale {
    /// Torque readings over the torques that the described robot needs, -: above 1 the robot is
    /// heavier than described, or its torques are read too large.
    pub ratio: f64,
    /// Its standard deviation; about 1 before the readings show anything.
    pub sigma: f64,
    /// Mass of the robot, over that of the description, with which the stated forces are computed,
    /// -.
    pub mass: f64,
    /// Whether the ratio is beyond what the budget of gains and masses allows.
    pub contradicts: bool,
}

impl TorqueScale {
    /// Relative deviation up to which the ratio is known: a factor of 1.5 is then beyond four
    /// deviations.
    /// Chosen; held by `tests/check/torque_scale.rs`.
    const KNOWN: f64 = 0.1;

    /// Whether the readings have shown the ratio. Level ground does not, nor slopes that wheels
    /// which work against each other drown.
    pub fn is_known(&self) -> bool {
        self.sigma < Self::KNOWN * self.ratio
    }

    /// In words, for a robot of which one side is described to have the mass `described`, kg.
    pub fn in_words(self, described: f64) -> impl core::fmt::Display {
        let Self { ratio, sigma, .. } = self;
        core::fmt::from_fn(move |f| {
            if !(self.is_known() || self.contradicts) {
                return write!(
                    f,
                    "the log does not show the torques' scale: level ground, or slopes drowned by wheels that work against each other"
                );
            }
            write!(
                f,
                "torques fit a robot of {:.1} +- {:.1} kg a side; the description says {described:.1}",
                ratio * described,
                sigma * described,
            )?;
            if self.contradicts {
                write!(
                    f,
                    ": other masses (a payload), or torques read at {ratio:.2} of their size (gear efficiency, motor constant), the wheels' radius, the inclinometers' scale"
                )?;
            }
            Ok(())
        })
    }
}

/// Finds the ratio, and decides what follows from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ScaleFilter {
    /// [`crate::NoiseBudget::payload`]. Not part of the state.
    payload: f64,
    balance: WorkBalance,
    /// Ratio with which weight and inertia are multiplied, so that they fit the torques as they are
    /// read.
    pub applied: f64,
    /// Whether the ratio is beyond what the budget allows.
    pub contradicts: bool,
    /// Standard deviations that the stated forces have from the ratio, relative: of all tractions,
    /// the masses being right; and of all forces, as by other masses.
    pub deviation: [f64; 2],
}

impl ScaleFilter {
    /// Deviations beyond which the ratio contradicts the budget: the alarm. Honest readings reach
    /// 2.9 (260 runs of 20 grounds).
    /// A false alarm of 7e-6 for a Gaussian. Chosen; held by `tests/check/torque_scale.rs`.
    const CONTRADICTS: f64 = 4.5;
    /// Deviations below which it agrees again.
    /// Half of the alarm.
    const AGREES: f64 = 2.25;
    /// Deviations from which on the excess counts in the stated forces. Honest ratios are within it
    /// nearly always.
    /// Chosen; held by `tests/check/torque_scale.rs`.
    const COUNTS: f64 = 1.5;
    /// Deviations of a new ratio from the applied one from which on the new one is applied.
    /// Chosen; held by `tests/check/torque_scale.rs`.
    const FOLLOWS: f64 = 2.0;
    /// Standard deviation of the torques' scale before any reading, relative: torques of half their
    /// size (the efficiency of a worm gear, half of the motors' currents) err by two of these.
    /// Textbook: worm gears have efficiencies from below 0.5 to 0.9.
    const PRIOR: f64 = 0.5;
    /// Least ratio: motor torques that are 20 times too small.
    /// Guard.
    const LEAST: f64 = 0.05;

    /// See [`WorkBalance::new`]; `payload` is that of the budget.
    pub fn new(between: f64, resisted: f64, gain: f64, payload: f64) -> Self {
        Self {
            payload,
            balance: WorkBalance::new(between, resisted, gain),
            applied: 1.0,
            contradicts: false,
            deviation: [Self::PRIOR, payload],
        }
    }

    /// The way ends: a gap between frames.
    pub fn interrupt(&mut self) {
        self.balance.passage.interrupt();
    }

    /// Takes a sample, `dt` seconds after the last; `rolling` is `None` where the wheels do not
    /// simply roll, `mass` the relative error of the described mass. Returns whether another ratio
    /// is applied from now on that makes all estimated errors of the readings void.
    pub fn update(&mut self, rolling: Option<&Rolling>, weight: f64, mass: f64, dt: f64) -> bool {
        self.balance.update(rolling, weight, dt) && self.judge(weight, mass)
    }

    fn judge(&mut self, weight: f64, mass: f64) -> bool {
        let (ratio, sigma) = self.balance.ratio(weight);
        let ratio = ratio.max(Self::LEAST);
        let (log, sigma) = (libm::log(ratio), sigma / ratio);
        let allowed = sigma * sigma + mass * mass;
        let square = log * log / allowed;
        let applied = libm::log(self.applied);
        let before = self.contradicts;
        if square > Self::CONTRADICTS * Self::CONTRADICTS {
            self.contradicts = true;
        } else if square < Self::AGREES * Self::AGREES && Self::CONTRADICTS * sigma < applied.abs()
        {
            self.contradicts = false;
        }
        if self.contradicts {
            let left = log - applied;
            let of_forces = (ratio - 1.0) * (ratio - 1.0) + sigma * sigma;
            self.deviation = [sigma * sigma + left * left, of_forces].map(robhaz_model::sqrt);
            if left.abs() < Self::FOLLOWS * sigma && before {
                return false;
            }
            self.applied = ratio;
            // What was found with another ratio is less exact.
            self.balance.loosen();
            return true;
        }
        let of_mass = log * mass * mass / allowed;
        self.applied = libm::exp(of_mass);
        self.deviation = self.within_budget(log - of_mass, of_mass, sigma, mass);
        before
    }

    /// Deviations while the budget allows the ratio. Its logarithm has the deviation `sigma`;
    /// `of_mass` of it is applied as the masses' share, `rest` is not. `mass` is the deviation of
    /// the described mass, which the loads have anyway.
    fn within_budget(&self, rest: f64, of_mass: f64, sigma: f64, mass: f64) -> [f64; 2] {
        let square = |x: f64| x * x;
        let (measured, mass) = (square(sigma), square(mass));
        let posterior = |prior: f64| prior * measured / (prior + measured);
        // The scale, if there is no payload: mean square about 1, as the tractions are not
        // corrected.
        let prior = square(Self::PRIOR);
        let shift = rest * prior / (prior + measured);
        let of_scale = posterior(prior) + square(shift);
        // The payload, if the scale is right.
        let of_payload = (posterior(mass + square(self.payload)) - mass).max(0.0);
        // Of what the masses took, or of what they left, whichever is more.
        let left = rest.abs() > of_mass.abs();
        let most = if left { rest } else { of_mass };
        let allowed = square(Self::COUNTS) * (measured + mass);
        let excess = (1.0 - allowed / square(rest + of_mass)).max(0.0);
        let of_forces = of_payload + excess * square(libm::expm1(most));
        [of_scale, of_forces].map(robhaz_model::sqrt)
    }

    /// By what the forces so found are multiplied to be stated.
    pub fn stated(&self) -> f64 {
        self.mass() / self.applied
    }

    fn mass(&self) -> f64 {
        if self.contradicts { 1.0 } else { self.applied }
    }

    /// What is found, for a robot of this weight, N.
    pub fn found(&self, weight: f64) -> TorqueScale {
        let (ratio, sigma) = self.balance.ratio(weight);
        TorqueScale {
            ratio,
            sigma,
            mass: self.mass(),
            contradicts: self.contradicts,
        }
    }
}
