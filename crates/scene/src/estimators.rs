//! `[[estimator]]`: presets and what is changed of them.

use crate::key::{Key, Words};
use crate::name;
use crate::range::{above, at_least};
use crate::reader::{Reader, join};
use crate::scene::EstimatorChoice;
use crate::source::{Entry, Node, Origin, Value};
use crate::units::{ANGULAR_FREQUENCY, LENGTH, ROTARY_DAMPING, TIME};
use robhaz_estimator::{EstimatorSettings, Filters, Masses};

/// Where estimators are in the file.
pub(crate) const PATH: &str = "estimator";
/// More than anyone needs side by side.
const MOST: usize = 100;

/// Names of the presets, in the order of [`settings`]. Without `[[estimator]]` all of them run.
pub(crate) const PRESETS: Words = &["paper-body", "paper-wheels", "true-mass", "best"];

/// The keys of one estimator.
pub(crate) const KEYS: &[Key<EstimatorSettings>] = &[
    Key::<EstimatorSettings>::own_word(
        "name",
        "",
        PRESETS,
        "the preset: linkage lumped to the body (Fig. 7), to the wheels (Fig. 8), or where it is; everything that the readings say",
    )
    .required(),
    Key::own(
        "label",
        "its name",
        name::ALLOWED,
        "unique name in tables, figures and file names",
    ),
    Key::number(
        "observer_pole",
        ANGULAR_FREQUENCY,
        above(0.0).at_most(1e6),
        |e| &mut e.observer_pole,
        "pole omega_c of the traction observer, eq. (3)",
    ),
    Key::number(
        "crossover_time",
        TIME,
        above(0.0).at_most(1e6),
        |e| &mut e.crossover_time,
        "crossover between gyro (shorter times) and inclinometer (longer ones)",
    ),
    Key::number(
        "viscous_damping",
        ROTARY_DAMPING,
        at_least(0.0).at_most(1e3),
        |e| &mut e.viscous_damping,
        "damping B that the estimator is told; [model_error] errs on it",
    ),
    Key::word(
        "masses",
        &["body", "wheels", "true"],
        |e| e.masses as usize,
        |e, i| e.masses = [Masses::LumpedToBody, Masses::LumpedToWheels, Masses::True][i],
        "where the linkage's mass is taken to be",
    ),
    Key::word(
        "filters",
        &["paper", "kalman"],
        |e| e.filters as usize,
        |e, i| e.filters = [Filters::Paper, Filters::Kalman][i],
        "traction by eq. (3) and link angles by a complementary filter, or both by Kalman filters",
    ),
    Key::number(
        "moment_lever",
        LENGTH,
        above(0.0).at_most(1e3),
        |e| &mut e.moment_lever,
        "row scaling of eq. (8): moments count as forces at this lever; 1 m as in the paper",
    ),
    Key::switch(
        "inertia",
        |e| &mut e.inertia,
        "inertial loads beside gravity; needs filters = \"kalman\"",
    ),
    Key::switch(
        "whitening",
        |e| &mut e.whitening,
        "eq. (8) weighed by the covariance of what goes into it; needs filters = \"kalman\"",
    ),
    Key::switch(
        "nonnegative",
        |e| &mut e.nonnegative,
        "no negative normal forces",
    ),
    Key::switch(
        "parity",
        |e| &mut e.parity,
        "the parity residual corrects torques and contact angles; needs filters = \"kalman\"",
    ),
    Key::switch(
        "rolling",
        |e| &mut e.rolling,
        "so does rolling without slip; needs filters = \"kalman\"",
    ),
];

/// The settings of a preset.
pub(crate) fn settings(preset: usize) -> EstimatorSettings {
    match preset {
        0 => EstimatorSettings::paper_body(),
        1 => EstimatorSettings::paper_wheels(),
        2 => EstimatorSettings::true_mass(),
        _ => EstimatorSettings::best(),
    }
}

/// The preset that settings come from: masses and filters tell presets apart.
pub(crate) fn preset_of(found: &EstimatorSettings) -> &'static str {
    let preset = match (found.filters, found.masses) {
        (Filters::Kalman, _) => 3,
        (Filters::Paper, Masses::LumpedToBody) => 0,
        (Filters::Paper, Masses::LumpedToWheels) => 1,
        (Filters::Paper, Masses::True) => 2,
    };
    PRESETS[preset]
}

/// All presets under their own names.
pub(crate) fn defaults() -> Vec<EstimatorChoice> {
    let choice = |(i, name): (usize, &&str)| EstimatorChoice {
        name: (*name).to_owned(),
        settings: settings(i),
    };
    PRESETS.iter().enumerate().map(choice).collect()
}

/// The default list as if it were written, for overrides that change a part of it.
pub(crate) fn default_node(origin: &Origin) -> Node {
    let table = |preset: &&str| {
        let name = Entry {
            key: "name".to_owned(),
            origin: origin.clone(),
            node: Node::text(origin, preset),
        };
        Node::table(origin, vec![name])
    };
    Node {
        origin: origin.clone(),
        value: Value::Array(PRESETS.iter().map(table).collect()),
    }
}

/// Reads the list; an empty one means no estimator.
pub(crate) fn read(reader: &mut Reader, root: &Node) -> Vec<EstimatorChoice> {
    let Some(node) = root.get(PATH) else {
        return defaults();
    };
    let Value::Array(items) = &node.value else {
        reader.refuse(node, PATH, "an array of tables, each headed [[estimator]]");
        return Vec::new();
    };
    if items.len() > MOST {
        reader.refuse(node, PATH, &format!("at most {MOST} estimators"));
        return Vec::new();
    }
    let mut choices: Vec<EstimatorChoice> = Vec::new();
    for (i, item) in items.iter().enumerate() {
        let path = format!("{PATH}[{i}]");
        let choice = read_one(reader, item, &path);
        let taken = choices.iter().position(|c| c.name == choice.name);
        if let (Some(other), false) = (taken, choice.name.is_empty()) {
            let by = item.get("label").or_else(|| item.get("name"));
            reader.refuse(
                by.unwrap_or(item),
                &join(&path, "label"),
                &format!("a label that {PATH}[{other}] does not have"),
            );
        }
        choices.push(choice);
    }
    choices
}

fn read_one(reader: &mut Reader, node: &Node, path: &str) -> EstimatorChoice {
    let preset = node
        .get("name")
        .and_then(|n| reader.word(PRESETS, n, &join(path, "name")));
    let mut settings = settings(preset.unwrap_or(0));
    reader.table(KEYS, node, path, &mut settings);
    if settings.filters == Filters::Paper {
        let on = [
            ("inertia", settings.inertia),
            ("whitening", settings.whitening),
            ("parity", settings.parity),
            ("rolling", settings.rolling),
        ];
        for (key, _) in on.iter().filter(|(_, on)| *on) {
            let found = node.get(key).unwrap_or(node);
            let allowed = "\"off\" unless filters = \"kalman\"";
            reader.refuse(found, &join(path, key), allowed);
        }
    }
    let label = match node.get("label") {
        Some(label) => name::read(reader, label, &join(path, "label")),
        None => preset.map(|p| PRESETS[p].to_owned()),
    };
    EstimatorChoice {
        // Empty after a problem only.
        name: label.unwrap_or_default(),
        settings,
    }
}
