//! The ground as a chain of edges, the contacts of a wheel with it, and its points as rows of
//! numbers.

use crate::chain::{REACH, chain};
use crate::edge::{Contact, Edge, Jump};
use crate::grid::{Grid, Near};
use crate::{Profile, Vec2};
use std::sync::Arc;

/// Angle between the normals of two nearest points below which they count as one contact, rad (8
/// deg), if no corner lies between them. A hollow slightly tighter than the wheel has two nearest
/// points close together; counting both would double the ground's stiffness. The two sides of a
/// corner always count as two contacts.
const SAME_NORMAL: f64 = 0.14;
/// Distance of two nearest points below which they count as one contact, m: at a smooth joint,
/// rounding can find one on each edge.
const SAME_POINT: f64 = 1.0e-6;
/// Tangents and curvatures of two edges that differ by less, of their size, are the same: rounding.
const SAME: f64 = 1e-6;
/// Newton steps from edge to edge before the search bisects instead; three usually suffice.
const NEWTON_STEPS: u32 = 8;

/// The ground: a chain of straight and curved edges, and a grid that finds the edges near a wheel.
///
/// Clones share the data.
#[derive(Clone)]
pub struct Terrain(Arc<Ground>);

struct Ground {
    edges: Vec<Edge>,
    grid: Grid,
}

impl Terrain {
    /// Builds the ground of a profile, which must have passed [`Profile::check`], for wheels of 0.1
    /// m radius.
    pub fn new(profile: Profile) -> Self {
        Self::for_wheels(&profile, 0.1)
    }

    /// Builds the ground of a profile, which must have passed [`Profile::check`], for wheels of a
    /// radius (m). Blunt concave corners, below 9 deg, are rounded with 1.25 times that radius.
    pub fn for_wheels(profile: &Profile, wheel_radius: f64) -> Self {
        let edges = chain(profile, wheel_radius);
        let grid = Grid::new(&edges, wheel_radius);
        Self(Arc::new(Ground { edges, grid }))
    }

    pub(crate) fn edges(&self) -> &[Edge] {
        &self.0.edges
    }

    /// Whether the ground has corners: joints where the tangent turns by more than 0.01 rad (0.6
    /// deg). There the contact force of a wheel can rise within less than a millisecond.
    pub fn has_corners(&self) -> bool {
        let pairs = self.0.edges.windows(2);
        let mut turns = pairs.map(|pair| pair[0].turn_to(&pair[1]));
        turns.any(|turn| turn.abs() > 0.01)
    }

    /// All contacts of a wheel from rear to front: points of the ground within `radius` (m) of
    /// `centre` (m) where the distance has a local minimum.
    ///
    /// On smooth ground there is one; a wheel that bridges a hollow has two. `out` is cleared
    /// first; its storage is reused from call to call. The result depends on the arguments alone.
    pub fn contacts(&self, centre: Vec2, radius: f64, out: &mut Vec<Contact>) {
        self.contacts_near(centre, radius, &mut 0, out);
    }

    /// As [`Self::contacts`], faster for a wheel that moves on from its last place: `hint`
    /// keeps the index of its edge from call to call, at first any. It has no influence on the
    /// result.
    pub fn contacts_near(
        &self,
        centre: Vec2,
        radius: f64,
        hint: &mut usize,
        out: &mut Vec<Contact>,
    ) {
        out.clear();
        let Ground { edges, grid } = &*self.0;
        match grid.near(centre, radius) {
            Near::Single(range) => {
                // The usual case: the place is still on the edge of the hint.
                if let Some(edge) = edges.get(*hint)
                    && *hint >= range[0]
                    && *hint <= range[1]
                    && let Some(contact) = edge.foot_if_between(centre)
                {
                    if is_within(centre, radius, &contact) {
                        out.push(contact);
                    }
                    return;
                }
                let place = self.single_minimum(range, centre, Some(hint));
                Found::new(centre, radius, out).extend(place);
            }
            Near::Few(range) => Found::new(centre, radius, out).add_all_minima(&edges[range]),
            Near::Unknown => self.search(centre, radius, out),
        }
    }

