//! For any content of a file the reader returns a scene or problems: no panic, bounded time and
//! memory, short messages.
//!
//! Three hundred mutations of the shipped scenes, thirty of tracks in each use and ten of robots in
//! each part, always the same ones. A failure names its case.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at the first surprise"
)]

use robhaz_scene::{FileError, Scene};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A case may take 2 s on a free machine, and five times as long on one that is busy with other
/// tests.
const LONGEST: Duration = Duration::from_secs(10);
/// Largest memory that a loop may need in addition to that of the process before it, kB.
const MOST_MEMORY: u64 = 200_000;
/// Largest size of a message, bytes: 21 problems of three files, each with its place.
const MOST_TEXT: usize = 100_000;

/// One loop at a time: memory is counted for the whole process.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// From 0 to `end` - 1; 0 for an empty range.
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    fn of<'a, T: ?Sized>(&mut self, items: &[&'a T]) -> &'a T {
        items[self.below(items.len())]
    }

    /// A range of a file's bytes, mostly short.
    fn range(&mut self, length: usize) -> std::ops::Range<usize> {
        let most = self.of(&[&1_usize, &8, &60, &1000]).min(&length).to_owned();
        let start = self.below(length + 1);
        start..(start + self.below(most + 1)).min(length)
    }
}

const NUMBERS: &[&str] = &[
    "0",
    "-0.0",
    "1e308",
    "-1e308",
    "1e309",
    "5e-324",
    "nan",
    "-inf",
    "9223372036854775808",
    "0x7f",
    "1_0",
    "1e-7",
    "-1",
    "1e6",
    "0.1e",
    "00",
    "1.",
    "''",
    "[]",
    "true",
    "1979-05-27",
    "18446744073709551616",
    "1,5",
    "\"1 mm\"",
    "\"1e9 m\"",
];
const TEXTS: &[&str] = &[
    "\u{1b}[31m",
    "\u{0}",
    "\u{202e}",
    "\u{feff}",
    "漢字",
    "e\u{301}",
    "\u{10ffff}",
    "\"",
    "'''",
    "\"\"\"",
    "[",
    "]]",
    "{",
    "}",
    "=",
    "[[terrain.part]]\n",
    "a.b.c=1\n",
    "\r",
    "\r\n",
    "\n\n",
    "#",
    ";",
    "\t",
    ",",
    "\\u0000",
    "kind=\"heights\"\n",
    "sep=;\n",
];

/// One change of a file.
fn mutate(random: &mut Random, bytes: &mut Vec<u8>) {
    let tokens = |bytes: &[u8]| -> Vec<std::ops::Range<usize>> {
        let is_word = |b: u8| b.is_ascii_alphanumeric() || b".-+_".contains(&b) || b >= 0x80;
        let mut tokens = Vec::new();
        let mut start = None;
        for (i, b) in bytes.iter().chain(b" ").enumerate() {
            match (start, is_word(*b)) {
                (None, true) => start = Some(i),
                (Some(from), false) => {
                    tokens.push(from..i);
                    start = None;
                }
                _ => {}
            }
        }
        tokens
    };
    let range = random.range(bytes.len());
    match random.below(9) {
        0 if !bytes.is_empty() => {
            let at = random.below(bytes.len());
            bytes[at] ^= 1 << random.below(8);
        }
        1 => drop(bytes.drain(range)),
        2 => {
            let part = bytes[range].to_vec();
            let at = random.below(bytes.len() + 1);
            bytes.splice(at..at, part);
        }
        3 | 4 => {
            let is_number = |t: &std::ops::Range<usize>| bytes[t.start].is_ascii_digit();
            let numbers: Vec<_> = tokens(bytes).into_iter().filter(is_number).collect();
            if let Some(at) = numbers.get(random.below(numbers.len())) {
                bytes.splice(at.clone(), random.of(NUMBERS).bytes());
            }
        }
        5 => {
            let tokens = tokens(bytes);
            let (a, b) = (random.below(tokens.len()), random.below(tokens.len()));
            if let (Some(a), Some(b)) = (tokens.get(a.min(b)), tokens.get(a.max(b)))
                && a.end <= b.start
            {
                let (first, second) = (bytes[a.clone()].to_vec(), bytes[b.clone()].to_vec());
                bytes.splice(b.clone(), first);
                bytes.splice(a.clone(), second);
            }
        }
        6 => {
            let at = random.below(bytes.len() + 1);
            bytes.splice(at..at, random.of(TEXTS).bytes());
        }
        7 => {
            let part = bytes[range.clone()].to_vec();
            // Up to a megabyte, and now and then beyond every limit of a scene file.
            let sizes = [
                1_000, 10_000, 10_000, 100_000, 100_000, 1_000_000, 1_000_000, 7_000_000,
            ];
            let size = sizes[random.below(sizes.len())];
            let repeated = part.repeat(size / part.len().max(1));
            bytes.splice(range, repeated);
        }
        _ => bytes.truncate(range.start),
    }
}

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn files(folder: &str, start: &str, extension: &str) -> Vec<Vec<u8>> {
    let entries = std::fs::read_dir(top().join(folder)).unwrap();
    let mut files: Vec<_> = entries.map(|e| e.unwrap().path()).collect();
    files.retain(|f| {
        let name = f.file_name().unwrap().to_string_lossy();
        name.starts_with(start) && name.ends_with(extension)
    });
    files.sort();
    assert!(!files.is_empty());
    files.iter().map(|f| std::fs::read(f).unwrap()).collect()
}

