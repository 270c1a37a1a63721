//! Design of a linkage that climbs stairs: geometry C. The method and its results are in `docs/climbing.md`.
//!
//! ```sh
//! cargo run --release -p robhaz-study --example climb -- search --out robots/geometry-c.toml
//! cargo run --release -p robhaz-study --example climb -- table A robots/geometry-c.toml
//! cargo run --release -p robhaz-study --example climb -- figure docs/climbing.svg A robots/geometry-c.toml
//! ```
//!
//! | module | job |
//! |---|---|
//! | `design` | what is searched: bounds and constraints of a geometry |
//! | `trial` | one drive up the stairs in the simulator |
//! | `search` | differential evolution over the designs |
//! | `limits` | least friction and highest riser of a geometry |
//! | `figure` | the figure of `docs/climbing.md` |

mod design;
mod figure;
mod limits;
mod search;
mod trial;

use search::Plan;
use std::error::Error;
use std::path::Path;

/// Result of a step that can fail for reasons of the user or of the system.
pub type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

const USAGE: &str = "climb search [--seed N] [--population N] [--generations N] --out FILE.toml\n\
                     climb table GEOMETRY...\n\
                     climb figure FILE.svg GEOMETRY...\n\
                     GEOMETRY: a built-in name such as A, or the path of a .toml file";

fn main() -> Outcome<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["search", options @ ..] => {
            let (plan, out) = search_options(options)?;
            let found = search::search(&plan)?;
            Ok(std::fs::write(out, design::to_toml(&found, &plan)?)?)
        }
        ["table", geometries @ ..] if !geometries.is_empty() => limits::table(geometries),
        ["figure", file, geometries @ ..] if !geometries.is_empty() => {
            figure::draw(Path::new(file), geometries)
        }
        _ => Err(USAGE.into()),
    }
}

/// The plan of a search, and the file that it writes.
fn search_options<'a>(options: &[&'a str]) -> Outcome<(Plan, &'a str)> {
    let (mut plan, mut out) = (Plan::default(), None);
    for pair in options.chunks(2) {
        let [name, value] = pair else {
            return Err(USAGE.into());
        };
        let number = || {
            let problem = |e| format!("{name}: found {value}; allowed: a whole number ({e})");
            value.parse::<u32>().map_err(problem)
        };
        match *name {
            "--seed" => plan.seed = number()?,
            "--population" => plan.population = number()?.max(4),
            "--generations" => plan.generations = number()?,
            "--out" => out = Some(*value),
            _ => return Err(USAGE.into()),
        }
    }
    Ok((plan, out.ok_or(USAGE)?))
}
