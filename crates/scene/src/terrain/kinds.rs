//! The kinds of ground: the parameters of each, and the table of keys that sets them.

use super::tables::{
    BUMPS, COSBUMP, Curve, DITCH, HEIGHTS, PARTS, RAMP, ROUGH, SINE, STAIRS, STEP,
};
use crate::key::{Key, Words};
use robhaz_terrain::{CosBump, Ditch, Interpolation, Profile, Ramp, RoughSettings, Sine, Stairs};
use std::sync::LazyLock;

/// All kinds, in the order of the reference.
pub(crate) const KINDS: Words = &[
    "flat", "smooth", "bumps", "cosbump", "ramp", "step", "stairs", "sine", "ditch", "rough",
    "heights", "parts",
];
/// The kind of a scene that names none.
pub(crate) const DEFAULT: &str = "smooth";

/// The parameters that the keys of a kind set.
#[derive(Clone)]
pub(crate) enum Parameters {
    Flat,
    Smooth,
    Bumps,
    CosBump(CosBump),
    Ramp(Ramp),
    Step(Stairs),
    Stairs(Stairs),
    Sine(Sine),
    Ditch(Ditch),
    Rough(RoughSettings),
    Heights(Curve),
    Parts,
}

/// Reads, writes or lists the keys of a kind: a generic callback, since each kind has a table of its own type.
pub(crate) trait Visitor {
    /// Receives the table and the parameters that it sets.
    fn visit<T>(&mut self, keys: &'static [Key<T>], parameters: &mut T);
}

impl Parameters {
    /// The parameters before a file changes them: those of the standard profile of a kind.
    pub fn standard(kind: &str) -> Self {
        let standard = match kind {
            "flat" => return Self::Flat,
            "bumps" => return Self::Bumps,
            "heights" => {
                return Self::Heights(Curve {
                    interpolation: Interpolation::ALL[0],
                    smoothing: 0.0,
                });
            }
            "parts" => return Self::Parts,
            "cosbump" => Profile::cosbump(),
            "ramp" => Profile::ramp(),
            "step" => Profile::step(),
            "stairs" => Profile::stairs(),
            "sine" => Profile::sine(),
            "ditch" => Profile::ditch(),
            "rough" => Profile::rough(0),
            _ => Profile::smooth(),
        };
        Self::of(kind, &standard)
    }

    /// The parameters of a profile of a kind.
    pub fn of(kind: &str, profile: &Profile) -> Self {
        match profile {
            Profile::Flat => Self::Flat,
            Profile::Bumps(_) if kind == DEFAULT => Self::Smooth,
            Profile::Bumps(_) => Self::Bumps,
            Profile::CosBump(bump) => Self::CosBump(*bump),
            Profile::Ramp(ramp) => Self::Ramp(*ramp),
            Profile::Stairs(stairs) if kind == "step" => Self::Step(*stairs),
            Profile::Stairs(stairs) => Self::Stairs(*stairs),
            Profile::Sine(sine) => Self::Sine(*sine),
            Profile::Ditch(ditch) => Self::Ditch(*ditch),
            Profile::Rough(rough) => Self::Rough(*rough.settings()),
            Profile::Heights(heights) => Self::Heights(Curve {
                interpolation: heights.interpolation(),
                smoothing: heights.smoothing(),
            }),
            Profile::Course(_) => Self::Parts,
        }
    }

    /// Shows the table of the kind to a visitor, once.
    pub fn show(&mut self, visitor: &mut impl Visitor) {
        match self {
            Self::Flat | Self::Smooth => visitor.visit::<()>(&[], &mut ()),
            Self::Bumps => visitor.visit(BUMPS, &mut ()),
            Self::CosBump(bump) => visitor.visit(COSBUMP, bump),
            Self::Ramp(ramp) => visitor.visit(RAMP, ramp),
            Self::Step(stairs) => visitor.visit(STEP, stairs),
            Self::Stairs(stairs) => visitor.visit(STAIRS, stairs),
            Self::Sine(sine) => visitor.visit(SINE, sine),
            Self::Ditch(ditch) => visitor.visit(DITCH, ditch),
            Self::Rough(settings) => visitor.visit(ROUGH, settings),
            Self::Heights(curve) => visitor.visit(HEIGHTS, curve),
            Self::Parts => visitor.visit(PARTS, &mut ()),
        }
    }
}

/// The names of the keys of a kind, in the order of its table.
fn names_of(kind: &str) -> Vec<&'static str> {
    struct Names(Vec<&'static str>);
    impl Visitor for Names {
        fn visit<T>(&mut self, keys: &'static [Key<T>], _: &mut T) {
            self.0.extend(keys.iter().map(|k| k.name));
        }
    }
    let mut names = Names(Vec::new());
    Parameters::standard(kind).show(&mut names);
    names.0
}

/// Each kind with the names of its keys.
pub(super) fn names() -> &'static [(&'static str, Vec<&'static str>)] {
    // Made once: a file can have thousands of keys that are looked up here.
    static NAMES: LazyLock<Vec<(&str, Vec<&str>)>> =
        LazyLock::new(|| KINDS.iter().map(|kind| (*kind, names_of(kind))).collect());
    &NAMES
}

/// The kind that can describe any profile of a shape: of `step` and `stairs`, `stairs`.
pub(crate) fn kind_of(profile: &Profile) -> &'static str {
    match profile {
        Profile::Flat => "flat",
        Profile::Bumps(_) => "bumps",
        Profile::CosBump(_) => "cosbump",
        Profile::Ramp(_) => "ramp",
        Profile::Stairs(_) => "stairs",
        Profile::Sine(_) => "sine",
        Profile::Ditch(_) => "ditch",
        Profile::Rough(_) => "rough",
        Profile::Heights(_) => "heights",
        Profile::Course(_) => "parts",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The word of a kind, its standard profile and its table belong together.
    #[test]
    fn every_kind_has_its_own_table() {
        for (kind, names) in names() {
            let parameters = Parameters::standard(kind);
            assert_eq!(*kind == DEFAULT, matches!(parameters, Parameters::Smooth));
            assert_eq!(
                names.is_empty(),
                matches!(parameters, Parameters::Flat | Parameters::Smooth),
                "{kind}"
            );
        }
    }
}
