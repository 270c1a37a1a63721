//! The resolved scene as a file: every choice with its unit.

use crate::control;
use crate::drive;
use crate::estimators;
use crate::key::{Field, Key, SWITCH};
use crate::robot::{self, RobotChoice};
use crate::robot_keys;
use crate::scene::Scene;
use crate::sections::{IGNORED, SECTIONS};
use crate::terrain::{self, Column, Parameters, Track, Visitor};
use crate::wheels::WHEELS;
use robhaz_control::FrictionTestPlan;
use robhaz_estimator::statics::{LOAD_PARAMETERS, LoadCovariance};
use robhaz_model::Vec2;
use robhaz_terrain::{Bump, Profile};
use std::fmt::Write;

impl Scene {
    /// The scene as a file that reads back as exactly this scene, in any folder that also has copies of its
    /// [tracks](crate::TerrainChoice::tracks), named [`Track::file_name`]. `version` names the program that writes it,
    /// such as `robhaz 0.1.0, rapier2d 0.36.1`.
    pub fn to_toml(&self, version: &str) -> String {
        let mut out = Out::default();
        out.line(
            "# A scene with every choice written out. SI units. It can be run again as it is.",
        );
        out.key("name", &text(&self.name), "");
        out.key("seed", &self.seed.to_string(), "");
        if self.estimators.is_empty() {
            out.key(estimators::PATH, "[]", "none");
        }
        out.head(&format!("[{IGNORED}]"), "what wrote this file; not read");
        out.key("version", &text(version), "");
        write_robot(&mut out, &self.robot);
        write_terrain(&mut out, self);
        write_stretches(&mut out, self);
        let mut scene = self.clone();
        for section in SECTIONS {
            out.head(&format!("[{}]", section.name), section.meaning);
            out.table(section.keys, &mut scene, section.name);
            if section.name == drive::PATH {
                if let Some(estimator) = &self.control.estimator {
                    out.key(control::ESTIMATOR_NAME, &text(estimator), "");
                }
                write_friction_test(&mut out, self);
                write_scalings(&mut out, self);
            }
        }
        for estimator in &self.estimators {
            let mut keys = estimators::Keys::of(&estimator.settings);
            out.head(&format!("[[{}]]", estimators::PATH), "");
            out.key(
                "name",
                &text(estimators::preset_of(&estimator.settings)),
                "",
            );
            out.key("label", &text(&estimator.name), "");
            out.table(estimators::KEYS, &mut keys, estimators::PATH);
        }
        out.0
    }
}

/// Writes `[robot]`, geometry and masses in full.
pub(crate) fn write_robot(out: &mut Out, choice: &RobotChoice) {
    let mut robot = choice.robot.clone();
    let path = robot::GEOMETRY_PART.path;
    out.head(&format!("[{path}]"), "positions in the nominal pose");
    out.key("name", &text(&choice.geometry_name), "");
    out.table(robot_keys::GEOMETRY, &mut robot.geometry, path);
    let path = robot::MASS_PART.path;
    out.head(
        &format!("[{path}]"),
        "inertias about the parts' own centres of mass",
    );
    out.key("name", &text(&choice.mass_name), "");
    out.table(robot_keys::MASSES, &mut robot.mass, path);
}

fn write_terrain(out: &mut Out, scene: &Scene) {
    let choice = &scene.terrain;
    out.head(&format!("[{}]", terrain::PATH), "the ground");
    let track = |part| choice.tracks.iter().find(|t| t.part == part);
    write_ground(out, choice.kind, &choice.profile, track(None));
    if let Profile::Course(course) = &choice.profile {
        for (i, part) in course.profiles().enumerate() {
            out.head(&format!("[[{}.part]]", terrain::PATH), "");
            write_ground(out, terrain::kind_of(part), part, track(Some(i)));
        }
    }
}

fn write_ground(out: &mut Out, kind: &str, profile: &Profile, track: Option<&Track>) {
    out.key("kind", &text(kind), "");
    match profile {
        Profile::Flat | Profile::Course(_) => {}
        Profile::Bumps(bumps) if kind == terrain::DEFAULT => {
            out.line("# These bumps are what the kind stands for:");
            for line in bump_lines(bumps) {
                out.line(&format!("# {line}"));
            }
        }
        Profile::Bumps(bumps) => bump_lines(bumps).iter().for_each(|l| out.line(l)),
        Profile::Heights(heights) => {
            write_parameters(out, kind, profile);
            match track {
                Some(track) => write_track(out, track),
                None => write_points(out, heights.points()),
            }
        }
        profile => write_parameters(out, kind, profile),
    }
}

fn write_parameters(out: &mut Out, kind: &str, profile: &Profile) {
    Parameters::of(kind, profile).show(out);
    if let Profile::Rough(rough) = profile {
        out.key("seed", &rough.settings().seed.to_string(), "");
    }
}

fn write_points(out: &mut Out, points: &[Vec2]) {
    out.line("points = [ # m");
    for at in points {
        out.line(&format!("    {},", point(*at)));
    }
    out.line("]");
}

fn write_track(out: &mut Out, track: &Track) {
    out.key(
        "file",
        &text(&track.file_name()),
        "the copy beside this file",
    );
    out.key("file_hash", &text(&track.hash()), "");
    let column = |column: &Column| match column {
        Column::Name(name) => text(name),
        Column::Number(number) => number.to_string(),
    };
    let choice = &track.choice;
    for (key, chosen) in [("x_column", &choice.x), ("height_column", &choice.height)] {
        if let Some(chosen) = chosen {
            out.key(key, &column(chosen), "");
        }
    }
    out.key("sort", &text(SWITCH[usize::from(choice.sort)]), "");
}