/// Reads mutations of files under `name` in a folder, where the scene is `scene.toml`. Some of them
/// must be valid, and most must be invalid.
fn reads((seed, cases): (u64, u32), originals: &[Vec<u8>], name: &str, scene: &str) {
    let _alone = alone();
    let before = memory("VmRSS:");
    // The greatest use counts from here on.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    let folder = tempfile::tempdir().unwrap();
    // Paths of shipped scenes lead to the shipped files.
    std::os::unix::fs::symlink(top().join("terrains"), folder.path().join("terrains")).unwrap();
    let below = folder.path().join("scenes");
    std::fs::create_dir(&below).unwrap();
    std::fs::write(below.join("scene.toml"), scene).unwrap();
    let mut random = Random(seed);
    let (mut good, mut bad, mut longest) = (0, 0, Duration::ZERO);
    for case in 0..cases {
        let mut bytes = originals[random.below(originals.len())].clone();
        for _ in 0..=random.below(4) {
            mutate(&mut random, &mut bytes);
        }
        std::fs::write(below.join(name), &bytes).unwrap();
        let start = Instant::now();
        let read = Scene::load(&below.join("scene.toml"), &[]);
        let time = start.elapsed();
        match read {
            Ok(scene) => {
                good += 1;
                comes_back(&scene, &below);
                let _ = scene.warnings();
            }
            Err(error) => {
                bad += 1;
                let shown = messages(&error);
                assert!(
                    shown.len() < MOST_TEXT,
                    "{name} {case}: {} bytes",
                    shown.len()
                );
                let plain = |c: char| c == '\n' || !c.is_control();
                assert!(shown.chars().all(plain), "{name} {case}: {shown:?}");
            }
        }
        assert!(time < LONGEST, "{name} {case}: {time:?}");
        longest = longest.max(time);
    }
    let needed = memory("VmHWM:")
        .zip(before)
        .map(|(most, b)| most.saturating_sub(b));
    println!("{name}: {good} good, {bad} bad, longest {longest:?}, memory {needed:?} kB");
    assert!(good > cases / 50 && bad > cases / 5, "{good} {bad}");
    assert!(needed.is_none_or(|kb| kb < MOST_MEMORY), "{needed:?} kB");
}

/// All messages of an error, one a line.
fn messages(error: &FileError) -> String {
    let lines: Vec<String> = error.problems.iter().map(ToString::to_string).collect();
    lines.join("\n")
}

/// A scene that was read can be written, and reads back as the same scene.
fn comes_back(scene: &Scene, folder: &Path) {
    let folder = folder.join("again");
    std::fs::create_dir_all(&folder).unwrap();
    for track in &scene.terrain.tracks {
        std::fs::write(folder.join(track.file_name()), &track.bytes).unwrap();
    }
    let text = scene.to_toml("x");
    let again = Scene::parse(&text, "scene.toml", &folder, &[]);
    assert!(again.unwrap_or_else(|e| panic!("{e}")) == *scene);
}

