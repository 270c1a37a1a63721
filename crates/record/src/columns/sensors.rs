//! The columns of `sensors` and `commands`.

use super::{Source, Table, WHEEL};
use robhaz_model::WheelCommand;

impl Table {
    /// `sensors`: the readings, which are all that an estimator sees; empty where a reading was
    /// lost.
    pub fn sensors() -> Self {
        let mut table = Self::new("sensors");
        table.columns.clear();
        columns! { table, Source::record; "", ""; "time", "s", "time stamp of the sample" => |f| f.sensors.time; }
        for (i, of) in WHEEL.into_iter().enumerate() {
            columns! { table, Source::record_or_none; format!("wheel{}_", i + 1), of;
                "angle", "rad", "encoder, turn against its link, forward positive" => move |f| f.sensors.wheel_angle[i];
                "motor_torque", "N m", "motor torque from its current, after the gear, forward positive" =>
                    move |f| f.sensors.motor_torque[i];
                "contact_angle", "rad", "contact angle gamma as given to the estimators" => move |f| f.sensors.contact_angle[i];
            }
        }
        columns! { table, Source::record_or_none; "", "";
            "link1_inclination", "rad", "inclinometer on link1, turn from the nominal pose" => |f| f.sensors.link1.inclination;
            "link1_rate", "rad/s", "rate gyroscope on link1" => |f| f.sensors.link1.rate;
            "link1_rate_error", "rad/s", "what link1_rate errs by beyond a gyroscope's noise, where it follows from the angle of a joint" => |f| Some(f.sensors.link1.rate_error);
            "link2_inclination", "rad", "inclinometer on link2, turn from the nominal pose" => |f| f.sensors.link2.inclination;
            "link2_rate", "rad/s", "rate gyroscope on link2" => |f| f.sensors.link2.rate;
            "link2_rate_error", "rad/s", "what link2_rate errs by beyond a gyroscope's noise, where it follows from the angle of a joint" => |f| Some(f.sensors.link2.rate_error);
        }
        table
    }

    /// `commands`: what the control asks of each wheel after the readings of a record. It acts from
    /// the next sample on. A wheel has a torque or a set speed, or neither where its drive follows
    /// its own plan.
    pub fn commands() -> Self {
        let mut table = Self::new("commands");
        for (i, of) in WHEEL.into_iter().enumerate() {
            columns! { table, Source::record_or_none; format!("wheel{}_", i + 1), of;
                "torque_command", "N m", "commanded motor torque, forward positive" => move |f| match f.commands?[i] {
                    WheelCommand::Torque(torque) => Some(torque),
                    WheelCommand::Planned | WheelCommand::Speed(_) => None,
                };
                "speed_command", "rad/s", "commanded spin speed, forward positive" => move |f| match f.commands?[i] {
                    WheelCommand::Speed(speed) => Some(speed),
                    WheelCommand::Planned | WheelCommand::Torque(_) => None,
                };
            }
        }
        table
    }
}
