//! `[terrain]` as it is read: kinds of ground, each with keys of its own.

use crate::points;
use crate::reader::{Reader, join};
use crate::scene::TerrainChoice;
use crate::seed;
use crate::source::{Entry, Node, Value};
use crate::terrain_keys::{
    BUMP, BUMPS, DEFAULT, NO_BUMP, NO_STRETCH, PARTS, PATH, SHAPE, STRETCH, STRETCHES, Shape,
    allowed_in, common, kinds, taken_by,
};
use crate::track::Track;
use robhaz_sim::friction::Stretch;
use robhaz_terrain::{Bump, Course, Heights, Interpolation, Profile};

/// More bumps than this are a mistake.
const MOST_BUMPS: usize = 1000;
/// More parts than this are a mistake.
const MOST_PARTS: usize = 100;
/// More stretches than this slow every contact.
const MOST_STRETCHES: usize = 1000;

/// The default ground.
pub(crate) fn default() -> TerrainChoice {
    TerrainChoice {
        kind: DEFAULT,
        profile: Profile::smooth(),
        stretches: Vec::new(),
        tracks: Vec::new(),
    }
}

/// A ground as it is read.
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
        None => default(),
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
            // Which keys belong to it is then unknown.
            None => return Ground::new(DEFAULT, Profile::smooth()),
        },
    };
    let mark = reader.mark();
    // An override of the kind leaves behind what the file says of its own kind.
    let forgiving = chosen.is_some_and(|c| c.origin.is_override());
    let mut shape = Shape {
        seed,
        ..Shape::default()
    };
    for entry in reader.entries(node, path) {
        let left_behind = forgiving && !entry.origin.is_override();
        let owners = taken_by(&entry.key);
        if common(path).any(|k| k.name == entry.key) {
        } else if owners.is_empty() {
            reader.unknown(entry, path, &allowed_in(kind, path));
        } else if owners.contains(&kind) {
            // The others are read by their kinds.
            if SHAPE.iter().any(|k| k.name == entry.key) {
                reader.entry(SHAPE, entry, path, &mut shape);
            }
        } else if !left_behind {
            foreign(reader, entry, path, kind, owners);
        }
    }
    let mut tracks = Vec::new();
    let profile = match kind {
        "flat" => Profile::Flat,
        "bumps" => Profile::Bumps(read_bumps(reader, node, path)),
        "parts" => {
            let parts = read_parts(reader, node, path, seed);
            let profiles = parts.into_iter().enumerate().map(|(i, part)| {
                let of_part = |track| Track {
                    part: Some(i),
                    ..track
                };
                tracks.extend(part.tracks.into_iter().map(of_part));
                part.profile
            });
            Profile::Course(Course::new(profiles.collect()))
        }
        "heights" => {
            let (points, track) = points::read(reader, node, path);
            tracks.extend(track);
            let way = Interpolation::ALL[shape.interpolation];
            Profile::Heights(Heights::with_smoothing(points, way, shape.smoothing))
        }
        _ => {
            whole_numbers(reader, node, path, kind, &shape);
            if let (true, Some(given)) = (kind == "rough", node.get("seed")) {
                let path = join(path, "seed");
                shape.seed = seed::read(reader, given, &path).unwrap_or(seed);
            }
            shape.profile(kind)
        }
    };
    if let (true, Err(error)) = (reader.mark() == mark, profile.check()) {
        reader.refuse(node, path, &error.to_string());
    }
    Ground {
        kind,
        profile,
        tracks,
    }
}

/// Complains of counts that are no whole numbers.
fn whole_numbers(reader: &mut Reader, node: &Node, path: &str, kind: &str, shape: &Shape) {
    for (key, value) in [("count", shape.count), ("periods", shape.periods)] {
        if let (true, Some(count)) = (taken_by(key).contains(&kind), node.get(key))
            && value.fract() != 0.0
        {
            reader.refuse(count, &join(path, key), "a whole number from 1 to 1000");
        }
    }
}

fn foreign(reader: &mut Reader, entry: &Entry, path: &str, kind: &str, owners: &[&str]) {
    let allowed = match allowed_in(kind, path).as_slice() {
        ["kind"] => "kind alone".to_owned(),
        names => names.join(", "),
    };
    let allowed = format!(
        "with kind = \"{kind}\": {allowed}; {} belongs to kind = \"{}\"",
        entry.key,
        owners.join("\", \"")
    );
    // The key is what is wrong, not its value.
    let key = Node::text(&entry.origin, &entry.key);
    reader.refuse(&key, &join(path, &entry.key), &allowed);
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
