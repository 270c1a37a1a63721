//! What the wheels do at a point: the first one stores it, later ones measure it. What the memory then knows of the
//! ground is in `known.rs`.

mod known;

pub use known::GroundPoint;

use super::cells::{Cell, Cells, MOST_AT_ONCE, NODE_EVERY};
use super::drift::{Drift, Lever};
use super::motion::{Contact, GroundMotion, level, tangent};
use crate::deviation::root_sum_square;
use crate::filters::motion::ACCELERATION;
use robhaz_model::{Geometry, Vec2};

/// Deviation between the heights that two wheels find at one place, m, beyond the errors of dead
/// reckoning: the penetration depends on the load; the link angles lag.
/// Chosen; held by `crates/run/tests/run/ground.rs`.
const UNEVEN: f64 = 3e-4;
/// Speed at which a section starts, m/s. Before, the robot rests, and there is nothing to store.
/// Guard.
const MOVING: f64 = 0.005;
/// Way of a section after which the filters have settled, over the wheel radius.
/// Chosen; held by `tests/check/trusted.rs`.
const SETTLES: f64 = 1.0;
/// Least number of passed points that show it.
const LEAST_PASSES: i64 = 3;
/// Length over which the bias of the inclinometers is taken to last, m: it counts in every error of
/// the direction.
/// Chosen; held by `crates/run/tests/run/ground.rs`.
const BIAS_LENGTH: f64 = 3.0;
/// Bound of places and speeds, SI. Beyond it they are not those of a robot.
/// Guard.
const LARGEST: f64 = 1e9;

/// The last contact of a wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct LastContact {
    /// Whether the wheel touched the ground.
    touches: bool,
    /// Place and height of the axle (m) and contact angle (rad).
    at: [f64; 3],
    /// The point that it passed last.
    passed: i64,
    /// Whether the wheel came from mapped ground, which ties its height to that of the points
    /// there.
    tied: bool,
}

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GroundMemory {
    started: bool,
    /// The section has ended: all its points leave the memory, and with the next sample a new one
    /// starts.
    ended: bool,
    /// Number of the section.
    section: u32,
    /// Place of Q by dead reckoning, m.
    place: [f64; 2],
    /// Velocity at the last sample, m/s.
    velocity: [f64; 2],
    /// Variance of the place along the path, m^2.
    place_variance: f64,
    /// Way since the drift was last advanced, m: horizontal, with its sign; and its length.
    way: [f64; 2],
    /// Radius of the wheels, m.
    radius: f64,
    /// Way since the section started, m.
    travelled: f64,
    /// Distance of neighbouring wheels, m: the length after which passes show an error of the direction
    /// anew.
    between: f64,
    /// Length since the passes last showed the direction, m.
    length_since_direction: f64,
    /// Known points passed since then.
    passes_since_direction: i64,
    contacts: [LastContact; 3],
    cells: Cells,
    pub drift: Drift,
}

impl GroundMemory {
    /// An empty memory.
    pub fn new(geometry: &Geometry) -> Self {
        let [front, _, rear] = geometry.axles;
        let length = front.x - rear.x;
        let spacing = Cells::spacing(length + 2.0 * geometry.wheel_radius);
        Self::empty(geometry.wheel_radius, spacing, 0.5 * length, 0)
    }

    fn empty(radius: f64, spacing: f64, between: f64, section: u32) -> Self {
        Self {
            started: false,
            ended: false,
            section,
            place: [0.0; 2],
            velocity: [0.0; 2],
            place_variance: 0.0,
            way: [0.0; 2],
            radius,
            travelled: 0.0,
            between,
            length_since_direction: 0.0,
            passes_since_direction: 0,
            contacts: Default::default(),
            cells: Cells::new(spacing),
            drift: Drift::new(0.0, Lever { link: 0, arm: 0.0 }),
        }
    }

    /// Ends the section: all points leave the memory with this sample, and the next one starts a
    /// new section.
    pub fn end_section(&mut self) {
        self.ended = self.started;
    }

    /// Removes the points that left the memory with the last sample. To be called before each
    /// sample.
    pub fn drop_left(&mut self) {
        if self.ended {
            self.start_anew();
        } else {
            self.cells.drop_left();
        }
    }

    fn start_anew(&mut self) {
        *self = Self::empty(
            self.radius,
            self.cells.spacing,
            self.between,
            self.section.saturating_add(1),
        );
    }