/// Memory of the process, kB: `VmRSS:` now, `VmHWM:` the largest so far; where the system provides
/// it.
fn memory(which: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with(which))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

#[test]
fn mutated_scenes_are_read_or_refused() {
    let originals = files("scenes", "", ".toml");
    reads((1, 150), &originals, "scene.toml", "");
}

#[test]
fn mutated_tracks_are_read_or_refused() {
    let mut originals = files("terrains", "", ".csv");
    // As other programs would write the same.
    let german = String::from_utf8(originals[0].clone()).unwrap();
    let german = german.replace(',', ";").replace('.', ",");
    originals.push(german.replace("x;y", "Weg [m];Höhe [m]").into_bytes());
    let scene = "[terrain]\nkind = 'heights'\nfile = 'track.csv'\n";
    reads((2, 30), &originals, "track.csv", scene);
    reads(
        (3, 30),
        &originals,
        "track.csv",
        &format!("{scene}sort = 'on'\nsmoothing = 0.1\n"),
    );
}

#[test]
fn mutated_robots_are_read_or_refused() {
    for (seed, part) in [(4, "geometry"), (5, "mass")] {
        let originals = files("robots", part, ".toml");
        reads(
            (seed, 10),
            &originals,
            "robot.toml",
            &format!("[robot]\n{part} = 'robot.toml'\n"),
        );
    }
}

/// Large files full of mistakes: the messages do not grow with the file. Some once took minutes.
#[test]
fn large_files_full_of_mistakes_have_short_messages() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, text: &str, expected: &str| {
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        let scene = match name.ends_with("csv") {
            true => format!("[terrain]\nkind = 'heights'\nfile = '{name}'\n"),
            false => text.to_owned(),
        };
        let error = Scene::parse(&scene, name, folder.path(), &[]).unwrap_err();
        let shown = messages(&error);
        assert!(shown.len() < 20_000, "{name}: {} bytes", shown.len());
        assert!(shown.contains(expected), "{name}: {shown}");
    };
    let lines =
        |line: &dyn Fn(usize) -> String, count: usize| -> String { (0..count).map(line).collect() };
    refused(
        "keys.toml",
        &lines(&|i| format!("key{i} = 1\n"), 8000),
        "and 7 980 more problems",
    );
    refused("syntax.toml", &"= = =\n".repeat(20_000), "more problems");
    refused(
        "long.toml",
        &format!("drive.kp = \"{}\"", "1".repeat(1_000_000)),
        "allowed: a number",
    );
    refused(
        "wide.toml",
        &format!("{} = 1", "k".repeat(1_000_000)),
        "unknown key",
    );
    refused(
        "array.toml",
        &format!("drive.kp = [{}]", "0,".repeat(100_000)),
        "allowed: a number",
    );
    refused(
        "huge.toml",
        &"a=1\n".repeat(2_000_000),
        "at most 6 000 000 bytes",
    );
    refused(
        "words.csv",
        &lines(&|i| format!("{i} high\n"), 10_000),
        "separator comma",
    );
    refused(
        "cells.csv",
        &lines(&|i| format!("{i},high\n"), 10_000),
        "cells.csv:1: terrain.file: found \"high\" in column 2",
    );
    refused(
        "back.csv",
        &lines(&|i| format!("{};0,1\n", 1000 - i % 2), 10_000),
        "back.csv:2: terrain.file: found x = 999 m",
    );
    let points = lines(&|i| format!("[{}, 0],\n", i as f64 / 1000.0), 100_001);
    let points = format!("[terrain]\nkind = 'heights'\npoints = [{points}]");
    refused(
        "points.toml",
        &points,
        "found 100 001 points, allowed: an array of 2 to 100000 points",
    );
    let long = lines(&|i| format!("{},0\n", i as f64 / 4000.0), 2_000_001);
    refused(
        "long.csv",
        &long,
        "found more points, allowed: at most 2 000 000",
    );
}
