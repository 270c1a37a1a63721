//! Logs as they really come: stamps, encoders, currents, units and topics with the faults that users report. Each test
//! makes a log, says what is right, and holds `robhaz check` and `robhaz estimate` to it.

mod diagnosis;
mod instants;
mod jumps;
mod level_drive;
mod messages;
mod ros;
mod sides;
mod signs;
mod text;
mod zeros;
