//! The checks of logs: honest and faulty readings.

mod body;
mod clock_faults;
mod common;
mod drivers;
mod fault_times;
mod health;
mod honest_logs;
mod loose_soil;
mod rovers;
mod study;
mod torque_scale;
mod trusted;
