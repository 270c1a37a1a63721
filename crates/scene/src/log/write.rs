//! The resolved log description as a file.

use super::choice::{LogChoice, LogEstimator};
use super::keys::SECTIONS;
use super::load::ROBOTS_BUDGET;
use crate::estimators::{self, Keys};
use crate::key::Key;
use crate::robot::RobotChoice;
use crate::sections::IGNORED;
use crate::write::{Out, text, write_robot};
use robhaz_estimator::EstimatorSettings;
use robhaz_estimator::statics::LoadCovariance;

impl RobotChoice {
    /// A weighed robot as a file: `[robot]`, and the keys of `[budget]` that go with it. `version` names the program that
    /// writes it.
    pub fn weighed_to_toml(&self, covariance: &LoadCovariance, version: &str) -> String {
        let mut out = Out::default();
        out.line(
            "# A weighed robot, and how exact it is. SI units. For `robhaz estimate --robot`.",
        );
        out.head(&format!("[{IGNORED}]"), "what wrote this file; not read");
        out.key("version", &text(version), "");
        write_robot(&mut out, self);
        let mut choice = LogChoice::default();
        let budget = &mut choice.budget;
        (budget.body_cg, budget.link_mass) = (0.0, 0.0);
        budget.load_covariance = Some(*covariance);
        for section in SECTIONS.iter().filter(|s| s.name == "budget") {
            out.head(&format!("[{}]", section.name), "errors of the weighing");
            let is_of_robot = |k: &&Key<LogChoice>| ROBOTS_BUDGET.contains(&k.name);
            for key in section.keys.iter().filter(is_of_robot) {
                out.field(key, &mut choice);
            }
        }
        out.into_text()
    }
}

impl LogChoice {
    /// The description as a file that reads back as this one. `version` names the program that writes it.
    pub fn to_toml(&self, version: &str) -> String {
        let mut out = Out::default();
        out.line("# What was known of a log, with every choice written out. SI units.");
        if let Some(name) = &self.name {
            out.key("name", &text(name), "");
        }
        if self.estimators.is_empty() {
            out.key(estimators::PATH, "[]", "none");
        }
        out.head(&format!("[{IGNORED}]"), "what wrote this file; not read");
        out.key("version", &text(version), "");
        write_robot(&mut out, &self.robot);
        let mut choice = self.clone();
        for section in SECTIONS {
            out.head(&format!("[{}]", section.name), section.meaning);
            out.table(section.keys, &mut choice, section.name);
        }
        for estimator in &self.estimators {
            self.write_estimator(&mut out, estimator);
        }
        out.into_text()
    }

    fn write_estimator(&self, out: &mut Out, estimator: &LogEstimator) {
        let listed = &estimator.choice.settings;
        let nominal = EstimatorSettings {
            viscous_damping: estimator.viscous_damping,
            ..*listed
        };
        // With the common damping the settings stay those of a preset, whose figure has its own name.
        let is_common = estimator.viscous_damping.to_bits() == self.viscous_damping.to_bits();
        let mut keys = Keys::of(if is_common { listed } else { &nominal });
        out.head(&format!("[[{}]]", estimators::PATH), "");
        out.key("name", &text(estimators::preset_of(listed)), "");
        out.key("label", &text(&estimator.choice.name), "");
        for key in estimators::KEYS {
            if !(is_common && key.name == "viscous_damping") {
                out.field(key, &mut keys);
            }
        }
    }
}
