//! The path of a log: a table, or the folder of a run or of an estimate.

use crate::own_names::METADATA;
use crate::{LogError, TableFormat, bag, mcap_events};
use robhaz_scene::{FileError, LogChoice, ModelErrorTooLarge, Scene, from_stem};
use std::path::{Path, PathBuf};

/// Stem of the table of readings in the folder of a run.
const TABLE: &str = "sensors";
/// The resolved scene in the folder of a run.
const SCENE: &str = "scene.toml";

/// Where a log is, and what is known of it.
#[derive(Clone, Debug)]
pub struct LogPlace {
    /// As the user named it.
    pub path: PathBuf,
    /// Its name: of the scene or description, else of the file.
    pub name: String,
    /// The name of its file or folder, as a name of runs.
    pub file_name: String,
    /// The table of readings, or the files of a bag; none of a folder without either.
    pub(crate) files: Vec<PathBuf>,
    /// What is known: from the folder of a run or the exported run, else the defaults.
    pub choice: LogChoice,
    /// Whether its folder, or the file itself, states robot and noise budget.
    pub is_described: bool,
    /// What the user should know, one line each.
    pub warnings: Vec<String>,
}

/// Why a log cannot be found or described.
#[derive(Debug, thiserror::Error)]
pub enum PlaceError {
    /// The log itself.
    #[error(transparent)]
    Log(#[from] LogError),
    /// The scene or description in its folder or file.
    #[error(transparent)]
    Scene(#[from] FileError),
    /// The nominal robot of the scene in its folder.
    #[error("model_error")]
    ModelError(#[from] ModelErrorTooLarge),
}

impl LogPlace {
    /// Name of the resolved description in the folder of an estimate.
    pub const DESCRIPTION: &str = "log.toml";
    /// Name of the copy of the user's description, in the same folder.
    pub const SENSORS: &str = "sensors.toml";

    /// Finds the log at a path.
    ///
    /// # Errors
    /// [`PlaceError`]: no such file or folder, a folder without readings, or a scene in it that
    /// cannot be read.
    pub fn find(path: &Path) -> Result<Self, PlaceError> {
        let files = match table_in(path) {
            Some(table) => vec![table],
            None if path.is_dir() => bag::files(path)?,
            None if path.exists() => vec![path.to_path_buf()],
            None => {
                let message = "there is no such file or folder";
                return Err(LogError::whole(path, message).into());
            }
        };
        let mut place = Self {
            name: name_of(path),
            file_name: name_of(path),
            path: path.to_path_buf(),
            files,
            choice: LogChoice::default(),
            is_described: false,
            warnings: Vec::new(),
        };
        if path.is_dir() {
            place.describe(path)?;
        } else if bag::is_mcap(path) {
            place.describe_exported()?;
        }
        if let Some(name) = &place.choice.name {
            place.name.clone_from(name);
        }
        Ok(place)
    }

    /// Takes what the folder's scene or description states.
    fn describe(&mut self, folder: &Path) -> Result<(), PlaceError> {
        let (description, scene) = (folder.join(Self::DESCRIPTION), folder.join(SCENE));
        if description.is_file() {
            self.choice = LogChoice::load(&description, LogChoice::default())?;
        } else if scene.is_file() {
            let scene = Scene::load(&scene, &[])?;
            self.choice = LogChoice::of_scene(&scene)?;
            let every = scene.samples_per_record();
            if every > 1 {
                self.warnings.push(format!(
                    "the run estimated at {} Hz and recorded every {every}th reading only: the estimate from its table differs \
                     from its own; run it with record.rate = {} to keep all readings",
                    scene.sensors.rate, scene.sensors.rate,
                ));
            }
        }
        self.is_described = description.is_file() || scene.is_file();
        Ok(())
    }

    /// Takes the description that an exported run has.
    fn describe_exported(&mut self) -> Result<(), PlaceError> {
        let Some(text) = mcap_events::metadata(&self.path, METADATA, Self::DESCRIPTION)? else {
            return Ok(());
        };
        let shown = format!("{} of {}", Self::DESCRIPTION, self.path.display());
        let folder = self.path.parent().unwrap_or(Path::new(""));
        self.choice = LogChoice::parse(&text, &shown, folder, LogChoice::default())?;
        self.is_described = true;
        Ok(())
    }
}

/// The table of readings in a folder.
pub(crate) fn table_in(folder: &Path) -> Option<PathBuf> {
    let mut paths = table_names().into_iter().map(|name| folder.join(name));
    paths.find(|path| path.is_file())
}

fn table_names() -> Vec<String> {
    let name = |(extension, _)| format!("{TABLE}.{extension}");
    TableFormat::ALL.map(name).into()
}

/// The error of a folder without a table of readings.
pub(crate) fn no_table(folder: &Path) -> LogError {
    let message = format!(
        "holds no table of readings; allowed: the folder of a run or of an estimate, with one of {}; or name the file itself, or \
         state the tables of the folder with --sensors SENSORS.toml (docs/logs.md)",
        table_names().join(", ")
    );
    LogError::whole(folder, message)
}

/// The name of a file or folder without extension, as a name of runs.
fn name_of(path: &Path) -> String {
    // `.` and `..` have no name of their own.
    let full = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let name = match path.is_dir() {
        true => full.file_name(),
        false => full.file_stem(),
    };
    from_stem(&name.unwrap_or_default().to_string_lossy())
}
