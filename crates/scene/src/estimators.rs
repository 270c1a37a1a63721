//! `[[estimator]]`: presets, and the keys that change them.

use crate::json;
use crate::key::{Key, Words};
use crate::name;
use crate::range::{above, at_least};
use crate::reader::{Reader, join};
use crate::source::{Entry, Node, Origin, Value};
use crate::units::{ANGULAR_FREQUENCY, LENGTH, ROTARY_DAMPING, TIME};
use robhaz_estimator::{
    ContactAngles, EstimatorSettings, Filters, KalmanMethod, Masses, Method, PaperMethod,
};

/// Key of the list of estimators.
pub(crate) const PATH: &str = "estimator";
/// Largest number of estimators of a scene.
const MOST: usize = 100;

/// An estimator to run on the readings.
#[derive(Clone, Debug, PartialEq)]
pub struct EstimatorChoice {
    /// Name in tables, figures and file names.
    pub name: String,
    /// Its method and parameters.
    pub settings: EstimatorSettings,
}

/// Names of the presets, in the order of [`settings`].
pub(crate) const PRESETS: Words = &["paper-body", "paper-wheels", "true-mass", "best"];

/// The values of the keys of one estimator, those of both methods: a file may name keys in any order.
/// [`Keys::settings`] turns them into settings, which hold one method only.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Keys {
    masses: Masses,
    filters: Filters,
    paper: PaperMethod,
    kalman: KalmanMethod,
    viscous_damping: f64,
    moment_lever: f64,
    nonnegative: bool,
}

impl Keys {
    /// The keys that give these settings. Those of the other method are at their defaults.
    pub fn of(settings: &EstimatorSettings) -> Self {
        let (paper, kalman) = match settings.method {
            Method::Paper(paper) => (paper, KalmanMethod::FILTERS_ONLY),
            Method::Kalman(kalman) => (PaperMethod::DEFAULT, kalman),
        };
        Self {
            masses: settings.masses,
            filters: settings.method.filters(),
            paper,
            kalman,
            viscous_damping: settings.viscous_damping,
            moment_lever: settings.moment_lever,
            nonnegative: settings.nonnegative,
        }
    }

    fn settings(&self, preset: &EstimatorSettings) -> EstimatorSettings {
        EstimatorSettings {
            masses: self.masses,
            method: match self.filters {
                Filters::Paper => Method::Paper(self.paper),
                Filters::Kalman => Method::Kalman(self.kalman),
            },
            viscous_damping: self.viscous_damping,
            moment_lever: self.moment_lever,
            nonnegative: self.nonnegative,
            compression: preset.compression,
            budget: preset.budget,
        }
    }
}

/// The keys of one estimator.
pub(crate) const KEYS: &[Key<Keys>] = &[
    Key::<Keys>::own_word(
        "name",
        "",
        PRESETS,
        "the preset: the linkage's mass lumped to the body (Fig. 7), lumped to the wheels (Fig. 8) or at its true place; or Kalman filters with all methods",
    )
    .required(),
    Key::own(
        "label",
        "its name",
        name::FORM,
        "unique name in tables, figures and file names",
    ),
    Key::number(
        "observer_pole",
        ANGULAR_FREQUENCY,
        above(0.0).at_most(1e6),
        |e| &mut e.paper.observer_pole,
        "pole omega_c of the traction observer, eq. (3); needs filters = \"paper\"",
    ),
    Key::number(
        "crossover_time",
        TIME,
        above(0.0).at_most(1e6),
        |e| &mut e.paper.crossover_time,
        "crossover between gyroscope (shorter times) and inclinometer (longer times); needs filters = \"paper\"",
    ),
    Key::number(
        "viscous_damping",
        ROTARY_DAMPING,
        at_least(0.0).at_most(1e3),
        |e| &mut e.viscous_damping,
        "nominal damping B; [model_error] adds its error",
    ),
    Key::word(
        "masses",
        &["body", "wheels", "true"],
        |e| e.masses as usize,
        |e, i| e.masses = [Masses::LumpedToBody, Masses::LumpedToWheels, Masses::True][i],
        "place of the linkage's mass",
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
        "row scaling of eq. (8): moments count as forces at this lever; 1 m in the paper",
    ),
    Key::word(
        "contact_angles",
        &["given", "none"],
        |e| e.kalman.contact_angles as usize,
        |e, i| e.kalman.contact_angles = [ContactAngles::Given, ContactAngles::Unknown][i],
        "whether the estimator reads the contact angles, as the paper does, or finds them itself; none needs rolling = \"on\"",
    ),
    Key::switch(
        "inertia",
        |e| &mut e.kalman.inertia,
        "inertial loads in addition to gravity; needs filters = \"kalman\"",
    ),
    Key::switch(
        "whitening",
        |e| &mut e.kalman.whitening,
        "eq. (8) weighted by the inverse covariance of its right-hand side; needs filters = \"kalman\"",
    ),
    Key::switch(
        "nonnegative",
        |e| &mut e.nonnegative,
        "no negative normal forces",
    ),
    Key::switch(
        "parity",
        |e| &mut e.kalman.parity,
        "the parity residual corrects torques and contact angles; needs filters = \"kalman\"",
    ),
    Key::switch(
        "rolling",
        |e| &mut e.kalman.rolling,
        "the rolling constraints correct torques and contact angles; needs filters = \"kalman\"",
    ),
];

