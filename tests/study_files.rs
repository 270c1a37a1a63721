//! The command `robhaz study` on study files: the same dataset whatever happens on the way.
#![cfg(unix)]

use crate::support::{assert_contains, on_one_line, refused, robhaz, succeeded, text, words};
use std::fs;
use std::path::Path;
use std::process::{Output, Stdio};
use std::time::Duration;

/// A scene of a few milliseconds of computing.
const SCENE: &str = "[terrain]\nkind = \"flat\"\n[engine]\nkind = \"rapier\"\n[sensors]\ngrade = \"typical\"\n\
    [record]\nduration = 0.04\ncompare_from = 0.02\n[[estimator]]\nname = \"paper-wheels\"\n[[estimator]]\nname = \"kalman\"\n";

/// A folder with that scene and a study of it.
fn study(axes: &str) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("scene.toml"), SCENE).unwrap();
    let text = format!("scene = \"scene.toml\"\n{axes}");
    fs::write(dir.path().join("study.toml"), text).unwrap();
    dir
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    robhaz(folder).args(arguments).output().unwrap()
}

/// Runs a command that must succeed. Returns standard output.
fn succeed(folder: &Path, arguments: &[&str]) -> String {
    text(&succeeded(robhaz(folder).args(arguments)).stdout)
}

fn dataset(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name).join("study.parquet")).unwrap()
}

/// An axis of each kind; 500 runs.
const MANY: &str = "tables = [3]\n[[axis]]\nkey = \"drive.speed\"\nvalues = [0.1, \"0.2 m/s\"]\n\
    [[axis]]\nkeys = [\"drive.kp\", \"drive.ki\"]\nvalues = [[2, 0], [5, 50.5]]\n[[axis]]\nkey = \"seed\"\ncount = 5\n\
    [[axis]]\nkey = \"robot.mass.body\"\nnormal = [5, 0.2]\n[[axis]]\nkey = \"contact.mu_s\"\nuniform = [0.75, 1]\n\
    [draw]\ncount = 25\n";

