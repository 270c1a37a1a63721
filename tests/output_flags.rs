//! `--json`, `--quiet`, `-v`, exit codes and escapes: what scripts rely on. docs/command.md.

use crate::support::{
    assert_contains, page_commands, robhaz, root, short_scene, summary, text, write_short_scene,
};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Output;

fn run(folder: &Path, arguments: &[&str]) -> Output {
    robhaz(folder).args(arguments).output().unwrap()
}

/// The document of a command that must succeed: all of its standard output.
fn document(folder: &Path, arguments: &[&str]) -> Value {
    let mut all = vec!["--json"];
    all.extend(arguments);
    let output = run(folder, &all);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {error}");
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{arguments:?}: {e}: {}", text(&output.stdout)))
}

fn has(document: &Value, keys: &[&str]) {
    for key in keys {
        assert!(document.get(key).is_some(), "{key} is missing: {document}");
    }
}

const STUDY: &str = "scene = \"short.toml\"\nset = [\"record.duration=0.6\"]\n[[axis]]\nkey = \"drive.speed\"\n\
    names = [\"slow\", \"fast\"]\nvalues = [0.1, 0.2]\n[[axis]]\nkey = \"seed\"\ncount = 2\n";

/// Every command with a result in JSON prints one document with the keys that docs/command.md
/// names, and nothing else on standard output. The others refuse the flag.
#[test]
fn each_command_prints_one_document() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    write_short_scene(
        at,
        "[engine]\nkind = \"direct\"\n[sensors]\ngrade = \"typical\"\n",
    );
    fs::write(at.join("study.toml"), STUDY).unwrap();
    let run_ = document(at, &["run", "short.toml", "--rerun", "off"]);
    has(
        &run_["runs"][0],
        &["name", "folder", "command_s", "summary"],
    );
    let summary = summary(&at.join("runs/short"));
    assert_eq!(run_["runs"][0]["summary"], summary);
    let estimate = ["estimate", "runs/short", "--rerun", "off"];
    has(
        &document(at, &estimate),
        &["name", "folder", "command_s", "summary"],
    );
    let compared = document(at, &["compare", "runs/short"]);
    assert_eq!(compared[0]["scene"], "short");
    let verify = document(at, &["verify", "short.toml", "--set", "record.duration=1"]);
    has(&verify, &["scene", "checks"]);
    has(&verify["checks"][0], &["check", "passed", "finding"]);
    let of_call = [
        "name", "folder", "dataset", "runs", "computed", "failed", "damaged", "jobs", "wall_s",
    ];
    let study = document(at, &["study", "short.toml", "--seeds", "2"]);
    has(&study, &of_call);
    has(&study, &["seeds", "samples", "floor", "estimators"]);
    let keys = ["runs", "truths", "shortest_s", "longest_s", "first"];
    has(&document(at, &["study", "study.toml", "--dry-run"]), &keys);
    let study = document(at, &["study", "study.toml", "--out", "studied"]);
    has(&study, &of_call);
    has(&study, &["seeds", "samples", "floor", "estimators"]);
    assert_eq!((&study["runs"], &study["failed"]), (&4.into(), &0.into()));
    let shard = document(
        at,
        &["study", "study.toml", "--out", "one", "--shard", "1/2"],
    );
    has(&shard, &of_call);
    assert_eq!(shard["computed"], 2);
    has(&document(at, &["report", "runs/short"]), &["page"]);
    has(&document(at, &["new", "mine"]), &["scene"]);
    has(
        &document(at, &["export", "runs/short", "--to", "csv"]),
        &["log", "rows", "parts"],
    );
    has(
        &document(at, &["path", "short.toml", "--distance", "1"]),
        &["go", "places"],
    );
    has(
        &document(at, &["schema", "scene"]),
        &["$schema", "properties"],
    );
    assert!(document(at, &["keys"]).is_array());
    for refused in [
        vec!["completions", "bash"],
        vec!["weigh", "--robot", "short.toml", "--plan", "3"],
    ] {
        let mut arguments = vec!["--json"];
        arguments.extend(&refused);
        let output = run(at, &arguments);
        assert_eq!(output.status.code(), Some(2), "{refused:?}");
        assert!(text(&output.stderr).contains("no result in JSON"));
        let help = run(at, &[refused[0], "--help"]);
        assert!(!text(&help.stdout).contains("--json"), "{refused:?}");
    }
    #[cfg(feature = "viewer")]
    assert!(!text(&run(at, &["view", "--help"]).stdout).contains("--json"));
    assert!(text(&run(at, &["run", "--help"]).stdout).contains("--json"));
}

