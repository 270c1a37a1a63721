//! Parts of JSON Schema.

use serde_json::{Map, Value as Json, json};

/// JSON Schema of a table with these properties and no others.
pub(crate) fn object(properties: Map<String, Json>, required: &[&str]) -> Json {
    let mut object = json!({
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
    });
    if !required.is_empty() {
        object["required"] = json!(required);
    }
    object
}

/// JSON Schema of a list of at least `least` and at most `most` items.
pub(crate) fn items(item: Json, least: usize, most: usize) -> Json {
    json!({"type": "array", "items": item, "minItems": least, "maxItems": most})
}
