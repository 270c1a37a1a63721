//! Reads a recording back.

use re_chunk::Chunk;
use re_log_encoding::Decoder;
use re_log_types::LogMsg;
use re_log_types::StoreKind;
use re_sdk_types::archetypes::{Scalars, TextLog};
use re_sdk_types::components::{Scalar, Text};
use re_sdk_types::{Component, ComponentIdentifier};
use robhaz_scene::Scene;
use robhaz_viewer::RecordingSink;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Runs a scene and writes its recording.
pub fn record(scene: &Scene, path: &Path) {
    let mut sink = RecordingSink::save(path).expect("a file");
    robhaz_run::run(scene, &mut [&mut sink]).expect("a run");
}

/// All messages of a recording.
pub fn messages(path: &Path) -> Vec<LogMsg> {
    let file = BufReader::new(File::open(path).expect("the recording"));
    Decoder::decode_eager(file)
        .expect("a header")
        .map(|message| message.expect("a readable message"))
        .collect()
}

/// The chunks of the recording, without its layout, by entity.
pub fn chunks(path: &Path) -> BTreeMap<String, Vec<Chunk>> {
    let mut found: BTreeMap<String, Vec<Chunk>> = BTreeMap::new();
    for message in messages(path) {
        if let LogMsg::ArrowMsg(store, message) = message
            && store.kind() == StoreKind::Recording
        {
            let chunk = Chunk::from_arrow_msg(&message).expect("a chunk");
            let entity = chunk.entity_path().to_string();
            found.entry(entity).or_default().push(chunk);
        }
    }
    found
}

/// Every row of a component of an entity, with its time in s.
pub fn rows<C: Component>(
    chunks: &BTreeMap<String, Vec<Chunk>>,
    entity: &str,
    component: ComponentIdentifier,
) -> Vec<(f64, Vec<C>)> {
    let mut found = Vec::new();
    for chunk in chunks.get(entity).expect("the entity") {
        let Some(times) = chunk.timelines().values().next() else {
            continue;
        };
        let times = times.times_raw().iter().map(|ns| *ns as f64 * 1e-9);
        let values = chunk.iter_component::<C>(component);
        found.extend(times.zip(values.map(|row| row.as_slice().to_vec())));
    }
    found
}

/// Every row of scalars of an entity, with its time in s.
pub fn scalars(chunks: &BTreeMap<String, Vec<Chunk>>, entity: &str) -> Vec<(f64, Vec<f64>)> {
    rows::<Scalar>(chunks, entity, Scalars::descriptor_scalars().component)
        .into_iter()
        .map(|(time, row)| (time, row.iter().map(|s| s.0.0).collect()))
        .collect()
}

/// The messages of the events, with their times in s.
pub fn events(chunks: &BTreeMap<String, Vec<Chunk>>) -> Vec<(f64, String)> {
    rows::<Text>(chunks, "/events", TextLog::descriptor_text().component)
        .into_iter()
        .map(|(time, row)| (time, row[0].to_string()))
        .collect()
}
