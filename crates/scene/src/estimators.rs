//! `[[estimator]]`: presets, and the keys that change them.

use robhaz_estimator::{
    ContactAngles, EstimatorSettings, KalmanMethod, Masses, Method, PaperMethod,
};
use robhaz_keys::prelude::*;
use robhaz_model::named;
use serde_json::Value as Json;

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
    /// Nominal viscous damping of its own, N m s; `None` for that of `[drive]`.
    pub damping: Option<f64>,
}

/// Name and settings of a preset.
type Preset = (&'static str, EstimatorSettings);

/// The presets.
pub(crate) const PRESETS: [Preset; 4] = [
    ("paper-body", EstimatorSettings::paper_body()),
    ("paper-wheels", EstimatorSettings::paper_wheels()),
    ("true-mass", EstimatorSettings::true_mass()),
    ("kalman", EstimatorSettings::kalman()),
];

/// The values of the keys of one estimator, those of both methods: a file may name keys in any
/// order. [`Keys::choice`] makes settings of them, which hold one method only.
#[derive(Clone, Debug)]
pub(crate) struct Keys {
    preset: Preset,
    filters: Filters,
    paper: PaperMethod,
    kalman: KalmanMethod,
    /// All but the method.
    choice: EstimatorChoice,
}

named! {
    /// The method.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub enum Filters {
        /// Traction by eq. (3), link angles by a complementary filter.
        Paper = "paper",
        /// Both by Kalman filters.
        Kalman = "kalman",
    }
}

impl Keys {
    /// The keys that give this estimator. Those of the other method are at their defaults.
    fn of(choice: EstimatorChoice) -> Self {
        let (filters, paper, kalman) = match choice.settings.method {
            Method::Paper(paper) => (Filters::Paper, paper, KalmanMethod::FILTERS_ONLY),
            Method::Kalman(kalman) => (Filters::Kalman, PaperMethod::DEFAULT, kalman),
        };
        Self {
            preset: preset_of(&choice.settings),
            filters,
            paper,
            kalman,
            choice,
        }
    }

    fn choice(self) -> EstimatorChoice {
        let mut choice = self.choice;
        choice.settings.method = match self.filters {
            Filters::Paper => Method::Paper(self.paper),
            Filters::Kalman => Method::Kalman(self.kalman),
        };
        if let Some(damping) = choice.damping {
            choice.settings.viscous_damping = damping;
        }
        choice
    }
}

keys! {
    /// The keys of one estimator.
    pub(crate) KEYS: Keys;

    /// the preset: the linkage's mass lumped to the body (Fig. 7), lumped to the wheels (Fig. 8) or
    /// at its true place; or Kalman filters with all methods
    name (required): word(&PRESETS, |preset| preset.0) => preset;

    /// unique name in tables, figures and file names
    label ("its name"): NAME => choice.name;

    /// pole omega_c of the traction observer, eq. (3); needs filters = "paper"
    observer_pole: number(ANGULAR_FREQUENCY, above(0.0).at_most(1e6)) => paper.observer_pole;

    /// crossover between gyroscope (shorter times) and inclinometer (longer times); needs filters =
    /// "paper"
    crossover_time: number(TIME, above(0.0).at_most(1e6)) => paper.crossover_time;

    /// nominal damping B; [model_error] adds its error
    viscous_damping ("that of the drive"): Maybe(number(ROTARY_DAMPING, at_least(0.0).at_most(1e3))) => choice.damping;

    /// place of the linkage's mass
    masses: word(&Masses::ALL, Masses::name) => choice.settings.masses;

    /// traction by eq. (3) and link angles by a complementary filter, or both by Kalman filters
    filters: word(&Filters::ALL, Filters::name) => filters;

    /// row scaling of eq. (8): moments count as forces at this lever; 1 m in the paper
    moment_lever: number(LENGTH, above(0.0).at_most(1e3)) => choice.settings.moment_lever;

    /// whether the estimator reads the contact angles, as the paper does, or finds them itself;
    /// none needs rolling = "on"
    contact_angles: word(&ContactAngles::ALL, ContactAngles::name) => kalman.contact_angles;

    /// inertial loads in addition to gravity; needs filters = "kalman"
    inertia: SWITCH => kalman.inertia;

    /// eq. (8) weighted by the inverse covariance of its right-hand side; needs filters = "kalman"
    whitening: SWITCH => kalman.whitening;

    /// no negative normal forces
    nonnegative: SWITCH => choice.settings.nonnegative;

    /// the parity residual corrects torques and contact angles; needs filters = "kalman"
    parity: SWITCH => kalman.parity;

    /// the rolling constraints correct torques and contact angles; needs filters = "kalman"
    rolling: SWITCH => kalman.rolling;
}

/// Index of the preset `kalman`.
pub(crate) const KALMAN: usize = PRESETS.len() - 1;

/// The preset that settings come from: presets differ in masses and filters.
fn preset_of(found: &EstimatorSettings) -> Preset {
    let key = |s: &EstimatorSettings| (!s.states_covariance()).then_some(s.masses);
    let is_it = |preset: &(_, EstimatorSettings)| key(&preset.1) == key(found);
    PRESETS.into_iter().find(is_it).unwrap_or(PRESETS[KALMAN])
}

