//! From a file to a [`Scene`].

use crate::error::SceneError;
use crate::form::from_stem;
use crate::model_error::ModelError;
use crate::reader::Reader;
use crate::reference::home_of;
use crate::scene::{Scene, SensorChoice};
use crate::sections::SCENE;
use crate::source::{self, Node, Source};
use crate::write::Out;
use crate::{checks, contact, control, overrides, sensors};
use std::path::Path;

impl Scene {
    /// Reads a scene file; `overrides` are texts `key=value` that take precedence over the file, later ones over
    /// earlier ones.
    ///
    /// # Errors
    /// [`SceneError`] with all problems of the file, of files that it names, and of the overrides.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        let shown = path.display().to_string();
        let text = source::read_toml(path).map_err(|error| {
            let message = format!("{error}; allowed: a scene file in TOML, UTF-8");
            SceneError::unread(&shown, message)
        })?;
        let base_dir = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, &shown, base_dir, overrides)
    }

    /// Reads the text of a scene file.
    ///
    /// `source_name` is the file's name in messages, and the scene's name where the text gives none. Paths in the
    /// scene are relative to `base_dir`.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse(
        text: &str,
        source_name: &str,
        base_dir: &Path,
        overrides: &[String],
    ) -> Result<Self, SceneError> {
        source::check_toml(text).map_err(|error| SceneError::unread(source_name, error))?;
        let mut reader = Reader::new(base_dir.to_owned(), home_of);
        let mut root = reader.document(&Source::file(source_name, text));
        for text in overrides {
            overrides::apply(&mut reader, &mut root, text);
        }
        sensors::forget_old_grade(&mut root);
        contact::forget_old_law(&mut root);
        let scene = read(&mut reader, &root, source_name);
        reader.finish(scene)
    }
}

impl Scene {
    /// The scene as a file that reads back as exactly this scene, in any folder that also has copies of its
    /// [tracks](crate::TerrainChoice::tracks), named [`crate::Track::file_name`]. `version` names the program that writes
    /// it, such as `robhaz 0.1.0, rapier2d 0.36.1`.
    pub fn to_toml(&self, version: &str) -> String {
        let comment =
            "A scene with every choice written out. SI units. It can be run again as it is.";
        Out::file(comment, version, SCENE, &mut self.clone())
    }
}

fn read(reader: &mut Reader, root: &Node, source_name: &str) -> Scene {
    let stem = Path::new(source_name).file_stem().unwrap_or_default();
    let grade = sensors::chosen_grade(root);
    let mut scene = Scene {
        name: from_stem(&stem.to_string_lossy()),
        friction: contact::chosen_law(root),
        sensors: SensorChoice::of(grade),
        model_error: ModelError::of_grade(grade),
        ..Scene::default()
    };
    // The seed of random ground that has none of its own.
    let seed = root.get("seed").and_then(Node::whole);
    reader.seed = seed.and_then(|s| u64::try_from(s).ok()).unwrap_or_default();
    reader.table(SCENE, root, "", &mut scene);
    control::choose_estimator(reader, root, &mut scene);
    checks::check(reader, root, &scene);
    scene
}
