//! Tests across crates, one file per topic. The doc comment of a test states what it proves.

// A test may panic.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod acceptance_contacts;
mod acceptance_estimators;
mod acceptance_fig5;
mod acceptance_fig7_fig8;
mod architecture;
mod breaking_off;
mod check;
mod check_command;
mod clearance;
mod clock_of_logs;
mod closed_form;
mod command;
mod conservation;
mod convergence;
mod corpus;
mod determinism;
mod documents;
mod draws;
mod estimator_is_isolated;
mod friction_laws;
mod invariance;
mod key_effects;
mod logs;
mod modules;
mod output_flags;
mod output_folders;
mod path_judgement;
mod progress;
mod properties;
mod random_scenes;
mod readings;
mod reference;
mod rovers;
mod run_command;
mod seeds;
mod sensors;
mod study_command;
mod study_files;
mod study_pages;
mod support;
mod tracks;
mod verify_command;
#[cfg(feature = "viewer")]
mod viewing;
mod weighing;
