//! The ground of a rover with both sides: what its wheels have found, between the tracks of its
//! left and its right wheels.
//!
//! It begins under the six wheels of the first row. From there on the wheels that lead extend it:
//! those in front of a rover that drives forward, those at the rear of one that drives back. Ground
//! over which a wheel has rolled is not drawn again: what dead reckoning has drifted since would
//! tear it.

use crate::colours::GROUND;
use crate::draw::solid;
use crate::error::Result;
use crate::writer::Writer;
use re_sdk_types::archetypes::Mesh3D;
use re_sdk_types::components::AlbedoFactor;
use robhaz_estimator::whole::Vec3;
use robhaz_model::WholeRover;

/// Distance between rows of the ground over the wheelbase.
const STEP: f64 = 0.04;
/// Number of rows of a mesh: each new row writes its mesh again.
const ROWS: usize = 32;
/// How far below the contacts it is drawn, over the wheel radius: tracks lie on it, also those of
/// wheels that pass later, as far as dead reckoning has drifted little.
const BELOW: f64 = 0.1;

/// Its left and its right point, m.
type Row = [Vec3; 2];

/// The ground that was found so far.
pub(super) struct Ground {
    /// How far a row reaches beyond the contacts of each axle, and below them, m.
    beside: [f64; 3],
    below: f64,
    /// Distance between rows, m.
    step: f64,
    /// Number of meshes that are complete.
    complete: usize,
    /// Rows of the newest mesh.
    rows: Vec<Row>,
    /// The newest row of the front and the rear wheels.
    ends: Option<[Row; 2]>,
    /// Which end the newest mesh belongs to.
    end: usize,
    /// Way of the rover, and the farthest one forward and back, m.
    way: f64,
    farthest: [f64; 2],
    /// Times (s), entities and meshes that are not logged yet.
    meshes: Vec<(f64, usize, Vec<Row>)>,
}

impl Ground {
    /// No ground yet, of a rover with wheels of a width (m). It reaches to the outer sides of the
    /// wheels with the widest track.
    pub(super) fn new(rover: &WholeRover, width: f64) -> Self {
        let geometry = &rover.side.geometry;
        let widest = rover.half_tracks.into_iter().fold(0.0, f64::max);
        Self {
            beside: rover.half_tracks.map(|half| widest - half + width),
            below: BELOW * geometry.wheel_radius,
            step: STEP * geometry.wheelbase(),
            complete: 0,
            rows: Vec::new(),
            ends: None,
            end: 0,
            way: 0.0,
            farthest: [0.0; 2],
            meshes: Vec::new(),
        }
    }

    /// Adds the ground under the contacts (m) of a time (s), after a way (m, back negative).
    pub(super) fn push(&mut self, time: f64, way: f64, contacts: [Vec3; 6]) {
        self.way += way;
        let (beside, down) = (self.beside, Vec3::z() * self.below);
        let row = |wheel: usize| -> Row {
            let (left, right) = (contacts[wheel], contacts[wheel + 3]);
            let out = (left - right).try_normalize(0.0).unwrap_or_else(Vec3::y) * beside[wheel];
            [left + out - down, right - out - down]
        };
        let now = [row(0), row(2)];
        let Some(ends) = &mut self.ends else {
            self.ends = Some(now);
            self.rows = vec![now[1], row(1), now[0]];
            self.meshes.push((time, self.complete, self.rows.clone()));
            return;
        };
        for (end, ahead) in [1.0, -1.0].into_iter().enumerate() {
            let moved = ends[end].iter().zip(&now[end]);
            let moved = moved.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            let leads = ahead * self.way >= self.farthest[end];
            if !leads || moved < self.step {
                continue;
            }
            self.farthest[end] = ahead * self.way;
            if self.end != end || self.rows.len() >= ROWS {
                self.complete += 1;
                self.end = end;
                self.rows = vec![ends[end]];
            }
            ends[end] = now[end];
            self.rows.push(now[end]);
            self.meshes.push((time, self.complete, self.rows.clone()));
        }
    }

