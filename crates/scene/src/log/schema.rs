//! JSON Schema of log descriptions.

use super::choice::LogChoice;
use super::keys::SECTIONS;
use super::mapping::{CHANNEL, MISSING, TIME_BASE, channel};
use super::reading::{READING, READINGS};
use super::{imu, reading};
use crate::json::{array, object, text, word};
use crate::sections::IGNORED;
use crate::{estimators, json, name, robot};
use serde_json::{Map, Value, json};

/// A log description.
pub(crate) fn sensors() -> Value {
    let mut defaults = LogChoice::default();
    let mut all = Map::new();
    let mut add = |name: &str, mut schema: Value, meaning: &str| {
        schema["description"] = json!(meaning);
        all.insert(name.to_owned(), schema);
    };
    add("name", (name::FORM.schema)(), "name of the log");
    add(
        "robot",
        json::table(robot::KEYS, None),
        "geometry and masses",
    );
    for section in SECTIONS {
        let table = json::table(section.keys, Some(&mut defaults));
        add(section.name, table, section.meaning);
    }
    add(estimators::PATH, estimators::schema(), "the estimators");
    add(
        TIME_BASE,
        text(),
        "name of the channel whose rows are the frames. Default: the first",
    );
    let readings = array(word(&READINGS), 0, READINGS.len());
    add(MISSING, readings, "readings that the log does not have");
    let channels = json!({"type": "array", "items": channel()});
    add(
        CHANNEL,
        channels,
        "tables or topics with a clock of their own",
    );
    let each = |names: &[&str], item: &Value| -> Value {
        let all = names.iter().map(|n| ((*n).to_owned(), item.clone()));
        object(all.collect(), &[])
    };
    add(
        READING,
        each(&READINGS, &reading::schema()),
        "columns of single readings",
    );
    add(
        imu::IMU,
        each(&imu::LINKS, &imu::schema()),
        "columns of inertial measurement units",
    );
    add(
        IGNORED,
        json!({"type": "object"}),
        "what wrote the file; not read",
    );
    object(all, &[])
}