    /// Takes one sample. `bias`: bias of the inclinometers, rad. A sample with an impossible number
    /// changes nothing; when the numbers grow beyond all bounds, a new section starts. Returns
    /// which wheels have passed mapped ground.
    pub fn update(&mut self, geometry: &Geometry, bias: f64, motion: &GroundMotion) -> [bool; 3] {
        let mut passed = [None; 3];
        if self.ended || !motion.is_possible() {
            return [false; 3];
        }
        if !self.started && motion.velocity.norm_squared() < MOVING * MOVING {
            return [false; 3];
        }
        let slope_sigma = self.reckon(motion);
        let contacts = [0, 1, 2].map(|i| motion.contact(geometry, slope_sigma, i));
        if !self.started {
            self.start(bias, motion.axles, &contacts);
        }
        let contacts = contacts.map(|contact| contact.moved(self.place));
        let places = contacts.map(|contact| contact.x);
        let low = places.iter().copied().fold(f64::INFINITY, f64::min);
        let high = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        self.cells.follow(low, high);
        for (i, (contact, touches)) in contacts.iter().zip(motion.touches).enumerate() {
            passed[i] = self.pass(i, touches, contact, slope_sigma);
        }
        let changed = passed != [None; 3];
        if self.is_lost() || (changed && self.drift.is_lost()) {
            self.start_anew();
            return [false; 3];
        }
        passed.map(|passed| passed == Some(true))
    }

    /// Integrates the velocity by the trapezoidal rule. Returns the standard deviation of its
    /// direction, as dy/dx.
    fn reckon(&mut self, motion: &GroundMotion) -> f64 {
        let (slope_sigma, speed_sigma) = motion.velocity_sigma();
        let velocity = [motion.velocity.x, motion.velocity.y];
        if self.started {
            let way = [0, 1].map(|i| 0.5 * motion.dt * (velocity[i] + self.velocity[i]));
            let length = root_sum_square(way[0], way[1]);
            self.place = [self.place[0] + way[0], self.place[1] + way[1]];
            self.way = [self.way[0] + way[0], self.way[1] + length];
            self.length_since_direction += length;
            self.travelled += length;
            // White noise of the same effect: `sigma^2 2 T dt`.
            self.place_variance += 2.0 * ACCELERATION.time * speed_sigma * speed_sigma * motion.dt;
        }
        self.velocity = velocity;
        slope_sigma
    }

    /// Puts the origin under the middle axle, at the height of that wheel's contact.
    fn start(&mut self, bias: f64, axles: [Vec2; 3], contacts: &[Contact; 3]) {
        let [front, axle, rear] = axles;
        let [_, middle, _] = contacts;
        self.started = true;
        self.place = [-axle.x, self.radius * libm::cos(middle.slope) - middle.y];
        self.drift = Drift::new(bias, middle.lever);
        self.cells.centre(self.place[0] + 0.5 * (front.x + rear.x));
    }

    /// Passes wheel `i` on to its contact. `Some` if it has passed points since the last sample:
    /// whether another wheel, or this one before, had stored one of them.
    fn pass(&mut self, i: usize, touches: bool, contact: &Contact, sigma: f64) -> Option<bool> {
        let last = self.contacts.get(i).copied()?;
        let (from, to) = (self.cells.number(last.at[0]), self.cells.number(contact.x));
        let steps = to.saturating_sub(from);
        let mut now = LastContact {
            touches,
            at: [contact.x, contact.y, contact.slope],
            tied: last.tied && last.touches && steps.abs() <= MOST_AT_ONCE,
            ..last
        };
        let mut passed = (steps != 0).then_some(false);
        // A wheel that came from elsewhere passes its next point first.
        if touches && last.touches && steps.abs() <= MOST_AT_ONCE {
            for k in 0..steps.abs() {
                let number = if steps > 0 { from + 1 + k } else { from - k };
                // A wheel that rests on a point passes it once.
                if number != now.passed {
                    let at = contact.since(last.at, self.cells.place(number));
                    if self.visit_point(number, steps > 0, &at, sigma, &mut now) {
                        passed = Some(true);
                    }
                }
            }
        }
        if let Some(last) = self.contacts.get_mut(i) {
            *last = now;
        }
        passed
    }

    /// A wheel at a point. Returns whether another one has stored it.
    fn visit_point(
        &mut self,
        number: i64,
        forward: bool,
        contact: &Contact,
        slope_sigma: f64,
        wheel: &mut LastContact,
    ) -> bool {
        wheel.passed = number;
        if !self.cells.window().contains(&number) {
            return false;
        }
        let [way, length] = core::mem::take(&mut self.way);
        self.drift.advance(way, length, slope_sigma);
        let cell = self.cells.known(number).copied();
        if let Some(cell) = &cell {
            self.measure(number, cell, contact);
            self.passes_since_direction += 1;
            wheel.tied = true;
        } else {
            self.store(number, forward, contact, wheel);
        }
        cell.is_some()
    }

