//! Reads `[terrain]`.

use super::bump::{BUMP, NO_BUMP};
use super::choice::TerrainChoice;
use super::kinds::{DEFAULT, KINDS, Parameters, Visitor, names};
use super::points;
use super::section::{COMMON, MOST_STRETCHES, NO_STRETCH, PATH, STRETCH, STRETCHES};
use super::tables::{BUMPS, MOST_BUMPS, MOST_PARTS, PARTS};
use super::track::Track;
use crate::key::{Key, Words};
use crate::reader::{Reader, join};
use crate::seed;
use crate::source::{Entry, Node, Value};
use robhaz_sim::friction::Stretch;
use robhaz_terrain::{Bump, Course, Heights, Profile, Rough};

/// A ground that was read.
struct Ground {
    kind: &'static str,
    profile: Profile,
    /// The files that it comes from.
    tracks: Vec<Track>,
}

impl Ground {
    fn new(kind: &'static str, profile: Profile) -> Self {
        Self {
            kind,
            profile,
            tracks: Vec::new(),
        }
    }
}

/// Reads the section; `seed` is the scene's.
pub(crate) fn read(reader: &mut Reader, root: &Node, seed: u64) -> TerrainChoice {
    match root.get(PATH) {
        None => TerrainChoice::default(),
        Some(node) => {
            let ground = ground(reader, node, PATH, seed);
            TerrainChoice {
                kind: ground.kind,
                profile: ground.profile,
                tracks: ground.tracks,
                stretches: read_stretches(reader, node),
            }
        }
    }
}

/// Reads a table that describes a ground.
fn ground(reader: &mut Reader, node: &Node, path: &str, seed: u64) -> Ground {
    let chosen = node.get("kind");
    let kind = match chosen {
        None => DEFAULT,
        Some(chosen) => match reader.word(kinds(path), chosen, &join(path, "kind")) {
            Some(index) => kinds(path)[index],
            // The allowed keys are then unknown.
            None => return Ground::new(DEFAULT, Profile::smooth()),
        },
    };
    let mark = reader.mark();
    let mut parameters = Parameters::standard(kind);
    parameters.show(&mut Keys {
        reader: &mut *reader,
        node,
        path,
        kind,
        // Where an override sets the kind, the file's keys of its own kind are ignored.
        ignores_file: chosen.is_some_and(|c| c.origin.is_override()),
    });
    let mut ground = Ground::new(kind, Profile::Flat);
    ground.profile = match parameters {
        Parameters::Flat => Profile::Flat,
        Parameters::Smooth => Profile::smooth(),
        Parameters::CosBump(bump) => Profile::CosBump(bump),
        Parameters::Ramp(ramp) => Profile::Ramp(ramp),
        Parameters::Step(stairs) | Parameters::Stairs(stairs) => Profile::Stairs(stairs),
        Parameters::Sine(sine) => Profile::Sine(sine),
        Parameters::Ditch(ditch) => Profile::Ditch(ditch),
        Parameters::Bumps => Profile::Bumps(read_bumps(reader, node, path)),
        Parameters::Rough(mut settings) => {
            let given = node.get("seed");
            let own = given.and_then(|given| seed::read(reader, given, &join(path, "seed")));
            settings.seed = own.unwrap_or(seed);
            Profile::Rough(Rough::new(settings))
        }
        Parameters::Heights(curve) => {
            let (points, track) = points::read(reader, node, path);
            ground.tracks.extend(track);
            let heights = Heights::with_smoothing(points, curve.interpolation, curve.smoothing);
            Profile::Heights(heights)
        }
        Parameters::Parts => {
            let parts = read_parts(reader, node, path, seed);
            let profiles = parts.into_iter().enumerate().map(|(i, part)| {
                let of_part = |track| Track {
                    part: Some(i),
                    ..track
                };
                ground.tracks.extend(part.tracks.into_iter().map(of_part));
                part.profile
            });
            Profile::Course(Course::new(profiles.collect()))
        }
    };
    if let (true, Err(error)) = (reader.mark() == mark, ground.profile.check()) {
        reader.refuse(node, path, &error.to_string());
    }
    ground
}

/// The kinds at a place: a part is neither level ground nor made of parts.
pub(super) fn kinds(path: &str) -> Words {
    match path {
        PATH => KINDS,
        _ => &KINDS[1..KINDS.len() - 1],
    }
}

/// The keys of every kind at a place.
fn common(path: &str) -> impl Iterator<Item = &'static str> {
    let stretches = if path == PATH { STRETCHES } else { &[] };
    COMMON.iter().chain(stretches).map(|k| k.name)
}

/// Reads the keys of a kind, and refuses those of other kinds.
struct Keys<'a> {
    reader: &'a mut Reader,
    node: &'a Node,
    path: &'a str,
    kind: &'static str,
    /// Whether the file may have keys of other kinds, which are ignored.
    ignores_file: bool,
}

