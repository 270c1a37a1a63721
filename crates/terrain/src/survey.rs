//! The ground as rows of numbers.

use crate::Terrain;
use crate::edge::Edge;

/// Tangents and curvatures of two edges that differ by less, of their size, are the same: rounding.
const SAME: f64 = 1e-6;

/// A point of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surveyed {
    /// m
    pub x: f64,
    /// m
    pub height: f64,
    /// dy/dx, -; `None` on a riser, which is upright.
    pub slope: Option<f64>,
    /// y''/(1 + y'^2)^(3/2), 1/m, positive in hollows; `None` on a riser.
    pub curvature: Option<f64>,
}

impl Surveyed {
    fn on(edge: &Edge, x: f64) -> Self {
        let [height, slope, bend] = edge.eval(x);
        Self {
            x,
            height,
            slope: Some(slope),
            curvature: Some(bend / (1.0 + slope * slope).powf(1.5)),
        }
    }

    /// The same point with the same tangent and curvature.
    #[expect(clippy::float_cmp, reason = "the same point of the chain")]
    fn is_same(&self, other: &Self) -> bool {
        let near = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => (a - b).abs() <= SAME * (1.0 + a.abs().max(b.abs())),
            (a, b) => a == b,
        };
        self.x == other.x
            && self.height == other.height
            && near(self.slope, other.slope)
            && near(self.curvature, other.curvature)
    }
}

impl Terrain {
    /// x at which the level ground before the profile ends and that behind it starts, m.
    pub fn extent(&self) -> (f64, f64) {
        let start = self.edges().first().map_or(0.0, |e| e.to.x);
        (start, self.edges().last().map_or(0.0, |e| e.from.x))
    }

    /// Points along the ground from `from` to `to`: both ends of every straight piece, and points
    /// on curves no more than `spacing` apart; m. Where tangent or curvature jump there are two
    /// points at the same x, one for each side.
    pub fn survey(&self, from: f64, to: f64, spacing: f64) -> Vec<Surveyed> {
        let mut points: Vec<Surveyed> = Vec::new();
        let mut add = |point: Surveyed| {
            if points.last().is_none_or(|last| !last.is_same(&point)) {
                points.push(point);
            }
        };
        let edges = self.edges().iter();
        for edge in edges.filter(|e| e.to.x >= from && e.from.x <= to) {
            if edge.is_riser() {
                for end in [edge.from, edge.to] {
                    add(Surveyed {
                        x: end.x,
                        height: end.y,
                        slope: None,
                        curvature: None,
                    });
                }
                continue;
            }
            edge.places(from, to, spacing)
                .for_each(|x| add(Surveyed::on(edge, x)));
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Profile;

    /// Equivalence: on a curve the survey is what the profile says, with the curvature of a plane
    /// curve. Edges are polynomials through the profile's derivatives: 1e-9 m, 1e-7 and 1e-4 1/m
    /// are ten times what was found.
    #[test]
    fn curves_are_surveyed_as_they_are() {
        let terrain = Terrain::new(Profile::smooth());
        let points = terrain.survey(0.0, 4.0, 0.005);
        assert!(points.len() >= 800);
        assert!(points.windows(2).all(|p| p[1].x - p[0].x <= 0.005 + 1e-12));
        for p in &points {
            let [height, slope, bend] = terrain.profile().eval(p.x);
            assert!((p.height - height).abs() < 1e-9);
            assert!(p.slope.is_some_and(|s| (s - slope).abs() < 1e-7));
            let curvature = bend / (1.0 + slope * slope).powf(1.5);
            assert!(p.curvature.is_some_and(|c| (c - curvature).abs() < 1e-4));
        }
    }

    #[test]
    fn risers_have_no_slope_and_corners_two() {
        let points = Terrain::new(Profile::step()).survey(-1.0, 2.0, 0.005);
        let rows: Vec<_> = points.iter().map(|p| (p.x, p.height, p.slope)).collect();
        let expected = [
            (-1.0, 0.0, Some(0.0)),
            (0.7, 0.0, Some(0.0)),
            (0.7, 0.0, None),
            (0.7, 0.05, None),
            (0.7, 0.05, Some(0.0)),
            (2.0, 0.05, Some(0.0)),
        ];
        assert_eq!(rows, expected);
        let ramp = Terrain::new(Profile::ramp()).survey(-1.0, 2.0, 0.005);
        let slopes: Vec<_> = ramp.iter().filter_map(|p| p.slope).collect();
        assert_eq!(slopes.len(), 6);
        let incline = 15.0_f64.to_radians().tan();
        assert!((slopes[2] - incline).abs() < 1e-12 && (slopes[3] - incline).abs() < 1e-12);
    }
}
