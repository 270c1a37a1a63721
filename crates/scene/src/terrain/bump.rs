//! The keys of a bump.

use crate::key::Key;
use crate::range::at_least;
use crate::units::LENGTH;
use robhaz_terrain::Bump;

/// The keys of one bump of kind `bumps`.
pub(crate) const BUMP: &[Key<Bump>] = &[
    Key::<Bump>::number(
        "height",
        LENGTH,
        at_least(-10.0).at_most(10.0),
        |b| &mut b.height,
        "height of the summit; negative for a hollow",
    )
    .required(),
    Key::<Bump>::number(
        "centre",
        LENGTH,
        at_least(-1000.0).at_most(1000.0),
        |b| &mut b.centre,
        "where the summit is; the middle wheel starts at 0",
    )
    .required(),
    Key::<Bump>::number(
        "width",
        LENGTH,
        // Knots of the ground are a tenth of the narrowest width apart.
        at_least(0.005).at_most(10.0),
        |b| &mut b.width,
        "half width at 1/e of the height",
    )
    .required(),
];

/// A bump before its keys are read.
pub(crate) const NO_BUMP: Bump = Bump {
    height: 0.0,
    centre: 0.0,
    width: 1.0,
};