fn write_stretches(out: &mut Out, scene: &Scene) {
    for stretch in &scene.terrain.stretches {
        let mut stretch = *stretch;
        let path = format!("{}.stretch", terrain::PATH);
        out.head(&format!("[[{path}]]"), "");
        out.table(terrain::STRETCH, &mut stretch, &path);
    }
}

/// The friction tests, where they are not the default ones.
fn write_friction_test(out: &mut Out, scene: &Scene) {
    let mut plan = scene.control.friction_test;
    if plan == FrictionTestPlan::default() {
        return;
    }
    out.head(&format!("[{}]", control::FRICTION_TEST_PATH), "");
    let wheels: Vec<String> = plan
        .wheels
        .iter()
        .flatten()
        .map(|i| (i + 1).to_string())
        .collect();
    out.key(WHEELS, &format!("[{}]", wheels.join(", ")), "");
    out.table(
        control::FRICTION_TESTS,
        &mut plan,
        control::FRICTION_TEST_PATH,
    );
}

fn write_scalings(out: &mut Out, scene: &Scene) {
    for scaling in &scene.drive.scalings {
        let mut scaling = *scaling;
        out.head(&format!("[[{}]]", drive::SCALING_PATH), "");
        let wheels = (1..=3_usize).filter(|wheel| scaling.wheels[wheel - 1]);
        let wheels: Vec<String> = wheels.map(|wheel| wheel.to_string()).collect();
        out.key("wheels", &format!("[{}]", wheels.join(", ")), "");
        out.table(drive::SCALINGS, &mut scaling, drive::SCALING_PATH);
    }
}

fn bump_lines(bumps: &[Bump]) -> Vec<String> {
    let mut lines = vec!["bumps = [ # m".to_owned()];
    for bump in bumps {
        let mut bump = *bump;
        let fields = terrain::BUMP.iter().filter_map(|key| {
            let value = value(&key.field, &mut bump)?;
            Some(format!("{} = {value}", key.name))
        });
        let fields = fields.collect::<Vec<_>>().join(", ");
        lines.push(format!("    {{ {fields} }},"));
    }
    lines.push("]".to_owned());
    lines
}

/// A TOML file being written.
#[derive(Default)]
pub(crate) struct Out(String);

impl Out {
    /// The text of the file.
    pub fn into_text(self) -> String {
        self.0
    }

    pub fn line(&mut self, line: &str) {
        self.0.push_str(line);
        self.0.push('\n');
    }

    pub fn head(&mut self, head: &str, comment: &str) {
        self.line("");
        self.line(&with_comment(head, comment));
    }

    pub fn key(&mut self, name: &str, value: &str, comment: &str) {
        self.line(&with_comment(&format!("{name} = {value}"), comment));
    }

    /// Writes a key with its unit and meaning.
    pub fn field<T>(&mut self, key: &Key<T>, of: &mut T) {
        if let Some(value) = value(&key.field, of) {
            let unit = key.field.unit();
            let comment = match unit {
                "" => key.meaning.to_owned(),
                _ => format!("{unit}; {}", key.meaning),
            };
            self.key(key.name, &value, &comment);
        }
    }

    /// Writes the keys of a table whose heading is written, then the tables in it.
    pub fn table<T>(&mut self, keys: &[Key<T>], of: &mut T, path: &str) {
        for key in keys {
            self.field(key, of);
        }
        for key in keys {
            if let Field::Table(keys) = key.field {
                let path = format!("{path}.{}", key.name);
                self.head(&format!("[{path}]"), key.meaning);
                self.table(keys, of, &path);
            }
        }
    }
}

impl Visitor for Out {
    fn visit<T>(&mut self, keys: &'static [Key<T>], parameters: &mut T) {
        for key in keys {
            self.field(key, parameters);
        }
    }
}

fn with_comment(text: &str, comment: &str) -> String {
    match comment {
        "" => text.to_owned(),
        _ => format!("{text} # {comment}"),
    }
}

/// The value of a field in TOML; `None` for tables and for what a section writes itself.
pub(crate) fn value<T>(field: &Field<T>, of: &mut T) -> Option<String> {
    Some(match field {
        Field::Number(_, at) => number(*at(of)),
        Field::Count(_, get, _) => number(f64::from(get(of))),
        Field::Three(_, at) => array(at(of).map(number)),
        Field::Point(_, at) => point(*at(of)),
        Field::ThreePoints(_, at) => array(at(of).map(point)),
        Field::Switch(at) => text(SWITCH[usize::from(*at(of))]),
        Field::Word(words, get, _) => text(words[get(of)]),
        Field::ThreeWords(words, get, _) => array(get(of).map(|i| text(words[i]))),
        Field::LoadCovariance(at) => covariance((*at(of))?),
        Field::Text(at) => text(at(of)),
        Field::Table(_) | Field::Own { .. } | Field::OwnWord { .. } => return None,
    })
}

/// The shortest decimal that reads back as the same bits.
fn number(value: f64) -> String {
    format!("{value:?}")
}

/// Rows of numbers, one a line.
fn covariance(covariance: LoadCovariance) -> String {
    let row = |row: [f64; LOAD_PARAMETERS]| format!("  [{}]", row.map(number).join(", "));
    format!("[\n{}\n]", covariance.rows().map(row).join(",\n"))
}

fn point(point: Vec2) -> String {
    format!("[{}, {}]", number(point.x), number(point.y))
}

fn array(items: [String; 3]) -> String {
    format!("[{}]", items.join(", "))
}

/// A text in quotes, as TOML writes it.
pub(crate) fn text(value: &str) -> String {
    let mut out = String::from('"');
    for c in value.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c if c.is_control() => {
                // Writing to a text cannot fail.
                let _ = write!(out, "\\u{:04X}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
