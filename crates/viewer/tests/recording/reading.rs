//! Reads a recording back.

use re_chunk::Chunk;
use re_log_encoding::Decoder;
use re_log_types::LogMsg;
use re_log_types::StoreKind;
use re_sdk_types::archetypes::{Scalars, TextLog};
use re_sdk_types::components::{Scalar, Text};
use re_sdk_types::{Component, ComponentIdentifier};
use robhaz_estimator::{Estimate, EstimateError};
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use robhaz_scene::Scene;
use robhaz_sim::Truth;
use robhaz_sim::clearance::Clearances;
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

/// Chunks by entity of the recording of a run.
pub fn recorded(scene: &Scene) -> BTreeMap<String, Vec<Chunk>> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    record(scene, &path);
    chunks(&path)
}

/// What is changed of a record on its way to the recording.
pub struct Record {
    /// Time, ms.
    pub ms: f64,
    pub truth: Truth,
    pub estimates: Vec<Result<Estimate, EstimateError>>,
    pub clearances: Option<Clearances>,
}

/// Chunks by entity of the recording of a run whose records are changed, and which breaks off after
/// its last one.
pub fn changed(scene: &Scene, change: impl FnMut(&mut Record)) -> BTreeMap<String, Vec<Chunk>> {
    struct Changed<C>(RecordingSink, C);
    impl<C: FnMut(&mut Record)> Sink for Changed<C> {
        fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
            self.0.begin(run)
        }
        fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
            let mut record = Record {
                ms: (frame.time * 1e3).round(),
                truth: *frame.truth.expect("a simulation"),
                estimates: frame.estimates.to_vec(),
                clearances: None,
            };
            (self.1)(&mut record);
            self.0.frame(&Frame {
                clearances: record.clearances,
                truth: Some(&record.truth),
                estimates: &record.estimates,
                ..*frame
            })
        }
        fn end(&mut self, _: Option<&RunEnd>) -> Result<(), SinkError> {
            self.0.end(None)
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.rrd");
    let mut sink = Changed(RecordingSink::save(&path).expect("a file"), change);
    robhaz_run::run(scene, &mut [&mut sink]).expect("a run");
    chunks(&path)
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