impl Visitor for Keys<'_> {
    fn visit<T>(&mut self, keys: &'static [Key<T>], parameters: &mut T) {
        for entry in self.reader.entries(self.node, self.path) {
            let name = entry.key.as_str();
            if keys.iter().any(|k| k.name == name) {
                self.reader.entry(keys, entry, self.path, parameters);
            } else if !common(self.path).any(|common| common == name) {
                let allowed = common(self.path).chain(keys.iter().map(|k| k.name));
                self.refuse(entry, &allowed.collect::<Vec<_>>());
            }
        }
    }
}

impl Keys<'_> {
    /// Refuses a key that the kind does not take.
    fn refuse(&mut self, entry: &Entry, allowed: &[&str]) {
        let owners: Vec<&str> = names()
            .iter()
            .filter(|(_, names)| names.contains(&entry.key.as_str()))
            .map(|(kind, _)| *kind)
            .collect();
        if owners.is_empty() {
            return self.reader.unknown(entry, self.path, allowed);
        }
        if self.ignores_file && !entry.origin.is_override() {
            return;
        }
        let allowed = match allowed {
            ["kind"] => "kind alone".to_owned(),
            names => names.join(", "),
        };
        let allowed = format!(
            "with kind = \"{}\": {allowed}; {} belongs to kind = \"{}\"",
            self.kind,
            entry.key,
            owners.join("\", \"")
        );
        // The key is wrong, not its value.
        let key = Node::text(&entry.origin, &entry.key);
        self.reader
            .refuse(&key, &join(self.path, &entry.key), &allowed);
    }
}

fn read_bumps(reader: &mut Reader, node: &Node, path: &str) -> Vec<Bump> {
    reader.require(BUMPS, node, path);
    let Some(node) = node.get("bumps") else {
        return Vec::new();
    };
    let path = join(path, "bumps");
    let items = match &node.value {
        Value::Array(items) if (1..=MOST_BUMPS).contains(&items.len()) => items.as_slice(),
        _ => {
            reader.refuse(node, &path, &BUMPS[0].field.allowed());
            &[]
        }
    };
    let mut bumps = vec![NO_BUMP; items.len()];
    for (i, (item, bump)) in items.iter().zip(&mut bumps).enumerate() {
        reader.table(BUMP, item, &format!("{path}[{i}]"), bump);
    }
    bumps
}

fn read_parts(reader: &mut Reader, node: &Node, path: &str, seed: u64) -> Vec<Ground> {
    reader.require(PARTS, node, path);
    let Some(node) = node.get("part") else {
        return Vec::new();
    };
    let path = join(path, "part");
    let items = match &node.value {
        Value::Array(items) if (1..=MOST_PARTS).contains(&items.len()) => items.as_slice(),
        _ => {
            reader.refuse(node, &path, &PARTS[0].field.allowed());
            &[]
        }
    };
    let items = items.iter().enumerate();
    items
        .map(|(i, item)| ground(reader, item, &format!("{path}[{i}]"), seed))
        .collect()
}

fn read_stretches(reader: &mut Reader, node: &Node) -> Vec<Stretch> {
    let Some(node) = node.get("stretch") else {
        return Vec::new();
    };
    let items = match &node.value {
        Value::Array(items) if items.len() <= MOST_STRETCHES => items.as_slice(),
        _ => {
            let path = join(PATH, "stretch");
            reader.refuse(node, &path, &STRETCHES[0].field.allowed());
            &[]
        }
    };
    let mut stretches: Vec<Stretch> = Vec::with_capacity(items.len());
    for (i, item) in items.iter().enumerate() {
        let path = format!("{PATH}.stretch[{i}]");
        let mark = reader.mark();
        let mut stretch = NO_STRETCH;
        reader.table(STRETCH, item, &path, &mut stretch);
        if reader.mark() == mark {
            check_stretch(reader, item, &path, &stretch, stretches.last());
            stretches.push(stretch);
        }
    }
    stretches
}

fn check_stretch(
    reader: &mut Reader,
    node: &Node,
    path: &str,
    stretch: &Stretch,
    before: Option<&Stretch>,
) {
    let mut refuse = |key: &str, rule: String| {
        if let Some(node) = node.get(key) {
            reader.refuse(node, &join(path, key), &rule);
        }
    };
    if stretch.to <= stretch.from {
        refuse("to", format!("above from, {} m", stretch.from));
    }
    if stretch.mu_d > stretch.mu_s {
        refuse("mu_d", format!("not above mu_s, {}", stretch.mu_s));
    }
    if let Some(before) = before.filter(|b| stretch.from < b.to) {
        let rule = format!("not below the end of the stretch before, {} m", before.to);
        refuse("from", rule);
    }
}
