//! Needed friction and slip of the three wheels, and what they teach about the ground.

use super::needed::{JointForces, NeededFriction, OffsetShare};
use super::slip_watch::{PeakFriction, SlipEvent, SlipWatch, WheelSample};
use crate::contact::{ContactEstimate, ContactState};
use crate::deviation::{WITHIN, root_sum_square};
use crate::ground::GroundMemory;
use crate::statics::Forces;
use robhaz_model::Vec2;

/// Friction of one wheel: what it needs, and what is known of the ground there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelFriction {
    /// Needed friction. `None` for a wheel without load.
    pub needed: Option<NeededFriction>,
    /// What the offset of the torque reading has to do with it; zero for a wheel without load.
    pub offset: OffsetShare,
    /// The largest |T/N| of the last 0.6 s; while the wheel slips, that before. Zero while the
    /// wheel is not watched.
    pub peak: PeakFriction,
    /// Margin to the known friction, -: upper bound of mu_max less |T/N|. The bound is that of the
    /// wheel's place, else that of the last slip event. `None` before any wheel has slipped.
    pub margin: Option<f64>,
    /// Distance that the rim has slid over the ground since the largest T/N, m. `None` while the
    /// wheel grips: there is a value from the onset of slip until it grips again.
    pub slid: Option<f64>,
    /// Noise and rate of the readings over what an onset of slip needs to show, -: above 1 no onset
    /// can be seen. Zero where its acceleration shows; infinite without a slip speed.
    pub slip_noise: f64,
    /// The onset of slip, at the sample at which it is found.
    pub slip_event: Option<SlipEvent>,
}

/// The robot at one sample, as the other filters see it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrictionSample<'a> {
    pub forces: &'a Forces,
    /// Directions of the tangents at the contacts.
    pub tangents: &'a [Vec2; 3],
    pub contact: &'a [ContactEstimate; 3],
    /// Density of the noise of their slip, m^2/s. `None` where the slip is not known: no load, or
    /// encoders too coarse or too slow for a speed of the rim.
    pub slip_density: [Option<f64>; 3],
    /// Whether wheels can be judged: no impact, no stop, no reading that has been missing for long.
    pub clear: bool,
    /// What the estimated differences of the torque offsets have taken from the tractions, N; their
    /// sum is zero.
    pub removed: [f64; 3],
    /// Standard deviation of such a difference by the data sheet, N.
    pub systematic: f64,
    /// Mean wheel load, N.
    pub mean_load: f64,
    /// Time since the last sample, s.
    pub dt: f64,
}

/// Watches the wheels, and passes what they show on to the memory of the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FrictionObserver {
    watches: [SlipWatch; 3],
    /// Upper bound of mu_max of the last slip event.
    last_bound: Option<f64>,
}

impl FrictionObserver {
    /// Part of the mean wheel load from which T/N is exact enough to teach anything.
    /// Chosen; held by `crates/study/tests/study/friction_test`.
    const LEAST_LOAD: f64 = 0.2;

    /// Takes a sample. What it teaches goes to the memory of the ground.
    pub fn update(
        &mut self,
        sample: &FrictionSample<'_>,
        ground: &mut GroundMemory,
    ) -> [WheelFriction; 3] {
        let mut forces = JointForces::new(sample.forces);
        if let Some(error) = ground.direction_error() {
            forces.know_direction(&sample.forces.covariance, sample.tangents, error);
        }
        let places = ground.wheel_places();
        let median_slip = median_slip(sample.contact);
        let loaded = |i: usize| forces.normal(i) > Self::LEAST_LOAD * sample.mean_load;
        let mut found = [WheelFriction::default(); 3];
        for i in 0..3 {
            let contact = &sample.contact[i];
            let one = contact.state == ContactState::OneContact;
            found[i].needed = loaded(i).then(|| forces.needed_friction(i));
            if loaded(i) {
                found[i].offset = OffsetShare {
                    removed: sample.removed[i] / forces.normal(i),
                    sigma: sample.systematic / forces.normal(i),
                };
            }
            let known = found[i].needed.filter(|_| one && sample.clear);
            let Some(needed) = known else {
                // Its forces or its speed are not known.
                self.watches[i] = SlipWatch::default();
                continue;
            };
            let Some(slip_density) = sample.slip_density[i] else {
                self.watches[i] = SlipWatch::default();
                found[i].slip_noise = f64::INFINITY;
                continue;
            };
            let wheel = WheelSample {
                needed,
                load: forces.normal(i),
                offset: found[i].offset,
                slip: contact.slip,
                median_slip,
                slip_density,
                place: places.map(|places| places[i]),
            };
            let event = self.watches[i].update(&wheel, sample.dt);
            found[i].slip_event = event;
            found[i].slip_noise = self.watches[i].noise(sample.dt);
            found[i].slid = self.watches[i].slid();
            found[i].peak = self.watches[i].peak.friction;
            if let Some(event) = event {
                let margin = WITHIN * event.sigma;
                let at_most = event.mu_max + margin;
                self.last_bound = Some(at_most);
                if let Some(x) = event.place {
                    ground.friction_measured(x, event.mu_max - margin, at_most);
                }
            } else if let Some(x) = wheel.place
                && !(contact.sliding || found[i].slid.is_some())
            {
                let margin = root_sum_square(needed.sigma, wheel.offset.sigma);
                ground.friction_held(x, needed.value.abs() - WITHIN * margin);
            }
        }
        for i in 0..3 {
            let here = places.and_then(|places| ground.friction_at(places[i]).at_most);
            let bound = here.or(self.last_bound);
            let needed = found[i].needed.map(|needed| needed.value.abs());
            found[i].margin = bound.zip(needed).map(|(bound, needed)| bound - needed);
        }
        found
    }
}

/// Median of the slip speeds of the three wheels, m/s; that of a wheel without a slip of its own
/// counts as zero.
fn median_slip(contact: &[ContactEstimate; 3]) -> f64 {
    let [a, b, c] = contact.map(|contact| match contact.state {
        ContactState::OneContact => contact.slip,
        _ => 0.0,
    });
    a.min(b).max(a.max(b).min(c))
}
