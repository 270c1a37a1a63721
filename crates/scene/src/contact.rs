//! `[contact]`: eqs. (10) and (11), rolling resistance.

use crate::conflict::{Conflict, number, word};
use crate::key::Key;
use crate::range::{above, at_least, short};
use crate::scene::Scene;
use crate::source::{Node, Value};
use crate::units::{CONTACT_STIFFNESS, DAMPING, LENGTH, NONE, SPEED};
use robhaz_sim::friction::{FrictionKind, FrictionLaw};

/// Where the section is in the file.
pub(crate) const PATH: &str = "contact";

const FRICTION: &str = "friction";
const V_S: &str = "v_s";
const SLIP_STIFFNESS: &str = "slip_stiffness";

/// The keys of the section.
pub(crate) const KEYS: &[Key<Scene>] = &[
    Key::number(
        "stiffness",
        CONTACT_STIFFNESS,
        above(0.0).at_most(1e15),
        |s| &mut s.contact.stiffness,
        "stiffness k of the ground",
    ),
    Key::number(
        "exponent",
        NONE,
        at_least(1.0).at_most(5.0),
        |s| &mut s.contact.exponent,
        "exponent n of the penetration; the unit of the stiffness depends on it",
    ),
    Key::number(
        "damping",
        DAMPING,
        at_least(0.0).at_most(1e7),
        |s| &mut s.contact.damping,
        "damping c of the ground",
    ),
    Key::number(
        "damping_ramp",
        LENGTH,
        at_least(0.0).at_most(0.1),
        |s| &mut s.contact.damping_ramp,
        "penetration over which the damping rises from 0 to c; 0 for a constant c",
    ),
    Key::word(
        FRICTION,
        &[
            FrictionKind::Adams.name(),
            FrictionKind::Brush.name(),
            FrictionKind::Rigid.name(),
        ],
        |s| s.friction.kind as usize,
        |s, i| s.friction.kind = FrictionKind::ALL[i],
        "friction law: T/N over the slip speed, T/N over the slip ratio, or nearly Coulomb's law, which only direct takes at the default step",
    ),
    Key::number(
        "mu_s",
        NONE,
        at_least(0.0).at_most(10.0),
        |s| &mut s.friction.mu_s,
        "static friction coefficient",
    ),
    Key::number(
        "mu_d",
        NONE,
        at_least(0.0).at_most(10.0),
        |s| &mut s.friction.mu_d,
        "dynamic friction coefficient, not above mu_s",
    ),
    Key::number(
        V_S,
        SPEED,
        above(0.0).at_most(10.0),
        |s| &mut s.friction.v_s,
        "slip speed up to which the static coefficient holds; 0.001 with friction = \"rigid\", which takes 2e-4 to 0.002",
    ),
    Key::number(
        "v_d",
        SPEED,
        above(0.0).at_most(10.0),
        |s| &mut s.friction.v_d,
        "slip speed from which the dynamic coefficient holds, above v_s",
    ),
    Key::number(
        SLIP_STIFFNESS,
        NONE,
        above(0.0).at_most(1000.0),
        |s| &mut s.friction.slip_stiffness,
        "slope C of T/N over the slip ratio at zero slip; needs friction = \"brush\"",
    ),
    Key::number(
        "rolling_resistance",
        NONE,
        at_least(0.0).at_most(1.0),
        |s| &mut s.rolling.coefficient,
        "coefficient f_r of the rolling resistance: a moment f_r r N against the rolling",
    ),
];

/// The chosen friction law with its defaults. It is needed before all other keys. An unknown word is refused when the
/// section is read.
pub(crate) fn chosen_law(root: &Node) -> FrictionLaw {
    let chosen = root.get(PATH).and_then(|s| s.get(FRICTION));
    let kind = chosen.and_then(|node| match &node.value {
        Value::Text(name) => FrictionKind::ALL.into_iter().find(|k| k.name() == name),
        _ => None,
    });
    FrictionLaw::of(kind.unwrap_or_default())
}

/// Removes the file's values of keys that belong to its own law, where an override chooses the law.
pub(crate) fn forget_old_law(root: &mut Node) {
    let law = root.get(PATH).and_then(|s| s.get(FRICTION));
    if law.is_some_and(|l| l.origin.is_override()) {
        root.forget(PATH, |key| [V_S, SLIP_STIFFNESS].contains(&key));
    }
}

/// The rules of the friction law that a scene breaks.
pub(crate) fn conflicts(scene: &Scene) -> Vec<Conflict> {
    let law = &scene.friction;
    let kind = || word("contact.friction", law.kind.name());
    let v_s = || number("contact.v_s", law.v_s);
    let mut found = Vec::new();
    let mut conflict = |keys, rule: String| found.push(Conflict { keys, rule });
    if law.mu_d > law.mu_s {
        let keys = vec![
            number("contact.mu_d", law.mu_d),
            number("contact.mu_s", law.mu_s),
        ];
        conflict(keys, "contact.mu_d not above contact.mu_s".to_owned());
    }
    if law.v_s >= law.v_d {
        let keys = vec![v_s(), number("contact.v_d", law.v_d)];
        conflict(keys, "contact.v_s below contact.v_d".to_owned());
    }
    let rigid = FrictionLaw::RIGID_LEAST..=FrictionLaw::RIGID_MOST;
    if law.kind == FrictionKind::Rigid && !rigid.contains(&law.v_s) {
        let (least, most) = (short(*rigid.start()), short(*rigid.end()));
        let rule = format!("contact.v_s of at least {least} and at most {most} m/s with this law");
        conflict(vec![v_s(), kind()], rule);
    }
    // The default is allowed: a resolved scene names every key.
    let default = FrictionLaw::default().slip_stiffness;
    if law.kind != FrictionKind::Brush && law.slip_stiffness.to_bits() != default.to_bits() {
        let keys = vec![number("contact.slip_stiffness", law.slip_stiffness), kind()];
        let rule = format!("contact.slip_stiffness {default} unless contact.friction = \"brush\"");
        conflict(keys, rule);
    }
    found
}
