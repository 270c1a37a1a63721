//! Forms of single values that several keys have: texts, names, seeds, counts, wheels, switches,
//! covariances.

use crate::error::Problem;
use crate::form::{About, Array, Form, Plain, Word, array, quote, word};
use crate::quantity::{NONE, Number, at_least, number};
use crate::reader::Reader;
use crate::source::{Node, Value};
use robhaz_estimator::Sides;
use robhaz_estimator::statics::{LOAD_PARAMETERS, LoadCovariance};
use serde_json::{Value as Json, json};

/// A text of at least one character that is no blank; in words. None is written for an empty one.
pub(crate) const fn text(words: &'static str) -> Plain<String> {
    Plain {
        words,
        schema: || json!({"type": "string", "pattern": r"\S"}),
        read: |node| {
            let text = node.as_text().filter(|text| !text.trim().is_empty());
            text.map(str::to_owned)
        },
        text: |text| (!text.is_empty()).then(|| quote(text)),
    }
}

/// Any text.
pub(crate) const TEXT: Plain<String> = Plain {
    schema: || json!({"type": "string"}),
    read: |node| Some(node.as_text()?.to_owned()),
    ..text("a text")
};

/// A name that becomes a part of file names.
pub(crate) const NAME: Plain<String> = Plain {
    schema: || json!({"type": "string", "pattern": "^[a-z0-9_-]{1,64}$"}),
    read: |node| {
        let is_name =
            |text: &&str| (1..=LONGEST_NAME).contains(&text.len()) && text.chars().all(is_of_name);
        Some(node.as_text().filter(is_name)?.to_owned())
    },
    ..text("a text of 1 to 64 lower-case letters a to z, digits, \"-\" and \"_\"")
};
const LONGEST_NAME: usize = 64;

fn is_of_name(c: char) -> bool {
    c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == '_'
}

/// A name from a file's stem: in lower case, with `-` for characters that are not allowed.
pub fn from_stem(stem: &str) -> String {
    let allow = |c: char| if is_of_name(c) { c } else { '-' };
    let stem = stem.to_lowercase();
    let name: String = stem.chars().take(LONGEST_NAME).map(allow).collect();
    match name.is_empty() {
        true => "scene".to_owned(),
        false => name,
    }
}

/// The seed of random numbers. No TOML file has larger numbers than 2^63 - 1.
pub(crate) const SEED: Plain<u64> = Plain {
    words: "a whole number of at least 0 and below 2^64",
    schema: || json!({"type": "integer", "minimum": 0}),
    read: |node| u64::try_from(node.whole()?).ok(),
    text: |seed| Some(seed.to_string()),
};

/// A number of things.
pub(crate) const COUNT: Plain<u32> = Plain {
    words: "a whole number of at least 1 and at most 1000",
    schema: || json!({"type": "integer", "minimum": 1, "maximum": 1000}),
    read: |node| {
        let whole = match node.value {
            // A cast saturates: out of range at the ends.
            Value::Float(number) if number.fract() == 0.0 => number as i128,
            _ => node.whole()?,
        };
        u32::try_from(whole).ok().filter(|n| (1..=1000).contains(n))
    },
    text: |count| Some(count.to_string()),
};

/// Different wheels in their order, counted from 1 in the file and from 0 here.
pub(crate) const WHEEL_LIST: Plain<[Option<usize>; 3]> = Plain {
    words: "an array of 1 to 3 different wheels: 1 front, 2 middle, 3 rear",
    schema: || json!({"type": "array", "items": {"enum": [1, 2, 3]}, "minItems": 1, "uniqueItems": true}),
    read: |node| {
        let Value::Array(items) = &node.value else {
            return None;
        };
        let mut wheels = [None; 3];
        for (i, item) in items.iter().enumerate() {
            let wheel = usize::try_from(item.whole()?).ok()?.checked_sub(1)?;
            let is_new = wheel < 3 && !wheels.contains(&Some(wheel));
            *wheels.get_mut(i)? = Some(is_new.then_some(wheel)?);
        }
        wheels[0].map(|_| wheels)
    },
    text: |wheels| {
        let wheels = wheels.iter().flatten().map(|w| (w + 1).to_string());
        Some(format!("[{}]", wheels.collect::<Vec<_>>().join(", ")))
    },
};

/// Different wheels, whether each is among them.
pub(crate) const WHEEL_SET: Plain<[bool; 3]> = Plain {
    words: WHEEL_LIST.words,
    schema: WHEEL_LIST.schema,
    read: |node| {
        let wheels = (WHEEL_LIST.read)(node)?;
        Some([0, 1, 2].map(|w| wheels.contains(&Some(w))))
    },
    text: |set| (WHEEL_LIST.text)(&[0, 1, 2].map(|w| set[w].then_some(w))),
};

/// `"off"` or `"on"`, or a boolean.
pub(crate) const SWITCH: Word<bool> = word(&[false, true], |on| match on {
    false => "off",
    true => "on",
});

/// What inclinometers measure: [`SensorSpec::specific_force`](robhaz_sim::sensors::SensorSpec) off
/// and on.
pub(crate) const MEASURED: Word<bool> =
    word(&[false, true], |specific_force| match specific_force {
        false => "gravity",
        true => "specific-force",
    });

/// What a log is of: one side of a robot with two, or a robot in the plane.
pub(crate) const SIDES: Word<Sides> = word(&[Sides::OneOfTwo, Sides::Plane], |sides| match sides {
    Sides::OneOfTwo => "one of two",
    Sides::Plane => "plane",
});

/// Rows of a covariance of the load parameters, SI.
pub(crate) struct Covariance;

type Row = [f64; LOAD_PARAMETERS];

const ROW: Array<Number, Row> = array("7 numbers", number(NONE, at_least(-1e12).at_most(1e12)));
const ROWS: Array<Array<Number, Row>, [Row; LOAD_PARAMETERS]> =
    array("7 rows of 7 numbers, a covariance", ROW);

impl Form for Covariance {
    type Value = Option<LoadCovariance>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Self::Value) {
        let (mark, mut rows) = (reader.mark(), [[0.0; LOAD_PARAMETERS]; LOAD_PARAMETERS]);
        ROWS.read(reader, node, path, &mut rows);
        if reader.mark() != mark {
            return;
        }
        match LoadCovariance::new(&rows) {
            Ok(covariance) => *into = Some(covariance),
            Err(error) => {
                let allowed = self.allowed();
                let message = format!("it is no covariance: {error}; allowed: {allowed}");
                reader.push(Problem::at(&node.origin, path, message).whole());
            }
        }
    }

    fn text(&self, value: &mut Self::Value) -> Option<String> {
        let text = ROWS.text(&mut value.as_ref()?.rows())?;
        let text = text.replace("[[", "[\n[").replace("]]", "]\n]");
        Some(text.replace("], ", "],\n"))
    }

    fn about(&self) -> About {
        ROWS.about()
    }

    fn schema(&self, _defaults: Option<&mut Self::Value>) -> Json {
        ROWS.schema(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stems_become_names() {
        assert_eq!(from_stem("smooth-soft_2"), "smooth-soft_2");
        assert_eq!(from_stem("My Scene"), "my-scene");
        assert_eq!(from_stem(""), "scene");
    }
}
