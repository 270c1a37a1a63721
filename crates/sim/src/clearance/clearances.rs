//! What is known of the clearance of the bars.

use robhaz_model::Bar;

/// The least clearance of body and links, and which of them touch the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearances {
    least: (Bar, f64),
    touching: [Option<bool>; 4],
}

impl Clearances {
    /// Of the clearances (m) of the four bars, in the order of [`Bar::ALL`]. One that is not a
    /// number is not known.
    pub fn of(each: [f64; 4]) -> Self {
        let bars = Bar::ALL.into_iter().zip(each);
        let least = bars.fold((Bar::Body, f64::INFINITY), |least, (bar, distance)| {
            if distance < least.1 {
                (bar, distance)
            } else {
                least
            }
        });
        Self {
            least,
            touching: each.map(|distance| (!distance.is_nan()).then_some(distance <= 0.0)),
        }
    }

    /// The bar with the least clearance, and its clearance, m; infinite where none is known. A bar
    /// at 0 or below touches the ground; how deep it is below 0 has no meaning.
    pub fn least(&self) -> (Bar, f64) {
        self.least
    }

    /// Whether a bar touches the ground.
    pub fn touches(&self) -> bool {
        self.least.1 <= 0.0
    }

    /// Whether each bar touches the ground, in the order of [`Bar::ALL`]; `None` where it is not
    /// known.
    pub fn touching(&self) -> [Option<bool>; 4] {
        self.touching
    }
}
