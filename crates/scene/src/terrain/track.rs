//! A track as a scene names it.

use robhaz_terrain::TrackFormat;
use std::sync::Arc;

/// A file of points as the scene names it, with its content: the run's folder gets a copy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Track {
    /// Index of the part of the ground, from 0; `None` for the whole ground.
    pub part: Option<usize>,
    /// The file's content.
    pub bytes: Arc<[u8]>,
    pub(crate) format: TrackFormat,
}

impl Track {
    /// Name of the copy in a run's folder.
    pub fn file_name(&self) -> String {
        match self.part {
            None => "track.csv".to_owned(),
            Some(part) => format!("track-{part}.csv"),
        }
    }

    /// The hash that the resolved scene states: `sha256:` and 64 digits.
    pub fn hash(&self) -> String {
        use sha2::Digest;
        let digest = sha2::Sha256::digest(&self.bytes);
        let digits: Vec<String> = digest.iter().map(|b| format!("{b:02x}")).collect();
        format!("sha256:{}", digits.concat())
    }
}
