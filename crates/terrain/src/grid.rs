//! Finds the edges near an x in a time that does not depend on their number.

use crate::Vec2;
use crate::edge::Edge;
use std::ops::RangeInclusive;

/// Width of a cell, m: a few cells per wheel diameter.
const WIDTH: f64 = 0.05;
/// Greatest number of cells; on longer ground the cells are wider.
const MOST: f64 = 1.0e6;
/// Allowance for rounding in a cell's bounds, m.
const MARGIN: f64 = 1e-9;

/// Number of edges that are searched one by one sooner than sorted out: as on stairs, where each is
/// straight.
const FEW: usize = 8;

/// Cells of equal width over x, and one more on either side for the level ground.
pub(crate) struct Grid {
    /// x of the start of cell 1, m.
    start: f64,
    /// Width of a cell, m.
    width: f64,
    /// Cells per metre.
    per_metre: f64,
    cells: Vec<Cell>,
    /// What a wheel over each cell can touch.
    below: Vec<Below>,
    /// Radius of these wheels, m.
    wheel_radius: f64,
    /// Edges whose front end can lie between two local minima of the distance: risers, the edges
    /// before them, and edges that end in a concave corner.
    breaks: Vec<u32>,
}

/// The ground over one cell.
#[derive(Clone, Copy)]
struct Cell {
    /// Index of the first edge that reaches into the cell.
    first: u32,
    /// Lower bound of the height, m.
    low: f64,
    /// Upper bound of the height, m.
    high: f64,
    /// Upper bound of the second derivative, 1/m; at least 0.
    max_second_derivative: f64,
}

/// The ground that a wheel can touch whose centre is anywhere over one cell, and the heights of the
/// centre at which it touches at one place at most.
#[derive(Clone, Copy)]
struct Below {
    /// First and last edge.
    edges: [u32; 2],
    /// Heights between which the distance from the centre has one minimum at most, m. None if the
    /// first is the greater one.
    single: [f64; 2],
}

/// The edges that a wheel can touch.
pub(crate) enum Near {
    /// On them, from the first to the last, the distance from its centre has one minimum at most.
    Single([usize; 2]),
    /// They are few.
    Few(RangeInclusive<usize>),
    /// They must be searched for.
    Unknown,
}

/// The ground that a circle can touch.
pub(crate) struct Reach {
    /// Its edges.
    pub edges: RangeInclusive<usize>,
    /// Lower bound of its height, m.
    pub low: f64,
    /// Upper bound of its height, m.
    pub high: f64,
    /// Upper bound of its second derivative, 1/m; at least 0.
    pub max_second_derivative: f64,
}

impl Reach {
    /// Whether the distance from `centre` has one minimum at most between two breaks.
    ///
    /// Let g = (x - cx) + (f - cy) f' be the derivative of half the squared distance along smooth
    /// ground below the centre. Its slope is 1 + f'^2 + (f - cy) f''. If that is positive
    /// everywhere, g has at most one zero. Convex corners keep it so: there g jumps up.
    pub fn has_one_minimum(&self, centre: Vec2) -> bool {
        centre.y > self.high && (centre.y - self.low) * self.max_second_derivative < 1.0
    }
}

impl Grid {
    /// The grid of a chain whose first and last edge are level ground, for wheels of a radius (m)
    /// and smaller ones.
    pub fn new(edges: &[Edge], wheel_radius: f64) -> Self {
        let start = edges.first().map_or(0.0, |e| e.to.x);
        let end = edges.last().map_or(0.0, |e| e.from.x);
        let count = ((end - start) / WIDTH).ceil().clamp(1.0, MOST);
        let empty = Cell {
            first: u32::MAX,
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            max_second_derivative: 0.0,
        };
        let cells = vec![empty; count as usize + 2];
        // Level ground alone has no length between its first and its last edge.
        let width = ((end - start) / count).max(MARGIN);
        let mut grid = Self {
            start,
            width,
            per_metre: 1.0 / width,
            cells,
            below: Vec::new(),
            wheel_radius,
            breaks: Vec::new(),
        };
        for (i, edge) in edges.iter().enumerate() {
            grid.add(i, edge, edges.get(i + 1));
        }
        grid.below = (0..grid.cells.len())
            .map(|cell| grid.below(cell, edges))
            .collect();
        grid
    }

    /// What a wheel can touch whose centre is over a cell.
    fn below(&self, cell: usize, edges: &[Edge]) -> Below {
        let (from, to) = self.ends(cell);
        let reach = self.wheel_radius + MARGIN;
        let (first, last) = (self.cell(from - reach), self.cell(to + reach));
        let reach = self.reach(first, last, edges);
        let (from, to) = (*reach.edges.start(), *reach.edges.end());
        let single = if self.breaks(&reach.edges).next().is_none() {
            // See `Reach::has_one_minimum`.
            [reach.high, reach.low + 1.0 / reach.max_second_derivative]
        } else {
            [f64::INFINITY, f64::NEG_INFINITY]
        };
        let edges = [from as u32, to as u32];
        Below { edges, single }
    }

