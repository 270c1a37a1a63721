//! The keys of `[terrain]` that belong to no kind alone, and those of its lists.

use super::kinds::{DEFAULT, KINDS};
use crate::json;
use crate::key::{Form, Key};
use crate::range::at_least;
use crate::units::{LENGTH, NONE};
use robhaz_sim::friction::Stretch;

/// Largest number of friction stretches: each contact looks them up.
pub(super) const MOST_STRETCHES: usize = 1000;

/// Where the terrain is in the file.
pub(crate) const PATH: &str = "terrain";

/// The key of every kind.
pub(crate) const COMMON: &[Key<()>] = &[Key::own_word(
    "kind",
    DEFAULT,
    KINDS,
    "level ground; the main course of five bumps; Gaussian bumps; one cosine bump; an incline; one kerb; stairs; waves; a trench; random ground; ground through points; a sequence of other kinds",
)];

/// The key of every kind, in the section itself only: parts of a course do not have it.
pub(crate) const STRETCHES: &[Key<()>] = &[Key::own(
    "stretch",
    "none",
    Form {
        words: "up to 1000 tables, each headed [[terrain.stretch]]",
        schema: || json::array(json::table(STRETCH, None), 0, MOST_STRETCHES),
    },
    "friction stretches, from rear to front; they must not overlap",
)];

/// The keys of a stretch.
pub(crate) const STRETCH: &[Key<Stretch>] = &[
    Key::<Stretch>::number(
        "from",
        LENGTH,
        at_least(-1000.0).at_most(10_000.0),
        |s| &mut s.from,
        "x of its start; compared with the contact's x",
    )
    .required(),
    Key::<Stretch>::number(
        "to",
        LENGTH,
        at_least(-1000.0).at_most(10_000.0),
        |s| &mut s.to,
        "x of its end, above from",
    )
    .required(),
    Key::<Stretch>::number(
        "mu_s",
        NONE,
        at_least(0.0).at_most(10.0),
        |s| &mut s.mu_s,
        "static friction coefficient there",
    )
    .required(),
    Key::<Stretch>::number(
        "mu_d",
        NONE,
        at_least(0.0).at_most(10.0),
        |s| &mut s.mu_d,
        "dynamic friction coefficient there, not above mu_s",
    )
    .required(),
];

/// A stretch before its keys are read.
pub(crate) const NO_STRETCH: Stretch = Stretch {
    from: 0.0,
    to: 0.0,
    mu_s: 0.0,
    mu_d: 0.0,
};
