//! How good an estimate is. Tables, studies, the viewer, tests and benches all use these
//! definitions.
//!
//! | symbol | definition | home |
//! |---|---|---|
//! | which samples count | from `compare_from` on, if each wheel has an equivalent contact | [`Rule`] |
//! | true N, T of a wheel | those of its equivalent contact | [`Compared`] |
//! | RMSE | `sqrt(mean((N_estimated - N_true)^2))` over samples, per wheel or over all wheels | [`Statistics::normal_force`] |
//! | NRMSE | RMSE over all wheels / mean of the true N over wheels and samples | [`ForceErrors::nrmse`] |
//! | NEES | `e' P^-1 e`, e = error of the three N, P its stated covariance | [`Statistics::nees`] |
//! | NIS | `(r/sigma_r)^2`, r = parity residual before correction | [`Statistics::nis`] |
//! | bias | mean of `N_estimated - N_true`, per wheel | [`ForceErrors::bias`] |
//! | lag | `-sum(e dN/dt)/sum((dN/dt)^2)`, e = error of N, over samples without impacts | [`Statistics::lag`] |
//! | coverage | share of errors of N within two stated standard deviations | [`Statistics::coverage`] |
//! | errors of both sides | NRMSE, coverage and NEES of six N | [`BothErrors`] |
//! | Cramer-Rao bound | smallest NRMSE of an unbiased estimate from one sample | [`Bound::nrmse`] |
//! | mu_n | T/N, where N is at least [`LEAST_LOAD`] | [`needed_friction`] |
//! | mu_n of an estimate | what it states, else T/N | [`estimated_needed_friction`] |
//! | errors of the ground | RMSE and coverage of height and slope over the points found | [`GroundErrors`] |
//! | progress | way, stuck since, spinning time | [`ProgressMeter`] |
//! | agreement of the readings | one verdict of `estimate` and `check` | [`Agreement`] |
//! | contact states | share of events found within 20 ms, shares of false and missed flags | [`contact`] |
//! | events | contact lost, two contacts, slip, end stop, body or a link touches the ground | [`events`] |

mod agreement;
mod both;
mod bound;
pub mod contact;
pub mod events;
mod friction;
mod ground;
mod progress;
mod rule;
mod score;
pub mod signals;
mod statistics;
mod sum;

pub use agreement::{Agreement, Contradiction, Excuse, tests};
pub use both::{BothErrors, BothStatistics};
pub use bound::{Bound, SampleNoise};
pub use friction::{LEAST_LOAD, estimated_needed_friction, needed_friction};
pub use ground::{GroundErrors, TrueGround, ground_origin};
pub use progress::{Progress, ProgressMeter};
pub use rule::{Compared, Inclusion, Rule};
pub use score::{Score, has_forces};
pub use statistics::{ForceErrors, Statistics, rms_over_wheels};
pub use sum::{Rms, Sum, extremes};
