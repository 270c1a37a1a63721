//! `robhaz estimate` and `robhaz export`: recorded logs give the estimates of the run, and faults
//! of logs are reported.

mod body;
mod both;
mod both_faults;
mod both_forms;
mod documents;
mod equivalence;
mod faults;
mod formats;
mod messages_and_clocks;
mod recorded;
