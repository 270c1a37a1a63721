//! The columns of `commands`.

use super::column::{Column, Source, Table, WHEEL, column, time_of_record};
use robhaz_model::WheelCommand;

impl Table {
    /// `commands`: what the control asks of each wheel after the readings of a record. It acts from the next sample on. A
    /// wheel has a torque or a set speed, or neither where its drive follows its own plan.
    pub fn commands() -> Self {
        let mut columns = vec![time_of_record()];
        for i in 0..3 {
            columns.push(of_wheel(
                i,
                "torque",
                "N m",
                "motor torque",
                |command| match command {
                    WheelCommand::Torque(torque) => Some(torque),
                    WheelCommand::Planned | WheelCommand::Speed(_) => None,
                },
            ));
            columns.push(of_wheel(
                i,
                "speed",
                "rad/s",
                "spin speed",
                |command| match command {
                    WheelCommand::Speed(speed) => Some(speed),
                    WheelCommand::Planned | WheelCommand::Torque(_) => None,
                },
            ));
        }
        Self {
            name: "commands".to_owned(),
            columns,
        }
    }
}

fn of_wheel(
    i: usize,
    quantity: &str,
    unit: &'static str,
    meaning: &str,
    get: impl Fn(WheelCommand) -> Option<f64> + Send + Sync + 'static,
) -> Column {
    let value = move |commands: [WheelCommand; 3]| get(commands[i]);
    let source = Source::optional(move |f| f.commands.and_then(&value));
    column(
        format!("wheel{}_{quantity}_command", i + 1),
        unit,
        format!("{}: commanded {meaning}, forward positive", WHEEL[i]),
        source,
    )
}
