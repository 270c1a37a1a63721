//! From a file to a [`Scene`].

use crate::error::SceneError;
use crate::model_error::ModelError;
use crate::reader::Reader;
use crate::reference::home_of;
use crate::scene::{Scene, SensorChoice};
use crate::sections::{IGNORED, SECTIONS, TOP};
use crate::source::{Node, Source};
use crate::{
    checks, contact, control, drive, estimators, file, name, overrides, robot, seed, sensors,
    terrain,
};
use std::path::Path;

impl Scene {
    /// Reads a scene file; `overrides` are texts `key=value` that take precedence over the file, later ones over
    /// earlier ones.
    ///
    /// # Errors
    /// [`SceneError`] with all problems of the file, of files that it names, and of the overrides.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        let shown = path.display().to_string();
        let text = file::read_toml(path).map_err(|error| {
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
        file::check_toml(text).map_err(|error| SceneError::unread(source_name, error))?;
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

fn read(reader: &mut Reader, root: &Node, source_name: &str) -> Scene {
    top_level(reader, root);
    let stem = Path::new(source_name).file_stem().unwrap_or_default();
    let given = root.get("name").map(|n| name::read(reader, n, "name"));
    let seed = root.get("seed").and_then(|n| seed::read(reader, n, "seed"));
    let seed = seed.unwrap_or(0);
    let grade = sensors::chosen_grade(root);
    let mut scene = Scene {
        name: given
            .flatten()
            .unwrap_or_else(|| name::from_stem(&stem.to_string_lossy())),
        seed,
        robot: robot::read(reader, root),
        terrain: terrain::read(reader, root, seed),
        estimators: estimators::read(reader, root),
        friction: contact::chosen_law(root),
        sensors: SensorChoice::of(grade),
        model_error: ModelError::of_grade(grade),
        ..Scene::default()
    };
    for section in SECTIONS {
        if let Some(node) = root.get(section.name) {
            reader.table(section.keys, node, section.name, &mut scene);
        }
    }
    scene.drive.scalings = drive::read_scalings(reader, root);
    scene.control.friction_test = control::read_friction_test(reader, root);
    scene.control.estimator = control::read_estimator(reader, root, &scene);
    checks::check(reader, root, &scene);
    scene
}

/// Adds a problem for every entry that is neither a top-level key nor a section.
fn top_level(reader: &mut Reader, root: &Node) {
    let allowed: Vec<&str> = TOP
        .iter()
        .map(|k| k.name)
        .chain(["robot", terrain::PATH, estimators::PATH])
        .chain(SECTIONS.iter().map(|s| s.name))
        .collect();
    for entry in reader.entries(root, "") {
        if entry.key != IGNORED && !allowed.contains(&entry.key.as_str()) {
            reader.unknown(entry, "", &allowed);
        }
    }
}
