//! Measures the clearance of a robot on its ground.

use super::part::{BarPlace, Part, outline, vector};
use parry2d::math::Pose;
use parry2d::query::distance;
use parry2d::shape::Polyline;
use robhaz_model::{Bar, Geometry};
use robhaz_terrain::Terrain;

/// Largest distance of the points of the ground, m. The chord of a curve of 0.1 m radius is 0.03 mm
/// off.
const SPACING: f64 = 0.005;
/// Ground on each side of the robot that is kept, and the part of it that the robot may use before
/// it is built anew, over the robot's length.
const KEPT: f64 = 6.0;
const USED: f64 = 3.0;

/// Measures the clearance of a robot on its ground.
///
/// What it has measured bounds what follows, by the way of the bars since then: lines that cannot
/// be the nearest are not measured, and the others have few lines of the ground near them. The
/// results are those of a full search, up to rounding.
pub struct ClearanceMeter {
    terrain: Terrain,
    /// The lines of all bars, in the order of [`Bar::ALL`].
    parts: Vec<(Bar, Part)>,
    half_width: f64,
    /// Length of the robot, m.
    length: f64,
    /// The ground about a place x, m; `None` before the first measurement.
    ground: Option<(f64, Polyline)>,
}

impl ClearanceMeter {
    /// For a checked geometry on a ground.
    pub fn new(geometry: &Geometry, terrain: Terrain) -> Self {
        let [front, _, rear] = geometry.axles;
        let parts = Bar::ALL.into_iter().flat_map(|bar| {
            let lines = outline(geometry, bar).into_iter();
            lines.map(move |part| (bar, part))
        });
        Self {
            terrain,
            parts: parts.collect(),
            half_width: geometry.outline.half_width,
            length: front.x - rear.x + 2.0 * geometry.wheel_radius,
            ground: None,
        }
    }

    /// Clearance of the bars at their places, in the order of [`Bar::ALL`]. Nothing is known of a
    /// place that is not finite.
    pub fn measure(&mut self, bars: &[BarPlace; 4]) -> Clearances {
        self.measure_below(bars, f64::INFINITY)
            .unwrap_or(Clearances::of([f64::NAN; 4]))
    }

    /// As [`Self::measure`]; `None` where no bar touches the ground, none did when it was last
    /// measured, and no clearance is below `bound` (m). Most records of a run need no measurement
    /// to know that.
    pub fn measure_below(&mut self, bars: &[BarPlace; 4], bound: f64) -> Option<Clearances> {
        if !bars.iter().all(BarPlace::is_finite) {
            return Some(Clearances::of([f64::NAN; 4]));
        }
        self.keep_ground_at(bars[Bar::Body as usize].centre.x);
        let (_, ground) = self.ground.as_ref()?;
        let half_width = self.half_width;
        let at_least = |(bar, part): &(Bar, Part)| part.at_least(&bars[*bar as usize]);
        let found = self.parts.iter().map(at_least).enumerate();
        let (nearest, distance) = found.min_by(|a, b| a.1.total_cmp(&b.1))?;
        if distance - half_width > bound.max(0.0) {
            return None;
        }
        let mut each = [f64::INFINITY; 4];
        let mut least = f64::INFINITY;
        let (before, from) = self.parts.split_at_mut(nearest);
        // The one that may be nearest first, so that most others need no measurement. Where it
        // touches, others may, too.
        for (bar, part) in from.iter_mut().chain(before) {
            let place = &bars[*bar as usize];
            if part.at_least(place) - half_width <= least.max(0.0) {
                let found = part.measure(place, ground) - half_width;
                let of_bar = &mut each[*bar as usize];
                *of_bar = of_bar.min(found);
                least = least.min(found);
            }
        }
        Some(Clearances::of(each))
    }

    /// Clearance of each bar (m) in the order of [`Bar::ALL`], by parry2d's own search of the whole
    /// ground: nothing is known from before. Slow; [`Self::measure`] is held against it.
    pub fn measure_each(&mut self, bars: &[BarPlace; 4]) -> [f64; 4] {
        self.keep_ground_at(bars[Bar::Body as usize].centre.x);
        let Some((_, ground)) = &self.ground else {
            return [f64::NAN; 4];
        };
        let mut each = [f64::INFINITY; 4];
        for (bar, part) in &self.parts {
            let place = &bars[*bar as usize];
            let pose = Pose::new(vector(place.centre), place.angle);
            // This pair of shapes is supported.
            let found = distance(&pose, &part.line, &Pose::IDENTITY, ground);
            let found = found.map_or(f64::NAN, |d| d.distance);
            let of_bar = &mut each[*bar as usize];
            *of_bar = of_bar.min(found);
        }
        each.map(|distance| distance - self.half_width)
    }

    /// Builds the ground about x (m), if the robot is near the end of what is kept.
    fn keep_ground_at(&mut self, x: f64) {
        let is_near = |(at, _): &(f64, Polyline)| (x - at).abs() <= USED * self.length;
        if !x.is_finite() || self.ground.as_ref().is_some_and(is_near) {
            return;
        }
        let reach = KEPT * self.length;
        let points = self.terrain.outline(x - reach, x + reach, SPACING);
        let points: Vec<_> = points.into_iter().map(vector).collect();
        self.ground = (points.len() > 1).then(|| (x, Polyline::new(points, None)));
        for (_, part) in &mut self.parts {
            part.last = None;
        }
    }
}

/// The least clearance of body and links, and which of them touch the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearances {
    /// The bar with the least clearance, and its clearance, m; infinite where none is known. A bar
    /// at 0 or below touches the ground; how deep it is below 0 has no meaning.
    pub least: (Bar, f64),
    /// Whether each bar touches the ground, in the order of [`Bar::ALL`]; `None` where it is not
    /// known.
    pub touching: [Option<bool>; 4],
}

impl Clearances {
    /// Of the clearances (m) of the four bars, in the order of [`Bar::ALL`]. One that is not a
    /// number is not known.
    pub fn of(each: [f64; 4]) -> Self {
        let bars = Bar::ALL.into_iter().zip(each);
        let least = bars.fold((Bar::Body, f64::INFINITY), |least, of_bar| {
            if of_bar.1 < least.1 { of_bar } else { least }
        });
        Self {
            least,
            touching: each.map(|distance| (!distance.is_nan()).then_some(distance <= 0.0)),
        }
    }

    /// Whether a bar touches the ground.
    pub fn touches(&self) -> bool {
        self.least.1 <= 0.0
    }
}