/// Index of the preset `best`.
pub(crate) const BEST: usize = 3;

/// The settings of a preset.
pub(crate) fn settings(preset: usize) -> EstimatorSettings {
    match preset {
        0 => EstimatorSettings::paper_body(),
        1 => EstimatorSettings::paper_wheels(),
        2 => EstimatorSettings::true_mass(),
        _ => EstimatorSettings::best(),
    }
}

/// The preset that settings come from: presets differ in masses and method.
pub(crate) fn preset_of(found: &EstimatorSettings) -> &'static str {
    let preset = match (found.method, found.masses) {
        (Method::Kalman(_), _) => BEST,
        (Method::Paper(_), Masses::LumpedToBody) => 0,
        (Method::Paper(_), Masses::LumpedToWheels) => 1,
        (Method::Paper(_), Masses::True) => 2,
    };
    PRESETS[preset]
}

/// Label of the default estimator that is given no contact angles.
pub(crate) const WITHOUT_ANGLES: &str = "no-angles";

/// The estimators of a scene that lists none: all presets under their own names, and `best` without contact angles.
pub(crate) fn defaults() -> Vec<EstimatorChoice> {
    let choice = |(i, name): (usize, &&str)| EstimatorChoice {
        name: (*name).to_owned(),
        settings: settings(i),
    };
    let without_angles = EstimatorChoice {
        name: WITHOUT_ANGLES.to_owned(),
        settings: EstimatorSettings::best_without_angles(),
    };
    let presets = PRESETS.iter().enumerate().map(choice);
    presets.chain([without_angles]).collect()
}

/// The default list as a node, for overrides that change a part of it.
pub(crate) fn default_node(origin: &Origin) -> Node {
    let entry = |key: &str, word: &str| Entry {
        key: key.to_owned(),
        origin: origin.clone(),
        node: Node::text(origin, word),
    };
    let preset = |name: &&str| Node::table(origin, vec![entry("name", name)]);
    let without_angles = vec![
        entry("name", PRESETS[BEST]),
        entry("label", WITHOUT_ANGLES),
        entry("contact_angles", "none"),
    ];
    let without_angles = Node::table(origin, without_angles);
    Node {
        origin: origin.clone(),
        value: Value::Array(PRESETS.iter().map(preset).chain([without_angles]).collect()),
    }
}

/// JSON Schema of the list. Defaults are those of the preset.
pub(crate) fn schema() -> serde_json::Value {
    json::array(json::table(KEYS, None), 0, MOST)
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
    let preset_settings = settings(preset.unwrap_or(0));
    let mut keys = Keys::of(&preset_settings);
    reader.table(KEYS, node, path, &mut keys);
    refuse_other_method(reader, node, path, &keys);
    let label = match node.get("label") {
        Some(label) => name::read(reader, label, &join(path, "label")),
        None => preset.map(|p| PRESETS[p].to_owned()),
    };
    EstimatorChoice {
        // Empty after a problem only.
        name: label.unwrap_or_default(),
        settings: keys.settings(&preset_settings),
    }
}

/// Refuses keys without effect: steps that need the Kalman filters, and time constants of the paper's filters.
fn refuse_other_method(reader: &mut Reader, node: &Node, path: &str, keys: &Keys) {
    let (paper, kalman, default) = (&keys.paper, &keys.kalman, PaperMethod::DEFAULT);
    let is_paper = keys.filters == Filters::Paper;
    let steps = [
        ("inertia", kalman.inertia),
        ("whitening", kalman.whitening),
        ("parity", kalman.parity),
        ("rolling", kalman.rolling),
    ];
    for (key, _) in steps.iter().filter(|(_, on)| is_paper && *on) {
        let found = node.get(key).unwrap_or(node);
        let allowed = "\"off\" unless filters = \"kalman\"";
        reader.refuse(found, &join(path, key), allowed);
    }
    if kalman.contact_angles == ContactAngles::Unknown && (is_paper || !kalman.rolling) {
        let found = node.get("contact_angles").unwrap_or(node);
        let allowed = "\"given\" unless filters = \"kalman\" and rolling = \"on\"";
        reader.refuse(found, &join(path, "contact_angles"), allowed);
    }
    let times = [
        ("observer_pole", paper.observer_pole, default.observer_pole),
        (
            "crossover_time",
            paper.crossover_time,
            default.crossover_time,
        ),
    ];
    // The default is allowed: a resolved scene names every key.
    for (key, _, default) in times
        .iter()
        .filter(|(_, found, default)| !is_paper && found.to_bits() != default.to_bits())
    {
        let found = node.get(key).unwrap_or(node);
        let allowed = format!("{default} unless filters = \"paper\"");
        reader.refuse(found, &join(path, key), &allowed);
    }
}
