//! `[[estimator]]`: presets and what is changed of them.

use crate::key::{Key, Words};
use crate::name;
use crate::range::{above, at_least};
use crate::reader::{Reader, join};
use crate::scene::EstimatorChoice;
use crate::source::{Entry, Node, Origin, Value};
use crate::units::{ANGULAR_FREQUENCY, ROTARY_DAMPING, TIME};
use robhaz_estimator::EstimatorSettings;

/// Where estimators are in the file.
pub(crate) const PATH: &str = "estimator";
/// More than anyone needs side by side.
const MOST: usize = 100;

/// Names of the presets, in the order of [`settings`]. Without `[[estimator]]` all of them run.
pub(crate) const PRESETS: Words = &["paper-body", "paper-wheels", "true-mass"];

/// The keys of one estimator.
pub(crate) const KEYS: &[Key<EstimatorSettings>] = &[
    Key::<EstimatorSettings>::own_word(
        "name",
        "",
        PRESETS,
        "the preset: linkage lumped to the body (Fig. 7), to the wheels (Fig. 8), or where it is",
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
];

/// The settings of a preset.
pub(crate) fn settings(preset: usize) -> EstimatorSettings {
    match preset {
        0 => EstimatorSettings::paper_body(),
        1 => EstimatorSettings::paper_wheels(),
        _ => EstimatorSettings::true_mass(),
    }
}

/// The preset that settings come from: only the masses tell presets apart.
pub(crate) fn preset_of(found: &EstimatorSettings) -> &'static str {
    let of = |i: &usize| settings(*i).masses == found.masses;
    let index = (0..PRESETS.len()).find(of);
    index.map_or("true-mass", |i| PRESETS[i])
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