/// 0: done; 1: an error or a bad verdict, of which a document is printed all the same; 2: a wrong
/// command line. 130 and 143 are tested where runs break off.
#[test]
fn exit_codes_are_those_of_the_help() {
    let dir = short_scene();
    let at = dir.path();
    let code = |arguments: &[&str]| run(at, arguments).status.code();
    assert_eq!(code(&["schema", "study"]), Some(0));
    assert_eq!(code(&["run", "nowhere.toml"]), Some(1));
    assert_eq!(
        code(&["run", "short.toml", "--set", "drive.sped=1"]),
        Some(1)
    );
    assert_eq!(code(&["compare", "nowhere"]), Some(1));
    assert_eq!(code(&["fly"]), Some(2));
    assert_eq!(code(&["run"]), Some(2));
    assert_eq!(code(&["schema", "rover"]), Some(2));
    assert_eq!(code(&["study", "study.toml", "--shard", "0/2"]), Some(2));
    let no_go = [
        "--json",
        "path",
        "short.toml",
        "--set",
        "terrain.kind=ramp",
        "--set",
        "terrain.angle=45 deg",
    ];
    let output = run(at, &no_go);
    assert_eq!(output.status.code(), Some(1));
    let verdict: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(verdict["go"], false);
    let help = text(&run(at, &["--help"]).stdout);
    for line in [
        "0    done",
        "1    an error",
        "2    the command",
        "130  stopped",
        "143  stopped",
    ] {
        assert!(help.contains(line), "{line}: {help}");
    }
}

/// A file in a folder that is not there: the message names that folder, not the temporary file.
#[test]
fn a_missing_folder_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let output = run(dir.path(), &["new", "sub/dir/x"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert_contains(&said, "there is no folder sub/dir");
    assert!(!said.contains(".robhaz-"), "{said}");
}

/// `--quiet` prints nothing but errors, on either side of the command; documents that were asked
/// for are still printed.
#[test]
fn quiet_is_quiet() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    // An override of the friction law without effect makes no difference; a spline that overshoots
    // warns.
    let warns = "[terrain]\nkind = \"heights\"\ninterpolation = \"spline\"\npoints = [[-2, 0], [0.8, 0], [0.81, 0.02], [4, 0.02]]\n\
        [record]\nduration = 0.6\ncompare_from = 0.5\n[engine]\nkind = \"direct\"\n";
    fs::write(at.join("warns.toml"), warns).unwrap();
    let loud = run(at, &["run", "warns.toml", "--rerun", "off"]);
    assert_contains(text(&loud.stderr), "Warning");
    for arguments in [
        ["--quiet", "run", "warns.toml", "--rerun", "off", "--force"],
        ["run", "warns.toml", "--rerun", "off", "--force", "-q"],
    ] {
        let output = run(at, &arguments);
        assert!(output.status.success());
        assert_eq!(
            (output.stdout.len(), output.stderr.len()),
            (0, 0),
            "{arguments:?}"
        );
    }
    assert!(!run(at, &["-q", "keys", "torque"]).stdout.is_empty());
    assert!(!run(at, &["-q", "compare", "runs/warns"]).stdout.is_empty());
    assert!(!run(at, &["-q", "compare", "nowhere"]).stderr.is_empty());
}

/// `-v` tells of scenes and stages, `-vv` also of each file, all on standard error; the result is
/// the same.
#[test]
fn verbose_tells_what_is_done() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path();
    write_short_scene(at, "[engine]\nkind = \"direct\"\n");
    let command = ["run", "short.toml", "--rerun", "off", "--force"];
    let with = |flag: &str| {
        let mut arguments = command.to_vec();
        arguments.push(flag);
        run(at, &arguments)
    };
    let silent = run(at, &command);
    assert!(silent.stderr.is_empty());
    let (one, two) = (text(&with("-v").stderr), text(&with("-vv").stderr));
    for words in [
        "scene read",
        "ground=\"flat\"",
        "engine=\"direct\"",
        "seconds=",
    ] {
        assert!(one.contains(words), "{words}: {one}");
    }
    for words in [
        "path=short.toml",
        "simulated_s=1.5",
        "computing_s=",
        "mean_step_s=",
    ] {
        assert!(
            two.contains(words) && !one.contains(words),
            "{words}: {two}"
        );
    }
}

/// Where no terminal reads it, output has no escape sequences, with or without NO_COLOR.
#[test]
fn pipes_get_no_escapes() {
    let dir = short_scene();
    let at = dir.path();
    for arguments in [
        vec!["--help"],
        vec!["run", "nowhere.toml"],
        vec!["run", "short.toml", "--set", "drive.sped=1"],
        vec!["fly"],
        vec![
            "-vv",
            "verify",
            "short.toml",
            "--set",
            "record.duration=0.6",
        ],
    ] {
        for color in [None, Some("1")] {
            let mut command = robhaz(at);
            command.args(&arguments).env_remove("NO_COLOR");
            command.envs(color.map(|value| ("NO_COLOR", value)));
            let output = command.output().unwrap();
            let all = [output.stdout, output.stderr].concat();
            assert!(
                !all.is_empty() && !all.contains(&0x1b),
                "{arguments:?}: {}",
                text(&all)
            );
        }
    }
}

/// The commands of docs/command.md run.
#[test]
fn the_commands_of_the_page_run() {
    let commands = page_commands("command.md");
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("scenes")).unwrap();
    let flat = root().join("scenes/flat.toml");
    fs::copy(flat, dir.path().join("scenes/flat.toml")).unwrap();
    for line in &commands {
        let (command, file) = line.split_once(" > ").unwrap_or((line, ""));
        let words: Vec<&str> = command.split_whitespace().collect();
        assert_eq!(words[0], "robhaz", "{line}");
        let output = run(dir.path(), &words[1..]);
        assert!(output.status.success(), "{line}: {}", text(&output.stderr));
        if !file.is_empty() {
            let _: Value = serde_json::from_slice(&output.stdout).unwrap();
        }
    }
    assert_eq!(commands.len(), 4);
}
