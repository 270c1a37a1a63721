//! Keys of TOML files, each declared once: its meaning, its unit and range, and the field that it
//! sets. A file is read into a plain struct by these declarations. All mistakes are reported at
//! once, each with its line, what was found and what is allowed. The struct is written back with
//! units and meanings as comments, and tables of keys and JSON Schema are made from the same
//! declarations. The crate knows no robot.
//!
//! ```
//! use robhaz_keys::key::{self, keys};
//! use robhaz_keys::quantity::{SPEED, TORQUE, above, at_least, number};
//! use robhaz_keys::{form::Out, reader::Reader};
//!
//! /// A motor: SI.
//! #[derive(Debug)]
//! struct Motor { speed: f64, limit: f64 }
//!
//! // Defaults are not declared: they are what the struct holds before the file is read.
//! let defaults = || Motor { speed: 0.2, limit: 2.0 };
//!
//! keys! {
//!     MOTOR: Motor;
//!
//!     /// set speed of the wheel's rim
//!     speed: number(SPEED, at_least(-1.0).at_most(1.0)) => speed;
//!
//!     /// torque limit
//!     torque_limit (required): number(TORQUE, above(0.0).at_most(1e3)) => limit;
//! }
//!
//! let read = |text: &str| {
//!     let reader = Reader::new("".into(), |_| None);
//!     reader.read("motor.toml", text, |reader, root| {
//!         let mut motor = defaults();
//!         reader.table(MOTOR, &root, "", &mut motor);
//!         motor
//!     })
//! };
//!
//! // A number has the SI unit, a text its own.
//! let mut motor = read("speed = \"35 cm/s\"\ntorque_limit = 3").unwrap();
//! assert_eq!((motor.speed, motor.limit), (0.35, 3.0));
//!
//! let error = read("speed = 20\ntorqe_limit = 3").unwrap_err();
//! let problems: Vec<String> = error.problems.iter().map(ToString::to_string).collect();
//! assert_eq!(problems, [
//!     "motor.toml:1: speed: found 20, allowed: a number of at least -1 and at most 1, in m/s",
//!     "motor.toml:1: torque_limit: missing, and it has no default; allowed: a number above 0 and at \
//!      most 1000, in N m, or a text with a unit (N m, mN m)",
//!     "motor.toml:2: torqe_limit: unknown key, allowed: speed, torque_limit; did you mean \
//!      torque_limit?",
//! ]);
//!
//! let text = Out::file("a motor", "example 1.0", MOTOR, &mut motor);
//! assert!(text.contains("speed = 0.35 # m/s; set speed of the wheel's rim\n"));
//!
//! let mut rows = Vec::new();
//! key::rows(&mut rows, MOTOR, "", &mut defaults());
//! assert_eq!((rows[0].key.as_str(), rows[0].default.as_str()), ("speed", "0.2"));
//! ```
//!
//! | modules, from the bottom to the top | job |
//! |---|---|
//! | [`source`] | a file or an override as a tree of values with their places |
//! | [`error`], [`reader`] | problems and their messages; what collects them |
//! | [`form`] | what a value may be: read, written and described by one [`Form`](form::Form) |
//! | [`quantity`], [`values`] | forms of numbers with unit and range; of single values |
//! | [`key`] | [`keys!`] declares a table; reading, writing and describing one |
//! | [`conflict`] | messages on keys that do not go together |
//! | [`overrides`] | overrides `key=value` of the command line |
//! | [`prelude`] | all names that a file of declarations needs |

pub mod conflict;
pub mod error;
pub mod form;
pub mod key;
pub mod overrides;
pub mod prelude;
pub mod quantity;
pub mod reader;
pub mod source;
pub mod values;
