//! The stored points: a ring of cells at equal distances, and the window of those that the wheels
//! can reach.

use super::drift::Between;
use core::ops::Range;

/// Points in memory.
const CELLS: i64 = 96;
/// Points that the wheels can reach, from the rearmost to the foremost contact. The others have
/// just been left.
const WINDOW: i64 = 88;
/// Points over which wheelbase and wheels extend.
/// Definition.
const REACH: f64 = 80.0;
/// Points that can be left, or passed by one wheel, in one sample.
pub const MOST_AT_ONCE: i64 = CELLS - WINDOW;
/// Points from one node of the drift to the next: [`CELLS`] points have at most `drift::NODE_COUNT`
/// nodes.
pub const NODE_EVERY: i64 = 6;
/// Largest number of a point: at a spacing of 10 mm ten million kilometres.
/// Guard.
const LARGEST: f64 = 1e12;

/// Bounds of the available friction mu_max at a place, each two standard deviations away from what
/// was found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionBounds {
    /// mu_max is at least this: the largest |T/N| that a wheel has borne there without slip. 0
    /// where nothing was borne.
    pub at_least: f64,
    /// mu_max is at most this: a wheel began to slip there. `None` where none has.
    pub at_most: Option<f64>,
}

/// A stored point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cell {
    /// Height of the axle of a wheel there by dead reckoning, m: its error is that of the nodes beside it.
    pub height: f64,
    /// Contact angle of the first wheel, rad.
    pub slope: f64,
    /// Variance of the part of that angle's error that only this wheel has, rad^2.
    pub slope_variance: f64,
    /// Variance of the place when the point was stored, m^2.
    pub place_variance: f64,
    /// Whether the filters had settled then: before, what they take for slopes teaches no wheel.
    pub settled: bool,
}

/// A place in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Slot {
    /// The point that is stored there.
    cell: Option<Cell>,
    /// What is known of the friction, with a stored point or without.
    friction: FrictionBounds,
}

/// See the module. Points have numbers: their place is that number times the spacing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells {
    /// Distance between points, m. Not part of the state.
    pub spacing: f64,
    /// Number of the first point in the window.
    first: i64,
    /// The same at the last sample.
    last_first: i64,
    slots: [Slot; CELLS as usize],
}

impl Cells {
    /// Distance between points, m, for a robot of the length (m) from the rear edge of its rear
    /// wheel to the front edge of its front wheel.
    pub fn spacing(length: f64) -> f64 {
        // `Geometry::check` refuses a robot without length. Without that check it must not fail
        // either.
        (length / REACH).clamp(1e-4, 1.0)
    }

    /// No points, at a distance of `spacing` (m).
    pub fn new(spacing: f64) -> Self {
        Self {
            spacing,
            first: 0,
            last_first: 0,
            slots: [Slot::default(); CELLS as usize],
        }
    }

    /// Distance between nodes, m.
    pub fn node_spacing(&self) -> f64 {
        NODE_EVERY as f64 * self.spacing
    }

    /// Number of the last point at or before a place (m).
    pub fn number(&self, x: f64) -> i64 {
        let exact = (x / self.spacing).clamp(-LARGEST, LARGEST);
        let towards_zero = exact as i64;
        towards_zero - i64::from(towards_zero as f64 > exact)
    }

    /// Place of a point, m.
    pub fn place(&self, number: i64) -> f64 {
        number as f64 * self.spacing
    }

    /// A point relative to the nodes.
    pub fn between(number: i64) -> Between {
        let share = number.rem_euclid(NODE_EVERY) as f64 / NODE_EVERY as f64;
        (number.div_euclid(NODE_EVERY), share)
    }

    /// Puts an empty window around a place (m).
    pub fn centre(&mut self, x: f64) {
        self.first = self.number(x) - WINDOW / 2;
        self.last_first = self.first;
    }

    /// Moves the window so that it contains all places from `low` to `high` (m), as far as one
    /// sample can. The points that it leaves stay readable until [`Self::drop_left`].
    pub fn follow(&mut self, low: f64, high: f64) {
        let ahead = self.number(high) + 1 - (self.first + WINDOW - 1);
        let behind = self.number(low) - self.first;
        self.first += if ahead > 0 {
            ahead.min(MOST_AT_ONCE)
        } else {
            behind.clamp(-MOST_AT_ONCE, 0)
        };
    }

    /// Points that the last sample left.
    pub fn left(&self) -> Range<i64> {
        let (from, to) = (self.last_first, self.first);
        if to >= from {
            from..to
        } else {
            to + WINDOW..from + WINDOW
        }
    }

    /// Removes the points that the last sample left.
    pub fn drop_left(&mut self) {
        for number in self.left() {
            if let Some(slot) = self.slots.get_mut(Self::index(number)) {
                *slot = Slot::default();
            }
        }
        self.last_first = self.first;
    }

    /// The window.
    pub fn window(&self) -> Range<i64> {
        self.first..self.first + WINDOW
    }

    /// The window and the points that the last sample left.
    pub fn all(&self) -> Range<i64> {
        let first = self.first.min(self.last_first);
        first..first + CELLS
    }

    fn index(number: i64) -> usize {
        // The remainder lies between 0 and CELLS.
        number.rem_euclid(CELLS) as usize
    }

    /// A point in the window, or one that the last sample left.
    pub fn stored(&self, number: i64) -> Option<&Cell> {
        self.slots.get(Self::index(number))?.cell.as_ref()
    }

    /// A point in the window.
    pub fn known(&self, number: i64) -> Option<&Cell> {
        let inside = self.window().contains(&number);
        self.stored(number).filter(|_| inside)
    }

    /// Stores a point of the window.
    pub fn store(&mut self, number: i64, cell: Cell) {
        if let Some(slot) = self.slots.get_mut(Self::index(number)) {
            slot.cell = Some(cell);
        }
    }

    /// What is known of the friction at a place in the window, or at one that the last sample left.
    pub fn friction(&self, number: i64) -> FrictionBounds {
        let slot = self.slots.get(Self::index(number));
        slot.map_or_else(FrictionBounds::default, |slot| slot.friction)
    }

    /// The same at a place of the window, to be changed.
    pub fn friction_mut(&mut self, number: i64) -> Option<&mut FrictionBounds> {
        let inside = self.window().contains(&number);
        let slot = self.slots.get_mut(Self::index(number));
        slot.filter(|_| inside).map(|slot| &mut slot.friction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Property: bounds are kept by place; places outside of the window keep none.
    #[test]
    fn bounds_belong_to_their_place() {
        let mut cells = Cells::new(Cells::spacing(0.8));
        cells.centre(0.0);
        let number = cells.number(0.1);
        let expected = FrictionBounds {
            at_least: 0.5,
            at_most: None,
        };
        *cells.friction_mut(number).expect("in the window") = expected;
        assert_eq!(cells.friction(number), expected);
        assert_eq!(cells.friction(number + 1), FrictionBounds::default());
        assert!(cells.friction_mut(number + 1000).is_none());
        cells.follow(10.0, 10.5);
        for _ in 0..200 {
            cells.drop_left();
            cells.follow(10.0, 10.5);
        }
        // Another place in the same cell of the ring.
        assert_eq!(cells.friction(number + 96), FrictionBounds::default());
    }
}