    /// Logs what was added since the last call.
    pub(super) fn flush(&mut self, out: &mut Writer) -> Result {
        for (time, mesh, rows) in self.meshes.drain(..) {
            out.at(format!("world/ground/{mesh}"), time, &surface(&rows))?;
        }
        Ok(())
    }
}

/// The surface between rows, seen from above and below.
fn surface(rows: &[Row]) -> Mesh3D {
    let vertices = rows.iter().flatten().map(solid);
    // A row has 2 vertices, of at most ROWS.
    let quads = (1..rows.len() as u32).flat_map(|k| {
        let [a, b, c, d] = [2 * k - 2, 2 * k - 1, 2 * k, 2 * k + 1];
        [[a, b, c], [c, b, d]]
    });
    let normals = (0..rows.len()).map(|k| {
        let (before, after) = (rows[k.saturating_sub(1)], rows[(k + 1).min(rows.len() - 1)]);
        let along = after[0] + after[1] - before[0] - before[1];
        let across = rows[k][0] - rows[k][1];
        let normal = along.cross(&across).try_normalize(0.0);
        let normal = normal.unwrap_or_else(Vec3::z);
        // Where a rover turns on the spot the rows cross: no rover drives on ground steeper than 60 deg.
        match normal.z {
            z if z.abs() < 0.5 => Vec3::z(),
            z => normal * z.signum(),
        }
    });
    let normals: Vec<_> = normals.flat_map(|n| [solid(&n), solid(&n)]).collect();
    Mesh3D::new(vertices)
        .with_triangle_indices(quads)
        .with_vertex_normals(normals)
        .with_albedo_factor(AlbedoFactor(GROUND.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_scene::RobotChoice;
    use std::path::Path;

    fn rover() -> WholeRover {
        let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
        let choice = RobotChoice::load(&robots.join("open-source-rover.toml"));
        choice
            .ok()
            .and_then(|c| c.whole_rover())
            .unwrap_or_else(|| panic!("a rover"))
    }

    /// Closed form: a rover that drives a metre forward and 1.5 m back has ground from its rear wheels
    /// half a metre behind the start to its front wheels a metre ahead, each place once.
    #[test]
    fn ground_is_drawn_once() {
        let rover = rover();
        let mut ground = Ground::new(&rover, 0.05);
        let axles = rover.side.geometry.axles;
        let mut x = 0.0;
        for k in 0..=250 {
            let to = if k <= 100 {
                0.01 * f64::from(k)
            } else {
                0.01 * f64::from(200 - k)
            };
            let contacts = std::array::from_fn(|i| {
                let y = rover.half_tracks[i % 3] * if i < 3 { 1.0 } else { -1.0 };
                Vec3::new(axles[i % 3].x + to, y, 0.0)
            });
            ground.push(f64::from(k), to - x, contacts);
            x = to;
        }
        let mut newest = std::collections::BTreeMap::new();
        for (_, mesh, rows) in &ground.meshes {
            newest.insert(*mesh, rows.clone());
        }
        assert!(newest.values().all(|rows| rows.len() <= ROWS));
        let pieces: Vec<_> = newest.values().flat_map(|rows| rows.windows(2)).collect();
        let length = |piece: &&[Row]| (piece[1][0].x - piece[0][0].x).abs();
        let drawn: f64 = pieces.iter().map(length).sum();
        // The newest row is at most a step and a sample behind.
        let wheelbase = rover.side.geometry.wheelbase();
        let step = STEP * wheelbase + 0.01;
        assert!((drawn - (wheelbase + 1.5)).abs() < 2.0 * step, "{drawn}");
        let x = pieces.iter().flat_map(|p| p.iter()).map(|row| row[0].x);
        let (low, high) = (
            x.clone().fold(f64::MAX, f64::min),
            x.fold(f64::MIN, f64::max),
        );
        assert!(
            (low - (axles[2].x - 0.5)).abs() < step && (high - (axles[0].x + 1.0)).abs() < step
        );
    }
}
