//! `[contact]`: eqs. (10) and (11), rolling resistance.

use crate::scene::Scene;
use robhaz_keys::conflict::Value;
use robhaz_keys::prelude::*;
use robhaz_sim::friction::{FrictionKind, FrictionLaw, Parameter};

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
    rolling_resistance: number(NONE, at_least(0.0).at_most(1.0)) => friction.rolling;
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
    let is_of_law = |key: &str| FrictionKind::all_parameters().any(|p| p.name == key);
    root.drop_keys("contact.friction", "contact", is_of_law);
}

/// The key of a parameter and its value.
pub(crate) fn key_of(parameter: &Parameter, law: &FrictionLaw) -> Value {
    let key = format!("contact.{}", parameter.name);
    (key.into(), short(parameter.of(law)))
}

/// Adds the rules of the friction law that a scene breaks.
pub(crate) fn add_conflicts(scene: &Scene, found: &mut Vec<Conflict>) {
    let law = &scene.friction;
    let kind = || named("contact.friction", law.kind.name());
    if law.mu_d > law.mu_s {
        let keys = [
            valued("contact.mu_d", law.mu_d),
            valued("contact.mu_s", law.mu_s),
        ];
        found.push(conflict(keys, "contact.mu_d not above contact.mu_s"));
    }
    if law.v_s >= law.v_d {
        let keys = [
            valued("contact.v_s", law.v_s),
            valued("contact.v_d", law.v_d),
        ];
        found.push(conflict(keys, "contact.v_s below contact.v_d"));
    }
    for parameter in law.kind.parameters() {
        if let Some([least, most]) = parameter.limits
            && !(least..=most).contains(&parameter.of(law))
        {
            let (key, unit) = (key_of(parameter, law), parameter.unit);
            let (least, most) = (short(least), short(most));
            let rule = format!(
                "{} of at least {least} and at most {most} {unit} with this law",
                key.0
            );
            found.push(conflict([key, kind()], rule));
        }
    }
    for other in FrictionKind::ALL {
        let own = other.parameters().iter().filter(|p| !p.is_shared);
        for parameter in own.filter(|_| other != law.kind) {
            // The default is allowed: a resolved scene names every key.
            if parameter.of(law).to_bits() != parameter.default.to_bits() {
                let (key, default) = (key_of(parameter, law), parameter.default);
                let law = other.name();
                let rule = format!("{} {default} unless contact.friction = \"{law}\"", key.0);
                found.push(conflict([key, kind()], rule));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_keys::reader::Reader;
    use robhaz_keys::source::{Entry, Origin, Source, Value::Float};
    use std::path::PathBuf;

    /// Each parameter of a law has a key, which sets its field and takes its default and limits.
    #[test]
    fn each_parameter_of_a_law_has_its_key() {
        for parameter in FrictionKind::all_parameters() {
            let name = parameter.name;
            let limits = parameter.limits.into_iter().flatten();
            for value in limits.chain([parameter.default]) {
                // Without the rules between keys: of the value alone.
                let mut scene = Scene::default();
                let origin = Origin::new(&Source::set(""), 0..0);
                let node = Node::new(&origin, Float(value));
                let mut reader = Reader::new(PathBuf::new(), |_| None);
                reader.entry(
                    KEYS,
                    &Entry::new(name, &origin, node),
                    "contact",
                    &mut scene,
                );
                assert_eq!(reader.mark(), 0, "{name}");
                assert_eq!(
                    parameter.of(&scene.friction).to_bits(),
                    value.to_bits(),
                    "{name}"
                );
            }
        }
    }
}
