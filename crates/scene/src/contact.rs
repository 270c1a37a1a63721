//! `[contact]`: eqs. (10) and (11), rolling resistance.

use crate::scene::Scene;
use robhaz_keys::conflict::{Conflict, conflict, named, valued};
use robhaz_keys::form::word;
use robhaz_keys::key::keys;
use robhaz_keys::quantity::{
    CONTACT_STIFFNESS, DAMPING, LENGTH, NONE, SPEED, above, at_least, number, short,
};
use robhaz_keys::source::Node;
use robhaz_sim::friction::{FrictionKind, FrictionLaw};

keys! {
    /// The keys of the section.
    pub(crate) KEYS: Scene;

    /// stiffness k of the ground
    stiffness: number(CONTACT_STIFFNESS, above(0.0).at_most(1e15)) => contact.stiffness;

    /// exponent n of the penetration; the unit of the stiffness depends on it
    exponent: number(NONE, at_least(1.0).at_most(5.0)) => contact.exponent;

    /// damping c of the ground
    damping: number(DAMPING, at_least(0.0).at_most(1e7)) => contact.damping;

    /// penetration over which the damping rises from 0 to c; 0 for a constant c
    damping_ramp: number(LENGTH, at_least(0.0).at_most(0.1)) => contact.damping_ramp;

    /// friction law: T/N over the slip speed, T/N over the slip ratio, or nearly Coulomb's law,
    /// which only direct takes at the default step
    friction: word(&FrictionKind::ALL, FrictionKind::name) => friction.kind;

    /// static friction coefficient
    mu_s: number(NONE, at_least(0.0).at_most(10.0)) => friction.mu_s;

    /// dynamic friction coefficient, not above mu_s
    mu_d: number(NONE, at_least(0.0).at_most(10.0)) => friction.mu_d;

    /// slip speed up to which the static coefficient holds; 0.001 with friction = "rigid", which
    /// takes 2e-4 to 0.002
    v_s: number(SPEED, above(0.0).at_most(10.0)) => friction.v_s;

    /// slip speed from which the dynamic coefficient holds, above v_s
    v_d: number(SPEED, above(0.0).at_most(10.0)) => friction.v_d;

    /// slope C of T/N over the slip ratio at zero slip; needs friction = "brush"
    slip_stiffness: number(NONE, above(0.0).at_most(1000.0)) => friction.slip_stiffness;

    /// coefficient f_r of the rolling resistance: a moment f_r r N against the rolling
    rolling_resistance: number(NONE, at_least(0.0).at_most(1.0)) => rolling.coefficient;
}

/// The chosen friction law with its defaults. It is needed before all other keys. An unknown word
/// is refused when the section is read.
pub(crate) fn chosen_law(root: &Node) -> FrictionLaw {
    let name = root.find("contact.friction").and_then(Node::as_text);
    let kind = FrictionKind::ALL
        .into_iter()
        .find(|k| Some(k.name()) == name);
    FrictionLaw::of(kind.unwrap_or_default())
}

/// Removes the file's values of keys that belong to its own law, where an override chooses the law.
pub(crate) fn drop_keys_of_other_laws(root: &mut Node) {
    let is_of_law = |key: &str| ["v_s", "slip_stiffness"].contains(&key);
    root.drop_keys("contact.friction", "contact", is_of_law);
}

/// The rules of the friction law that a scene breaks.
pub(crate) fn conflicts(scene: &Scene) -> Vec<Conflict> {
    let law = &scene.friction;
    let kind = || named("contact.friction", law.kind.name());
    let v_s = || valued("contact.v_s", law.v_s);
    let mut found = Vec::new();
    if law.mu_d > law.mu_s {
        let keys = [
            valued("contact.mu_d", law.mu_d),
            valued("contact.mu_s", law.mu_s),
        ];
        found.push(conflict(keys, "contact.mu_d not above contact.mu_s"));
    }
    if law.v_s >= law.v_d {
        let keys = [v_s(), valued("contact.v_d", law.v_d)];
        found.push(conflict(keys, "contact.v_s below contact.v_d"));
    }
    let rigid = FrictionLaw::RIGID_LEAST..=FrictionLaw::RIGID_MOST;
    if law.kind == FrictionKind::Rigid && !rigid.contains(&law.v_s) {
        let (least, most) = (short(*rigid.start()), short(*rigid.end()));
        let rule = format!("contact.v_s of at least {least} and at most {most} m/s with this law");
        found.push(conflict([v_s(), kind()], rule));
    }
    // The default is allowed: a resolved scene names every key.
    let default = FrictionLaw::default().slip_stiffness;
    if law.kind != FrictionKind::Brush && law.slip_stiffness.to_bits() != default.to_bits() {
        let keys = [valued("contact.slip_stiffness", law.slip_stiffness), kind()];
        let rule = format!("contact.slip_stiffness {default} unless contact.friction = \"brush\"");
        found.push(conflict(keys, rule));
    }
    found
}
