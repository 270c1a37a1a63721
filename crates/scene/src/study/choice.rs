//! A study file with every choice made.

use super::axis::Axis;
use crate::source::Origin;
use robhaz_model::named;
use std::path::{Path, PathBuf};

/// What is varied in which scene: the content of a study file.
#[derive(Clone, Debug)]
pub struct StudyChoice {
    /// `name` of the file, else the file's stem: the name of the default output folder.
    pub name: String,
    /// The base scene, and where it was written.
    pub(super) base: (PathBuf, Origin),
    /// Overrides `key=value` of the base scene in every run, and where each was written.
    pub(super) overrides: Vec<(String, Origin)>,
    /// The axes in the file's order.
    pub axes: Vec<Axis>,
    /// How axes with a distribution are drawn; `None` without such an axis.
    pub draws: Option<Draws>,
    /// Runs that keep their full tables.
    pub tables: StudyTables,
    /// Text of the file.
    pub text: String,
}

impl StudyChoice {
    /// The base scene, relative to the folder of the study file unless absolute.
    pub fn scene(&self) -> &Path {
        &self.base.0
    }
}

/// How the axes with a distribution are drawn. Together they are one list of `count` samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draws {
    /// Number of samples.
    pub count: u64,
    /// Seed of the draws.
    pub seed: u64,
    /// How the samples fill the space.
    pub method: DrawMethod,
}

named! {
    /// How samples fill the space of the axes with a distribution.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum DrawMethod {
        /// Latin hypercube (McKay, Beckman and Conover 1979): each axis has one sample in each of
        /// `count` equally likely intervals.
        #[default]
        LatinHypercube = "latin-hypercube",
        /// Independent draws. The first samples stay the same when there are more.
        Random = "random",
    }
}

/// Runs that keep their full tables.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum StudyTables {
    /// None.
    #[default]
    None,
    /// All.
    All,
    /// Those with these indices.
    Runs(Vec<u64>),
}

impl StudyTables {
    /// Whether a run keeps its tables.
    pub fn keeps(&self, run: u64) -> bool {
        match self {
            Self::None => false,
            Self::All => true,
            Self::Runs(runs) => runs.contains(&run),
        }
    }
}