/// Kills at random instants, 20 of them, lose nothing: the dataset has the same bytes as that of a
/// study that was left alone. So has the one of three shards, with other numbers of threads, and
/// that of one shard and the rest.
#[test]
fn kills_and_shards_leave_the_same_dataset() {
    let dir = study(MANY);
    succeed(dir.path(), &words("study study.toml --out alone --jobs 2"));
    let whole = dataset(dir.path(), "alone");

    let journal = dir.path().join("killed/runs.jsonl");
    let finished =
        || fs::read(&journal).map_or(0, |text| text.iter().filter(|b| **b == b'\n').count());
    let (mut lines, mut random) = (vec![0], 12345_u64);
    for kill in 0..20 {
        let mut child = robhaz(dir.path())
            .args(["study", "study.toml", "--out", "killed", "--jobs", "2"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // Up to 15 runs more than at the last kill and up to 16 ms later, by a congruential
        // generator: before the first run, in a run, in a line. The last kill is far from the end.
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let least = 15 * kill + (random >> 60) as usize;
        while kill > 2 && finished() < least {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_micros(random >> 50));
        child.kill().unwrap();
        child.wait().unwrap();
        lines.push(finished());
    }
    assert!(lines.is_sorted(), "finished runs were lost: {lines:?}");
    assert!(*lines.last().unwrap() >= 15 * 19, "{lines:?}");
    let said = succeed(dir.path(), &words("study study.toml --out killed --jobs 3"));
    assert_contains(&said, " of 500 runs computed in ");
    assert!(
        !said.contains("500 of 500"),
        "finished runs were repeated: {said}"
    );
    assert!(dataset(dir.path(), "killed") == whole);
    assert!(!journal.exists());

    // Most runs of a shard have a truth of their own, most of the whole study share one with
    // others.
    for part in ["1", "2", "3"] {
        let shard = format!("{part}/3");
        let study = ["study", "study.toml", "--out", "parts", "--jobs", part];
        let said = succeed(dir.path(), &[&study[..], &["--shard", &shard]].concat());
        assert_contains(&said, "This part is complete");
        assert!(!dir.path().join("parts/study.parquet").exists());
    }
    let said = succeed(dir.path(), &["study", "study.toml", "--out", "parts"]);
    assert_contains(&said, "All 500 runs are done.");
    assert!(dataset(dir.path(), "parts") == whole);
    // A finished folder stays as it is.
    let said = succeed(dir.path(), &["study", "study.toml", "--out", "parts"]);
    assert_contains(&said, "All 500 runs are done.");
    // What no shard has computed is computed.
    let second = ["study", "study.toml", "--out", "part", "--shard", "2/3"];
    succeed(dir.path(), &second);
    let said = succeed(dir.path(), &["study", "study.toml", "--out", "part"]);
    assert_contains(&said, "333 of 500 runs computed in ");
    assert!(dataset(dir.path(), "part") == whole);
    // The tables of run 3 came along.
    for folder in ["alone", "killed", "parts"] {
        let tables = dir.path().join(folder).join("tables/run-000003");
        for name in ["scene.toml", "truth.parquet", "estimate-kalman.parquet"] {
            assert!(tables.join(name).is_file(), "{folder}: {name}");
        }
        assert_eq!(
            fs::read_dir(dir.path().join(folder).join("tables"))
                .unwrap()
                .count(),
            1
        );
    }
}

/// A finished study computes nothing again. A changed study or base scene is refused, and what is
/// there stays.
#[test]
fn a_changed_study_is_refused() {
    let dir = study("[[axis]]\nkey = \"seed\"\ncount = 3\n");
    let study_of = ["study", "study.toml", "--out", "out"];
    let said = succeed(dir.path(), &study_of);
    assert_contains(&said, "3 of 3 runs computed");
    let whole = dataset(dir.path(), "out");
    assert!(succeed(dir.path(), &study_of).contains("All 3 runs are done."));
    let edits = [
        (
            "study.toml",
            "count = 3",
            "count = 4",
            "the study file has changed",
        ),
        ("scene.toml", "0.04", "0.05", "the base scene has changed"),
    ];
    for (file, old, new, reason) in edits {
        let path = dir.path().join(file);
        let before = fs::read_to_string(&path).unwrap();
        fs::write(&path, before.replace(old, new)).unwrap();
        assert_contains(refused(robhaz(dir.path()).args(study_of)), reason);
        fs::write(&path, before).unwrap();
    }
    assert!(dataset(dir.path(), "out") == whole);
    // A folder with something else is left alone.
    fs::create_dir(dir.path().join("mine")).unwrap();
    fs::write(dir.path().join("mine/notes.txt"), "mine").unwrap();
    let error = refused(robhaz(dir.path()).args(["study", "study.toml", "--out", "mine"]));
    assert_contains(error, "holds no study");
}

/// Ctrl-C ends a study in order: exit code 130, the number of finished runs, and the same command
/// goes on.
#[test]
fn an_interrupted_study_goes_on() {
    let dir = study("[[axis]]\nkey = \"seed\"\ncount = 3000\n");
    let child = robhaz(dir.path())
        .args(["study", "study.toml", "--out", "out"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let journal = dir.path().join("out/runs.jsonl");
    while fs::metadata(&journal).map_or(0, |m| m.len()) == 0 {
        std::thread::sleep(Duration::from_millis(5));
    }
    let id = child.id().to_string();
    let sent = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status();
    assert!(sent.unwrap().success());
    let output = child.wait_with_output().unwrap();
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{error}");
    assert_contains(&error, "stopped by Ctrl-C");
    assert_contains(&error, "of 3000 runs are done");
    let lines = fs::read_to_string(&journal).unwrap();
    assert!(lines.ends_with('\n') && error.contains(&format!("{} of 3000", lines.lines().count())));
}

/// A full disk (here: a limit on the size of files) ends the study with its reason and keeps the
/// finished runs.
#[test]
fn a_full_disk_keeps_finished_runs() {
    let dir = study("[[axis]]\nkey = \"seed\"\ncount = 60\n");
    let robhaz = env!("CARGO_BIN_EXE_robhaz");
    // 16 blocks of 512 or 1024 bytes: some ten lines.
    let script = format!("ulimit -f 16; exec '{robhaz}' study study.toml --out out");
    let mut shell = std::process::Command::new("sh");
    let error = refused(shell.args(["-c", &script]).current_dir(dir.path()));
    assert_contains(error, "cannot write");
    let journal = fs::read_to_string(dir.path().join("out/runs.jsonl")).unwrap();
    assert!(
        journal.lines().count() > 3 && journal.ends_with('\n'),
        "{journal}"
    );
    succeed(dir.path(), &["study", "study.toml", "--out", "out"]);
    succeed(dir.path(), &["study", "study.toml", "--out", "undisturbed"]);
    assert!(dataset(dir.path(), "out") == dataset(dir.path(), "undisturbed"));
}

/// Every mistake names file, line and key, what was found and what is allowed.
#[test]
fn mistakes_in_a_study_name_their_place() {
    let mistakes = [
        (
            "[[axis]]\nkey = \"seed\"\n",
            "study.toml:2",
            "found nothing, allowed: one of values, count",
        ),
        (
            "[[axis]]\nkey = \"seed\"\ncount = 0\n",
            "study.toml:4: axis[0].count",
            "found 0, allowed: a whole number from 1",
        ),
        (
            "[[axis]]\nkey = \"drive.speed\"\nvalues = [0.2,\n 1e9]\n",
            "study.toml:5: drive.speed",
            "found 1e9, allowed: ",
        ),
        (
            "[[axis]]\nkey = \"drive.sped\"\nvalues = [0.2]\n",
            "study.toml:3: drive.sped",
            "did you mean speed?",
        ),
        (
            "[[axis]]\nkey = \"drive.kp\"\nnormal = [-50, 1]\n[draw]\ncount = 3\n",
            "study.toml:4: drive.kp",
            "allowed: a number",
        ),
        (
            "[[axis]]\nkey = \"drive.kp\"\nuniform = [1, 2]\n",
            "study.toml:4: draw",
            "needs [draw]",
        ),
        (
            "[[axis]]\nkey = \"drive.kp\"\nuniform = [2, 1]\n[draw]\ncount = 3\n",
            "study.toml:4: axis[0].uniform",
            "low below high",
        ),
        (
            "[[axis]]\nkeys = [\"drive.kp\", \"drive.ki\"]\nvalues = [[1, 2], [3]]\n",
            "study.toml:4: axis[0].values[1]",
            "a list of 2 values",
        ),
        (
            "set = [\"drive.kp=x\"]\n[[axis]]\nkey = \"seed\"\ncount = 2\n",
            "study.toml:2: drive.kp",
            "found x, allowed: ",
        ),
        (
            "tables = [7]\n[[axis]]\nkey = \"seed\"\ncount = 2\n",
            "study.toml:2: tables",
            "found run 7, allowed: 0 to 1",
        ),
        (
            "[[axis]]\nkey = \"seed\"\ncount = 2\n[[axis]]\nkey = \"seed\"\ncount = 2\n",
            "study.toml:5: axis[1]",
            "varied by an axis above",
        ),
        (
            "set = [\"drive.kp=2\"]\n[[axis]]\nkey = \"drive.kp\"\nvalues = [1, 2]\n",
            "study.toml:2: set",
            "an axis varies drive.kp",
        ),
        (
            "[[axis]]\nkey = \"estimator\"\nvalues = [[]]\n",
            "study.toml:3: axis[0].key",
            "a key below it",
        ),
        (
            "[[axis]]\nkey = \"seed\"\ncount = 20000\n[[axis]]\nkey = \"drive.kp\"\nuniform = [1, 2]\n[draw]\ncount = 50000\n",
            "study.toml:1",
            "found 1000000000 runs, allowed: a product of the axes of at most 100000000 runs",
        ),
        (
            "[[axis]]\nkey = \"seed\"\ncount = 2\nnames = [\"a\", \"b\"]\n",
            "study.toml:5: axis[0].names",
            "has no effect without values",
        ),
        (
            "[[axis]]\nkey = \"drive.kp\"\nvalues = [1, 2]\nnames = [\"a\", \"a\"]\n",
            "study.toml:5: axis[0].names",
            "a list of 2 different texts, one a value",
        ),
        ("axes = 3\n", "study.toml:2: axes", "did you mean axis?"),
    ];
    for (axes, place, reason) in mistakes {
        let dir = study(axes);
        let error = refused(robhaz(dir.path()).args(["study", "study.toml", "--out", "out"]));
        let error = on_one_line(error.as_bytes());
        assert_contains(&error, place);
        assert_contains(&error, reason);
        assert!(!dir.path().join("out").exists());
    }
    let dir = study("[[axis]]\nkey = \"seed\"\ncount = 2\n");
    fs::remove_file(dir.path().join("scene.toml")).unwrap();
    let error = refused(robhaz(dir.path()).args(["study", "study.toml"]));
    assert_contains(&error, "study.toml:1: scene");
    assert_contains(&error, "cannot be read");
    let error = refused(robhaz(dir.path()).args(["study", "study.toml", "--shard", "3/2"]));
    assert_contains(error, "I from 1 to N");
}

/// A digit that changes in the journal of a stopped study is found by its line's checksum and said,
/// its run is computed again, and the dataset is as if nothing had happened.
#[test]
fn a_changed_digit_does_not_reach_the_dataset() {
    let dir = study("[[axis]]\nkey = \"seed\"\ncount = 4\n");
    let at = |name: &str| dir.path().join(name);
    succeed(dir.path(), &["study", "study.toml", "--out", "whole"]);
    let shard = |part: &str| {
        let arguments = ["study", "study.toml", "--shard", part, "--out", "part"];
        succeed(dir.path(), &arguments)
    };
    shard("1/2");
    let journal = at("part/runs-1-of-2.jsonl");
    let lines = fs::read_to_string(&journal).unwrap();
    // The first digit of a score.
    let place = lines.find("scores\":[").unwrap() + "scores\":[".len();
    let place = place + lines[place..].find(|c: char| c.is_ascii_digit()).unwrap();
    let mut changed = lines.into_bytes();
    changed[place] = if changed[place] == b'3' { b'4' } else { b'3' };
    fs::write(&journal, changed).unwrap();
    let said = shard("1/2");
    assert!(said.starts_with("1 of 2 runs computed"), "{said}");
    assert!(said.contains("with a wrong checksum (damaged, or of another study): 1."));
    shard("2/2");
    succeed(dir.path(), &["study", "study.toml", "--out", "part"]);
    assert!(dataset(dir.path(), "part") == dataset(dir.path(), "whole"));
}

/// More threads than a computer can start are refused with what is allowed, and a thread without a
/// run is not started.
#[test]
fn the_number_of_threads_is_bounded() {
    let dir = study("[[axis]]\nkey = \"seed\"\ncount = 3\n");
    let jobs = |jobs: &str| run(dir.path(), &["study", "study.toml", "--jobs", jobs]);
    for (count, code) in [("100000", 2), ("0", 2), ("1024", 0)] {
        let output = jobs(count);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{count}: {error}");
        assert!(code == 0 || error.contains("1..=1024"), "{error}");
        let said = text(&output.stdout);
        assert!(code == 2 || said.contains(" s on 3 threads"), "{said}");
    }
}

/// Values that are allowed alone and not together are a row with the reason, and the other runs go
/// on.
#[test]
fn a_failing_run_does_not_stop_the_others() {
    let axes = |durations: &str| {
        let key = "[[axis]]\nkey = \"record.";
        format!(
            "{key}duration\"\nvalues = {durations}\n{key}compare_from\"\nvalues = [0.02, 0.06]\n"
        )
    };
    let dir = study(&axes("[0.04, 0.08]"));
    let said = succeed(dir.path(), &["study", "study.toml", "--out", "out"]);
    assert_contains(&said, "4 of 4 runs computed");
    assert_contains(&said, "1 of them failed: see the column error.");
    // Where no run can succeed the study is refused.
    let dir = study(&axes("[0.04, 0.05]").replace("[0.02, 0.06]", "[0.06, 0.07]"));
    let error = refused(robhaz(dir.path()).args(["study", "study.toml", "--out", "out"]));
    assert_contains(error, "below record.duration");
}

/// `--dry-run` lists the runs, their simulated time and the truths that they share, also with
/// `--quiet`, and writes nothing.
#[test]
fn a_dry_run_lists_the_runs() {
    let dir = study(MANY);
    let said = succeed(dir.path(), &["study", "study.toml", "--dry-run"]);
    let words = [
        "run 0: drive.speed=0.1 drive.kp=2 drive.ki=0 seed=0 robot.mass.body=",
        "... and 480 more",
        "500 runs of 0.04 s; at least 100 simulated, the others observe one of these.",
    ];
    assert!(words.iter().all(|w| said.contains(w)), "{said}");
    let quiet = ["-q", "study", "study.toml", "--dry-run"];
    assert_eq!(succeed(dir.path(), &quiet), said);
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2);
}

/// Sensors, model errors and estimators leave the truth as it is, unless the control takes
/// readings.
#[test]
fn runs_that_differ_in_sensors_alone_share_their_truth() {
    let axis = |key: &str, values: &str| format!("[[axis]]\nkey = \"{key}\"\nvalues = {values}\n");
    let seen = [
        axis("sensors.torque_gain", "[0, 0.02]"),
        axis("model_error.link_masses", "[0, 0.1]"),
        axis("estimator.1.name", "[\"kalman\", \"true-mass\"]"),
        axis("record.compare_from", "[0.01, 0.02]"),
        axis("seed", "[1, 2, 3]"),
    ]
    .concat();
    let plan = |axes: &str, set: &str| {
        let dir = study(&format!("{set}{axes}"));
        succeed(dir.path(), &["study", "study.toml", "--dry-run"])
    };
    assert!(plan(&seen, "").contains("48 runs of 0.04 s; at least 1 simulated"));
    let speeds = axis("drive.speed", "[0.1, 0.2]");
    assert!(
        plan(&(seen.clone() + &speeds), "").contains("96 runs of 0.04 s; at least 2 simulated")
    );
    let rates = axis("sensors.rate", "[1000, 2000]");
    assert!(plan(&(seen + &rates), "").contains("96 runs of 0.04 s; at least 2 simulated"));
    let closed = "set = [\"drive.kind=shared\", \"drive.estimator=kalman\"]\n";
    let said = plan(&axis("seed", "[1, 2, 3]"), closed);
    assert_contains(&said, "3 runs of 0.04 s; each simulated.");
}

/// Options that a study file or a scene does not take are refused.
#[test]
fn options_of_the_other_kind_of_study_are_refused() {
    let dir = study("[[axis]]\nkey = \"seed\"\ncount = 2\n");
    let cases = [
        (vec!["study", "study.toml", "--ladder"], "is a study file"),
        (vec!["study", "scene.toml", "--shard", "1/2"], "--out DIR"),
    ];
    for (arguments, answer) in cases {
        let error = refused(robhaz(dir.path()).args(arguments));
        assert_contains(error.replace("\n  │ ", " "), answer);
    }
}
