//! The columns of every table, each declared once: name, unit, description, and the source of its
//! values.

mod column;
mod estimate;
mod sensors;
mod truth;

pub use column::{Column, Kind, Table};
use robhaz_model::Suspension;
use robhaz_run::RunDescription;

impl Table {
    /// All tables of a run: `truth` of a simulation, `sensors`, `commands` of a control that takes
    /// readings, and one for each estimator.
    pub fn all(run: &RunDescription) -> Vec<Self> {
        let truth = run.world.as_ref().map(|_| Self::truth());
        let estimators = run.estimators.iter().enumerate();
        let estimates = estimators.map(|(index, e)| Self::estimate(index, &e.label));
        let tables = truth.into_iter().chain([Self::sensors()]);
        let commands = run.takes_commands().then(Self::commands);
        let mut tables: Vec<Self> = tables.chain(commands).chain(estimates).collect();
        if run.nominal_robot.geometry.suspension != Suspension::FourBar {
            let of_four_bar = |name: &str| {
                let starts = ["link3_", "pin_p_", "pin_r_", "pin_s_", "loop_error"];
                starts.iter().any(|start| name.starts_with(start))
            };
            for table in &mut tables {
                table.columns.retain(|column| !of_four_bar(&column.name));
            }
        }
        tables
    }
}