/// Label of the default estimator that is given no contact angles.
pub(crate) const WITHOUT_ANGLES: &str = "kalman-no-angles";

/// The estimators of a scene that lists none: all presets under their own names, and `kalman` without
/// contact angles.
pub(crate) fn defaults() -> Vec<EstimatorChoice> {
    let without_angles = (WITHOUT_ANGLES, EstimatorSettings::kalman_without_angles());
    let all = PRESETS.into_iter().chain([without_angles]);
    all.map(choice_of).collect()
}

fn choice_of((name, settings): Preset) -> EstimatorChoice {
    EstimatorChoice {
        name: name.to_owned(),
        settings,
        damping: None,
    }
}

/// That list as a node, which overrides can change.
pub(crate) fn default_node(origin: &Origin) -> Node {
    let entry = |(key, word): &(&str, &str)| Entry::new(key, origin, Node::text(origin, word));
    let table = |words: &[_]| {
        let entries = words.iter().map(entry).collect();
        Node::new(origin, Value::Table(entries))
    };
    let preset = |name| table(&[("name", name)]);
    let (name, label) = (("name", PRESETS[KALMAN].0), ("label", WITHOUT_ANGLES));
    let without_angles = table(&[name, label, ("contact_angles", "none")]);
    let list = PRESETS.iter().map(|p| preset(p.0)).chain([without_angles]);
    Node::new(origin, Value::Array(list.collect()))
}

/// The list of estimators; an empty one means no estimator. Defaults are those of the preset.
pub(crate) struct Estimators;

impl Form for Estimators {
    type Value = Vec<EstimatorChoice>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Self::Value) {
        into.clear();
        if let Value::Array(items) = &node.value
            && items.len() > MOST
        {
            return reader.refuse(node, path, &format!("at most {MOST} estimators"));
        }
        for (item, path) in reader.items(node, path, 0..=MOST, || self.allowed()) {
            let choice = self.read_one(reader, item, &path);
            let taken = into.iter().position(|c| c.name == choice.name);
            if let (Some(other), false) = (taken, choice.name.is_empty()) {
                let by = item.get("label").or_else(|| item.get("name"));
                let allowed = format!("a label that {PATH}[{other}] does not have");
                reader.refuse(by.unwrap_or(item), &join(&path, "label"), &allowed);
            }
            into.push(choice);
        }
    }

    fn text(&self, value: &mut Self::Value) -> Option<String> {
        value.is_empty().then(|| "[]".to_owned())
    }

    fn about(&self) -> About {
        About {
            allowed: "an array of tables, each headed [[estimator]]".to_owned(),
            ..About::section()
        }
    }

    fn schema(&self, _defaults: Option<&mut Self::Value>) -> Json {
        items(key::schema(KEYS, None), [0, MOST])
    }

    fn tables(&self, out: &mut Out, head: &str, _: &str, _: &str, value: &mut Self::Value) {
        for estimator in value {
            out.head(&format!("[{head}]"), "");
            out.fields(KEYS, &mut Keys::of(estimator.clone()));
        }
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, _value: &mut Self::Value) {
        let mut keys = Keys::of(choice_of(PRESETS[0]));
        key::rows(rows, KEYS, &format!("{path}[]"), &mut keys);
    }
}

impl Estimators {
    fn read_one(&self, reader: &mut Reader, node: &Node, path: &str) -> EstimatorChoice {
        // Needed before the other keys, which change its values. An unknown word is refused when
        // the table is read.
        let named = node.get("name").and_then(Node::as_text);
        let preset = PRESETS.into_iter().find(|p| Some(p.0) == named);
        // Empty after a problem only.
        let mut keys = Keys::of(choice_of(preset.unwrap_or(("", PRESETS[0].1))));
        reader.table(KEYS, node, path, &mut keys);
        refuse_other_method(reader, node, path, &keys);
        keys.choice()
    }
}

/// Refuses keys without effect: those that the method does not have, at values other than their
/// defaults, which a resolved scene names.
fn refuse_other_method(reader: &mut Reader, node: &Node, path: &str, keys: &Keys) {
    const ANGLES: &str = "contact_angles";
    let kalman = &keys.kalman;
    let finds_angles = keys.filters == Filters::Kalman && kalman.rolling;
    let mut others: Vec<_> = KEYS.iter().collect();
    if kalman.contact_angles == ContactAngles::Unknown && !finds_angles {
        let allowed = "\"given\" unless filters = \"kalman\" and rolling = \"on\"";
        reader.refuse_key(node, path, ANGLES, allowed);
        others.retain(|key| key.name != ANGLES);
    }
    let (mut given, mut kept) = (keys.clone(), keys.clone());
    let other = match keys.filters {
        Filters::Paper => {
            kept.kalman = KalmanMethod::FILTERS_ONLY;
            Filters::Kalman
        }
        Filters::Kalman => {
            kept.paper = PaperMethod::DEFAULT;
            Filters::Paper
        }
    };
    for key in others {
        let (found, default) = (key.field.text(&mut given), key.field.text(&mut kept));
        if let Some(default) = default.filter(|default| found.as_ref() != Some(default)) {
            let default = default.parse().map(short).unwrap_or(default);
            let allowed = format!("{default} unless filters = \"{}\"", other.name());
            reader.refuse_key(node, path, key.name, &allowed);
        }
    }
}
