//! `robhaz keys`: the keys of scene files.

use crate::terminal::{Output, print, print_json};
use miette::{Result, miette};
use robhaz_record::Grid;
use robhaz_scene::{KeyReference, reference};
use serde_json::json;

/// Arguments of `robhaz keys`. With `--json` an array of objects with `key`, `unit`, `other_units`,
/// `default`, `allowed` and `meaning`.
#[derive(clap::Args)]
pub struct Args {
    /// Part of a key's name or of its meaning, such as `drive` or `torque`; without it all keys.
    pattern: Option<String>,
}

/// Prints the keys that match.
pub fn run(args: &Args) -> Result<()> {
    let pattern = args.pattern.as_deref().unwrap_or_default().to_lowercase();
    let matches = |key: &KeyReference| {
        key.key.to_lowercase().contains(&pattern) || key.meaning.to_lowercase().contains(&pattern)
    };
    let keys: Vec<KeyReference> = reference().into_iter().filter(matches).collect();
    if keys.is_empty() {
        return Err(miette!(
            help = "`robhaz keys` without a pattern prints all",
            "no key has {pattern:?} in its name or meaning"
        ));
    }
    match Output::get().json {
        true => print_json(&json!(keys)),
        false => print(&table(&keys)),
    }
}

fn table(keys: &[KeyReference]) -> String {
    let header = ["key", "unit", "default", "allowed", "meaning"];
    let mut table = Grid::new(&[0, 1, 2, 3, 4], &header);
    for key in keys {
        let unit = match (key.unit, key.other_units.as_str()) {
            (unit, "") => unit,
            (unit, others) => &format!("{unit} ({others})"),
        };
        let cells = [&key.key, unit, &key.default, &key.allowed, key.meaning];
        table.row(cells.map(str::to_owned));
    }
    table.text(None)
}
