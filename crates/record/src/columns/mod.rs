//! The columns of every table, each declared once: name, unit, meaning, and where its value comes from.

mod column;
mod estimate;
mod sensors;
#[cfg(test)]
mod tests;
mod truth;

pub use column::{Column, Kind, Table, Value};
use robhaz_scene::Scene;

impl Table {
    /// All tables of a scene: `truth`, `sensors`, and one for each estimator.
    pub fn all(scene: &Scene) -> Vec<Self> {
        let mut tables = vec![Self::truth(), Self::sensors()];
        for (index, estimator) in scene.estimators.iter().enumerate() {
            tables.push(Self::estimate(index, &estimator.name));
        }
        tables
    }
}
