//! Forms of single values that several keys have: wheels, what is measured, covariances.

use robhaz_estimator::statics::{LOAD_PARAMETERS, LoadCovariance};
use robhaz_keys::prelude::*;
use robhaz_model::Vec2;
use serde_json::{Value as Json, json};

/// Largest coordinate of a robot, m.
pub(crate) const FARTHEST: f64 = 10.0;
/// A point of a robot in its nominal pose.
pub(crate) const POINT: Array<Number, Vec2> =
    point(number(LENGTH, at_least(-FARTHEST).at_most(FARTHEST)));

/// Longest time of a run, s.
pub(crate) const LONGEST_RUN: f64 = 1e6;

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

/// What inclinometers measure: [`SensorSpec::specific_force`](robhaz_sim::sensors::SensorSpec) off
/// and on.
pub(crate) const MEASURED: Word<bool> =
    word(&[false, true], |specific_force| match specific_force {
        false => "gravity",
        true => "specific-force",
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