    /// How the contacts of a wheel are found best.
    #[inline]
    pub fn near(&self, centre: Vec2, radius: f64) -> Near {
        let Below { edges, single } = &self.below[self.cell(centre.x)];
        if radius > self.wheel_radius {
            return Near::Unknown;
        }
        let [first, last] = edges.map(|edge| edge as usize);
        if centre.y > single[0] && centre.y < single[1] {
            Near::Single([first, last])
        } else if last - first < FEW {
            Near::Few(first..=last)
        } else {
            Near::Unknown
        }
    }

    /// Adds an edge to the cells into which it reaches.
    fn add(&mut self, index: usize, edge: &Edge, next: Option<&Edge>) {
        let number = index as u32;
        let (first, last) = (self.cell(edge.from.x), self.cell(edge.to.x));
        let max_second_derivative = edge.second_derivative_bounds().1;
        for k in first..=last {
            // The ends of a cell carry rounding errors.
            let x = |x: f64| x.clamp(edge.from.x, edge.to.x);
            let ends = self.ends(k);
            let (low, high) = edge.heights(x(ends.0 - MARGIN), x(ends.1 + MARGIN));
            let cell = &mut self.cells[k];
            cell.first = cell.first.min(number);
            cell.low = cell.low.min(low - MARGIN);
            cell.high = cell.high.max(high + MARGIN);
            cell.max_second_derivative = cell.max_second_derivative.max(max_second_derivative);
        }
        if let Some(next) = next
            && (edge.is_concave_corner_with(next) || edge.is_riser() || next.is_riser())
        {
            self.breaks.push(number);
        }
    }

    /// Position of x (m) in cells: 1 at `start`.
    fn in_cells(&self, x: f64) -> f64 {
        (x - self.start) * self.per_metre + 1.0
    }

    /// Index of the cell that holds x (m). It never falls as x rises.
    fn cell(&self, x: f64) -> usize {
        // The cast saturates at 0.
        let cell = self.in_cells(x) as u32;
        (cell as usize).min(self.cells.len() - 1)
    }

    /// x of a cell's start and end, m; infinite at the two outer ends.
    fn ends(&self, cell: usize) -> (f64, f64) {
        let end = self.start + cell as f64 * self.width;
        let from = if cell == 0 {
            f64::NEG_INFINITY
        } else {
            end - self.width
        };
        let last = cell + 1 == self.cells.len();
        (from, if last { f64::INFINITY } else { end })
    }

    /// The edges that reach into the cells `first` to `last`, and possibly one more.
    fn edges(&self, first: usize, last: usize, edges: &[Edge]) -> RangeInclusive<usize> {
        let behind = self.cells.get(last + 1);
        self.cells[first].first as usize..=behind.map_or(edges.len() - 1, |c| c.first as usize)
    }

    /// Index of the edge at x (m); at a joint, of one of the edges that meet there.
    pub fn edge_at(&self, edges: &[Edge], x: f64) -> usize {
        let cell = self.cell(x);
        let range = self.edges(cell, cell, edges);
        let (first, last) = (*range.start(), *range.end());
        // Start near the place that evenly spaced knots would give: most are.
        // The cast saturates at 0.
        let mut guess = {
            let share = self.in_cells(x) - cell as f64;
            (first + (share * (last - first) as f64) as usize).min(last)
        };
        for _ in 0..4 {
            if x > edges[guess].to.x && guess < last {
                guess += 1;
            } else if x < edges[guess].from.x && guess > first {
                guess -= 1;
            } else {
                return guess;
            }
        }
        (first + edges[first..=last].partition_point(|e| e.to.x < x)).min(last)
    }

    /// The ground that a circle can touch; `None` if there is none.
    pub fn within(&self, centre: Vec2, radius: f64, edges: &[Edge]) -> Option<Reach> {
        let reached = |k: &usize| {
            let (cell, (from, to)) = (&self.cells[*k], self.ends(*k));
            let outside = |x: f64, low: f64, high: f64| (low - x).max(x - high).max(0.0);
            let dx = outside(centre.x, from - MARGIN, to + MARGIN);
            let dy = outside(centre.y, cell.low, cell.high);
            dx * dx + dy * dy <= radius * radius
        };
        let mut cells = self.cell(centre.x - radius)..=self.cell(centre.x + radius);
        let first = cells.find(reached)?;
        let last = cells.rev().find(reached).unwrap_or(first);
        Some(self.reach(first, last, edges))
    }

    /// The ground over the cells `first` to `last`.
    fn reach(&self, first: usize, last: usize, edges: &[Edge]) -> Reach {
        let none = Reach {
            edges: self.edges(first, last, edges),
            low: f64::INFINITY,
            high: f64::NEG_INFINITY,
            max_second_derivative: 0.0,
        };
        let add = |all: Reach, c: &Cell| Reach {
            low: all.low.min(c.low),
            high: all.high.max(c.high),
            max_second_derivative: all.max_second_derivative.max(c.max_second_derivative),
            ..all
        };
        self.cells[first..=last].iter().fold(none, add)
    }

    /// Those of `edges`, without the last, whose front end can lie between two local minima of the
    /// distance.
    pub fn breaks(&self, edges: &RangeInclusive<usize>) -> impl Iterator<Item = usize> {
        let (start, end) = (*edges.start(), *edges.end());
        let from = self.breaks.partition_point(|b| (*b as usize) < start);
        let breaks = self.breaks[from..].iter().map(|b| *b as usize);
        breaks.take_while(move |b| *b < end)
    }
}