    /// The contacts of a wheel of any size anywhere. `out` is empty.
    #[inline(never)]
    fn search(&self, centre: Vec2, radius: f64, out: &mut Vec<Contact>) {
        let Ground { edges, grid } = &*self.0;
        let mut found = Found::new(centre, radius, out);
        let Some(reach) = grid.within(centre, radius, edges) else {
            return;
        };
        if reach.has_one_minimum(centre) {
            let mut first = *reach.edges.start();
            for last in grid.breaks(&reach.edges) {
                found.extend(self.single_minimum([first, last], centre, None));
                found.extend(Place::joint(&edges[last], &edges[last + 1], centre));
                first = last + 1;
            }
            found.extend(self.single_minimum([first, *reach.edges.end()], centre, None));
        } else {
            found.add_all_minima(&edges[reach.edges]);
        }
    }

    /// The local minimum of the distance on edges that have at most one. The search starts at the
    /// edge of the hint, or else below the centre.
    // Apart from the usual case in `contacts_near`, which then needs fewer registers.
    #[inline(never)]
    fn single_minimum(
        &self,
        [mut first, mut last]: [usize; 2],
        centre: Vec2,
        hint: Option<&mut usize>,
    ) -> Option<Place> {
        let Ground { edges, grid } = &*self.0;
        let mut index = match &hint {
            Some(hint) if (first..=last).contains(*hint) => **hint,
            _ => grid.edge_at(edges, centre.x).clamp(first, last),
        };
        let mut steps = 1;
        loop {
            let edge = &edges[index];
            let rates = edge.distance_rates(centre);
            if rates[0] <= 0.0 && rates[1] >= 0.0 {
                if let Some(hint) = hint {
                    *hint = index;
                }
                return Some(Place {
                    contact: edge.foot(centre, rates),
                    run: Some(edge.run),
                });
            }
            // The minimum is behind this edge or ahead of it.
            let is_behind = rates[0] > 0.0;
            let (before, end) = match is_behind {
                true => (index.wrapping_sub(1), first),
                false => (index, last),
            };
            if index == end {
                return None;
            }
            if let Some(joint) = Place::joint(&edges[before], &edges[before + 1], centre) {
                return Some(joint);
            }
            match is_behind {
                true => last = before,
                false => first = before + 1,
            }
            if first > last {
                return None;
            }
            let guess = edge.newton_x(centre, usize::from(!is_behind));
            index = if steps < NEWTON_STEPS {
                grid.edge_at(edges, guess).clamp(first, last)
            } else {
                first + (last - first) / 2
            };
            steps += 1;
        }
    }

    /// Places where the curvature jumps by more than `least` (1/m) and the tangent does not, from
    /// rear to front: the ends of bumps and parts, and knots of curves that are not smooth enough.
    pub fn curvature_jumps(&self, least: f64) -> Vec<Jump> {
        let pairs = self.0.edges.windows(2);
        pairs
            .filter(|pair| pair[0].run == pair[1].run && !pair[0].is_riser())
            .map(|pair| Jump::at_joint(&pair[0], &pair[1]))
            .filter(|jump| jump.curvature > least)
            .collect()
    }

    /// Height of the ground at x (m), m; on a riser that of one of its ends.
    pub fn height(&self, x: f64) -> f64 {
        let Ground { edges, grid } = &*self.0;
        edges[grid.edge_at(edges, x)].height(x)
    }

    /// The place at x (m), as one where everything can jump: the end of a friction stretch. `None`
    /// on a riser.
    pub fn jump_at(&self, x: f64) -> Option<Jump> {
        let Ground { edges, grid } = &*self.0;
        let edge = &edges[grid.edge_at(edges, x)];
        let [height, slope, _] = edge.eval(x);
        slope.is_finite().then(|| Jump {
            point: Vec2::new(x, height),
            tangent: Vec2::new(1.0, slope).normalize(),
            curvature: f64::INFINITY,
        })
    }

    /// The point of the ground nearest to `centre` (m), at any distance.
    pub fn nearest(&self, centre: Vec2) -> Option<Contact> {
        let mut found = Vec::new();
        let mut radius = 0.1;
        while radius < 2.0 * REACH {
            self.contacts(centre, radius, &mut found);
            let far = |a: &&Contact, b: &&Contact| a.distance.abs().total_cmp(&b.distance.abs());
            if let Some(best) = found.iter().min_by(far) {
                return Some(*best);
            }
            radius *= 2.0;
        }
        None
    }

