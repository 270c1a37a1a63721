//! What the wheels have shown of the friction at a place.

use super::bounds::{FrictionBounds, StoredBounds};
use super::memory::GroundMemory;

impl GroundMemory {
    /// Wheel `i` bears T/N without slip where it is now: mu_max is at least `bound`, -.
    pub fn friction_held(&mut self, i: usize, bound: f64) {
        let place = self
            .wheel_places()
            .and_then(|places| places.get(i).copied());
        if let Some(stored) = place.and_then(|x| self.stored_bounds(x)) {
            stored.hold(bound);
        }
    }

    /// A wheel began to slip at a place (m): mu_max is between the bounds, -. They replace what was
    /// known there.
    pub fn friction_measured(&mut self, x: f64, at_least: f64, at_most: f64) {
        if let Some(stored) = self.stored_bounds(x) {
            *stored = StoredBounds::measured(at_least, at_most);
        }
    }

    /// Bounds of the friction at a place in memory (m).
    pub fn friction_at(&self, x: f64) -> FrictionBounds {
        let number = self.cells.number(x);
        if self.cells.window().contains(&number) {
            self.cells.friction(number).bounds()
        } else {
            FrictionBounds::default()
        }
    }

    fn stored_bounds(&mut self, x: f64) -> Option<&mut StoredBounds> {
        let number = self.cells.number(x);
        self.cells.friction_mut(number)
    }
}

#[cfg(test)]
mod tests {
    use super::super::bounds::FrictionBounds;
    use super::super::cells::Cells;

    /// Property: bounds are kept by place, the largest held one counts, a slip replaces both;
    /// places outside of the window keep none.
    #[test]
    fn bounds_belong_to_their_place() {
        let mut cells = Cells::new(0.8);
        cells.centre(0.0);
        let number = cells.number(0.1);
        for bound in [0.2, 0.5, 0.3] {
            let stored = cells.friction_mut(number).expect("in the window");
            stored.hold(bound);
        }
        let expected = FrictionBounds {
            at_least: 0.5,
            at_most: None,
        };
        assert_eq!(cells.friction(number).bounds(), expected);
        assert_eq!(
            cells.friction(number + 1).bounds(),
            FrictionBounds::default()
        );
        assert!(cells.friction_mut(number + 1000).is_none());
        cells.follow(10.0, 10.5);
        for _ in 0..200 {
            cells.drop_left();
            cells.follow(10.0, 10.5);
        }
        // Another place in the same cell of the ring.
        assert_eq!(
            cells.friction(number + 96).bounds(),
            FrictionBounds::default()
        );
    }
}
