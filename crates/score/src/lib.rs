//! How good an estimate is. Tables, studies, the viewer, tests and benches all use these definitions.
//!
//! | symbol | definition | home |
//! |---|---|---|
//! | which samples count | from `compare_from` on, with at most one contact per wheel | [`Rule`] |
//! | RMSE | `sqrt(mean((N_estimated - N_true)^2))` over samples, per wheel or over all wheels | [`Score::normal_force`] |
//! | NRMSE | RMSE over all wheels / mean of the true N over wheels and samples | [`ForceErrors::nrmse`] |
//! | NEES | `e' P^-1 e`, e = error of the three N, P its stated covariance | [`Score::nees`] |
//! | NIS | `(r/sigma_r)^2`, r = parity residual before correction | [`Score::nis`] |
//! | coverage | share of errors of N within two stated standard deviations | [`Score::coverage`] |
//! | mu_n | T/N, where N is at least [`LEAST_LOAD`] | [`needed_friction`] |
//! | errors of the ground | RMSE and coverage of height and slope over the points found | [`GroundErrors`] |
//! | progress | way, stuck since, spinning time | [`ProgressMeter`] |
//! | events | contact lost, two contacts, slip, end stop | [`events`] |

mod errors;
pub mod events;
mod friction;
mod ground;
mod progress;
mod rule;
mod score;
mod sum;

pub use errors::{ForceErrors, rms_over_wheels};
pub use friction::{LEAST_LOAD, needed_friction};
pub use ground::{GroundErrors, TrueGround, ground_origin};
pub use progress::{Progress, ProgressMeter};
pub use rule::{Inclusion, Rule};
pub use score::Score;
pub use sum::{Rms, Sum};