    /// Points of the ground between x = `from` and `to` (m), for drawing: all ends of edges, and
    /// points on curves at most `spacing` (m) apart in x.
    pub fn outline(&self, from: f64, to: f64, spacing: f64) -> Vec<Vec2> {
        let mut points = Vec::new();
        let edges = self.0.edges.iter();
        for edge in edges.filter(|e| e.to.x >= from && e.from.x <= to) {
            // The start of an edge is the end of the one before.
            let known = usize::from(!points.is_empty());
            let places = edge.places(from, to, spacing).skip(known);
            points.extend(places.map(|x| Vec2::new(x, edge.height(x))));
        }
        points
    }
}

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

/// Whether a place is within a wheel with this centre (m) and radius (m).
#[inline]
fn is_within(centre: Vec2, radius: f64, place: &Contact) -> bool {
    (centre - place.point).norm_squared() < radius * radius
}

/// Collects the contacts of one wheel from rear to front.
struct Found<'a> {
    centre: Vec2,
    radius: f64,
    out: &'a mut Vec<Contact>,
    /// [`Edge::run`] of the last contact; `None` at a corner.
    last_run: Option<u32>,
}

/// A local minimum of the distance.
struct Place {
    contact: Contact,
    /// [`Edge::run`] of its edge; `None` at a corner.
    run: Option<u32>,
}

impl Place {
    /// The joint of two edges if the distance from `centre` has a local minimum there.
    fn joint(before: &Edge, after: &Edge, centre: Vec2) -> Option<Self> {
        let falls = before.distance_rates(centre)[1];
        let rises = after.distance_rates(centre)[0];
        (falls <= 0.0 && rises >= 0.0).then(|| Self::at_joint(before, after, centre))
    }

    /// A local minimum at the joint of two edges.
    fn at_joint(before: &Edge, after: &Edge, centre: Vec2) -> Self {
        let at = after.from;
        let arm = centre - at;
        if before.run == after.run {
            let second = after.second_derivatives[0];
            Self {
                contact: Contact::on_edge(at, after.tangents()[0], second, arm),
                run: Some(after.run),
            }
        } else {
            Self {
                contact: Contact::on_corner(at, arm),
                run: None,
            }
        }
    }
}

impl<'a> Found<'a> {
    /// None yet: `out` is empty.
    fn new(centre: Vec2, radius: f64, out: &'a mut Vec<Contact>) -> Self {
        Self {
            centre,
            radius,
            out,
            last_run: None,
        }
    }

    /// Adds a contact within the radius, unless it is the same as the last one.
    #[inline(always)]
    fn push(&mut self, Place { contact, run }: Place) {
        if !is_within(self.centre, self.radius, &contact) {
            return;
        }
        match self.out.last_mut() {
            // The same point found twice, or two points of one hollow: the deeper one counts.
            Some(last)
                if (last.point - contact.point).norm_squared() < SAME_POINT * SAME_POINT
                    || (run.is_some()
                        && run == self.last_run
                        && last.tangent.dot(&contact.tangent) > SAME_NORMAL.cos()) =>
            {
                if contact.distance < last.distance {
                    *last = contact;
                }
            }
            _ => self.out.push(contact),
        }
        self.last_run = run;
    }

    /// Adds a place, if there is one.
    fn extend(&mut self, place: Option<Place>) {
        if let Some(place) = place {
            self.push(place);
        }
    }

    /// Adds all local minima of the distance, by a search of every edge.
    fn add_all_minima(&mut self, edges: &[Edge]) {
        let (centre, radius) = (self.centre, self.radius);
        let mut before: Option<(&Edge, f64)> = None;
        for edge in edges {
            // No point of it is within the radius.
            if centre.x - edge.to.x >= radius {
                continue;
            }
            if edge.from.x - centre.x >= radius {
                break;
            }
            let rates = edge.distance_rates(centre);
            if let Some((before, falls)) = before
                && falls <= 0.0
                && rates[0] >= 0.0
            {
                self.push(Place::at_joint(before, edge, centre));
            }
            if rates[0] < 0.0 && rates[1] > 0.0 {
                self.push(Place {
                    contact: edge.foot(centre, rates),
                    run: Some(edge.run),
                });
            }
            before = Some((edge, rates[1]));
        }
    }
}

#[cfg(test)]
mod tests;