    /// Stores a new point.
    ///
    /// Where a wheel comes to the first points of another one, the node ahead belongs to those: the
    /// heights of both agree only after the wheel has measured one of them. The points up to there
    /// are left to later wheels.
    fn store(&mut self, number: i64, forward: bool, contact: &Contact, wheel: &mut LastContact) {
        let place = Cells::between(number);
        let nodes = [place.0, place.0 + 1];
        let [behind, ahead] = if forward { nodes } else { [nodes[1], nodes[0]] };
        let beyond = |other: i64| (other > number) == forward;
        if !self.is_used(ahead, beyond) {
            self.open(ahead, number, contact.lever);
            wheel.tied = false;
        } else if !wheel.tied {
            return;
        }
        if !self.is_used(behind, |_| true) {
            self.open(behind, number, contact.lever);
        }
        // What is stored errs as the nodes say. The best values of now are these:
        let height = contact.y - self.drift.of_contact(contact.lever);
        let level = level(contact.slope);
        let slope = contact.slope - level * self.drift.stated_direction().0;
        let of_nodes = self.drift.slope_at(place, self.cells.node_spacing()).0;
        let cell = Cell {
            height: height + self.drift.at(place).0,
            slope: slope + level * of_nodes,
            slope_variance: contact.slope_variance,
            place_variance: self.place_variance,
            settled: self.travelled > SETTLES * self.radius,
        };
        self.cells.store(number, cell);
    }

    /// Whether the height of a known point that `counts` depends on a node.
    fn is_used(&self, node: i64, counts: impl Fn(i64) -> bool) -> bool {
        let position = node * NODE_EVERY;
        let mut beside = position - NODE_EVERY + 1..position + NODE_EVERY;
        beside.any(|other| counts(other) && self.cells.known(other).is_some())
    }

    /// Sets a node as a wheel at a point sees it.
    fn open(&mut self, node: i64, number: i64, lever: Lever) {
        let distance = self.cells.place(node * NODE_EVERY) - self.cells.place(number);
        self.drift.open(node, lever, distance);
    }

    /// Measures a known point.
    fn measure(&mut self, number: i64, cell: &Cell, contact: &Contact) {
        let between_passes = (self.place_variance - cell.place_variance).max(0.0);
        let slope = tangent(cell.slope);
        let single = UNEVEN * UNEVEN + slope * slope * between_passes;
        // White noise of the same effect: `sigma^2 2 L/spacing`, L half of the distance between
        // nodes.
        let variance = single * (self.cells.node_spacing() / self.cells.spacing);
        let difference = contact.y - cell.height;
        let place = Cells::between(number);
        let lever = contact.lever;
        self.drift.correct(lever, place, difference, variance);
    }

    /// Whether a number of the dead reckoning is not that of a robot.
    fn is_lost(&self) -> bool {
        let numbers = self.place.iter().chain(&self.velocity);
        let mut numbers = numbers.chain([&self.place_variance]);
        // Written so that a NaN is lost, too.
        !numbers.all(|number| number.abs() < LARGEST)
    }

    /// Estimated error of the direction of the velocity, as dy/dx, and its standard deviation.
    /// `None` before the section has started.
    pub fn direction_error(&self) -> Option<(f64, f64)> {
        let running = self.started && !self.ended;
        running.then(|| {
            let (error, variance) = self.drift.direction();
            (error, robhaz_model::sqrt(variance))
        })
    }

    /// Error of the direction of the velocity, as dy/dx, that wheels on mapped ground have shown
    /// since the last such error, and its variance with `bias`, the bias of the inclinometers
    /// (rad). Once in the distance of neighbouring wheels; else `None`.
    ///
    /// Loop closure: the heights that two wheels find at one place differ by what the direction
    /// erred by on the way between.
    pub fn take_direction_error(&mut self, bias: f64) -> Option<(f64, f64)> {
        let is_due = self.length_since_direction >= self.between
            && self.passes_since_direction >= LEAST_PASSES;
        if self.ended || !is_due {
            return None;
        }
        (self.length_since_direction, self.passes_since_direction) = (0.0, 0);
        let (error, variance) = self.drift.stated_direction();
        // The mean of two links' biases, as white noise of the same effect.
        let correlated = 0.5 * bias * bias * (2.0 * BIAS_LENGTH / self.between);
        Some((error, variance + correlated))
    }

    /// Places of the axles at the last sample, m; `None` before the section has started.
    pub fn wheel_places(&self) -> Option<[f64; 3]> {
        let running = self.started && !self.ended;
        running.then(|| self.contacts.map(|last| last.at[0]))
    }
}

#[cfg(test)]
mod tests;
