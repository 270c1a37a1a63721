//! Shared by several tests: runs kept in memory, and the reference runs.

use robhaz_estimator::{Estimate, EstimateError, SensorFrame};
use robhaz_run::verify::Run;
use robhaz_run::{Frame, RunDescription, RunEnd, RunError, Sink, SinkError};
use robhaz_scene::Scene;
use robhaz_score::{Rule, Score};
use robhaz_sim::Truth;
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Arc, Mutex, OnceLock};
use tempfile::TempDir;

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A shipped scene with overrides of the form `key=value`.
pub fn scene(name: &str, overrides: &[&str]) -> Scene {
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    Scene::load(
        &root().join("scenes").join(format!("{name}.toml")),
        &overrides,
    )
    .unwrap()
}

/// The command, run in a folder.
pub fn robhaz(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_robhaz"));
    command.current_dir(folder);
    command
}

/// The output of a command that succeeds.
#[track_caller]
pub fn succeeded(command: &mut Command) -> Output {
    let output = command.output().unwrap();
    let error = text(&output.stderr);
    assert!(output.status.success(), "{command:?}: {error}");
    output
}

/// The error of a command that fails.
#[track_caller]
pub fn refused(command: &mut Command) -> String {
    let output = command.output().unwrap();
    let said = text(&output.stdout);
    assert!(!output.status.success(), "{command:?}: {said}");
    text(&output.stderr)
}

/// The words of a command line, none with a space.
pub fn words(line: &str) -> Vec<&str> {
    line.split(' ').collect()
}

/// A folder of a test's own with what `robhaz run scenes/smooth.toml` leaves in `run`, by the engine direct and
/// without recording. The command runs once for all tests with the same further arguments.
pub fn with_run(arguments: &[&str]) -> TempDir {
    type Files = Vec<(PathBuf, Vec<u8>)>;
    static RUNS: Mutex<BTreeMap<String, Arc<OnceLock<Files>>>> = Mutex::new(BTreeMap::new());
    let run = Arc::clone(RUNS.lock().unwrap().entry(arguments.join(" ")).or_default());
    let files = run.get_or_init(|| {
        let made = tempfile::tempdir().unwrap();
        let mut command = robhaz(made.path());
        command.arg("run").arg(root().join("scenes/smooth.toml"));
        command.args(["--engine", "direct", "--rerun", "off", "--out", "run"]);
        succeeded(command.args(arguments));
        let folders = ["run", "run/figures"].map(|name| made.path().join(name));
        let entries = folders.iter().flat_map(|f| std::fs::read_dir(f).unwrap());
        let paths = entries.map(|entry| entry.unwrap().path());
        let files = paths.filter(|path| path.is_file());
        let read = |path: PathBuf| {
            (
                path.strip_prefix(made.path()).unwrap().into(),
                std::fs::read(&path).unwrap(),
            )
        };
        files.map(read).collect()
    });
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(folder.path().join("run/figures")).unwrap();
    for (path, content) in files {
        std::fs::write(folder.path().join(path), content).unwrap();
    }
    folder
}

/// What cargo says of this workspace.
pub fn cargo(arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO"));
    command.args(arguments).args(["--offline", "--locked"]);
    text(&succeeded(command.current_dir(root())).stdout)
}

/// Output of the command as text.
pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Output of the command on one line, without the frame of a report, which breaks lines where the terminal would.
pub fn on_one_line(bytes: &[u8]) -> String {
    let text = text(bytes).replace(['│', '╰', '├', '─', '▶', '×'], " ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Fails with the whole text unless it has this part.
#[track_caller]
pub fn assert_contains(text: impl AsRef<str>, part: impl AsRef<str>) {
    let (text, part) = (text.as_ref(), part.as_ref());
    assert!(text.contains(part), "not there: {part}\n{text}");
}

/// The commands that a page of docs/ shows, a line each: all lines of its blocks `sh`.
pub fn page_commands(page: &str) -> Vec<String> {
    let text = std::fs::read_to_string(root().join("docs").join(page)).unwrap();
    let blocks = text.split("```sh\n").skip(1);
    blocks
        .flat_map(|rest| rest.split("```").next().unwrap().lines())
        .map(str::to_owned)
        .collect()
}

/// Writes `short.toml`, a scene of one and a half seconds.
pub fn write_short_scene(folder: &Path, extra: &str) {
    let record = "[record]\nduration = 1.5\ncompare_from = 0.5\n";
    let text = format!("[terrain]\nkind = \"flat\"\n\n{record}{extra}");
    std::fs::write(folder.join("short.toml"), text).unwrap();
}

/// A folder with that scene.
pub fn short_scene() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_short_scene(folder.path(), "");
    folder
}

/// The summary of the run or estimate in a folder.
pub fn summary(folder: &Path) -> serde_json::Value {
    let json = std::fs::read(folder.join("summary.json")).unwrap();
    serde_json::from_slice(&json).unwrap()
}

/// The truth of a whole scene at each record.
pub fn truth_of(scene: &Scene) -> Result<Vec<Truth>, RunError> {
    let run = Run::of(scene)?;
    assert_eq!(run.stopped, None, "{}", scene.name);
    Ok(run.truth)
}

/// All records of a run.
#[derive(Default)]
pub struct Kept {
    pub truth: Vec<Truth>,
    pub sensors: Vec<SensorFrame>,
    /// One list per estimator.
    pub estimates: Vec<Vec<Result<Estimate, EstimateError>>>,
}

impl Sink for Kept {
    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        self.estimates = vec![Vec::new(); run.estimators.len()];
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        self.truth.push(*frame.truth.unwrap());
        self.sensors.push(*frame.sensors);
        for (list, estimate) in self.estimates.iter_mut().zip(frame.estimates) {
            list.push(*estimate);
        }
        Ok(())
    }

    fn end(&mut self, _end: Option<&RunEnd>) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Runs a scene and keeps every record.
pub fn keep(scene: &Scene) -> Kept {
    let mut kept = Kept::default();
    robhaz_run::run(scene, &mut [&mut kept]).unwrap();
    kept
}

impl Kept {
    /// NRMSE of N of one estimator over times from `from` (s), as a fraction.
    pub fn nrmse(&self, estimator: usize, from: f64) -> f64 {
        let mut score = Score::new(Rule { compare_from: from });
        for (truth, estimate) in self.truth.iter().zip(&self.estimates[estimator]) {
            score.add(truth, estimate.as_ref().ok());
        }
        assert_eq!(score.missing, 0);
        score.nrmse().unwrap()
    }
}

/// The columns of a CSV table by name. An empty cell is a NaN.
pub fn columns(path: &Path) -> HashMap<String, Vec<f64>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let names = reader.headers().unwrap().clone();
    let mut columns: HashMap<String, Vec<f64>> = HashMap::new();
    for record in reader.records() {
        for (name, field) in names.iter().zip(record.unwrap().iter()) {
            let value = match field {
                "" => f64::NAN,
                number => number.parse().unwrap(),
            };
            columns.entry(name.to_owned()).or_default().push(value);
        }
    }
    columns
}

/// A reference run at 50 Hz: columns by name.
pub struct Reference {
    columns: HashMap<String, Vec<f64>>,
}

impl Reference {
    pub fn read(case: &str) -> Self {
        let path = root().join("tests/reference").join(format!("{case}.csv"));
        Self {
            columns: columns(&path),
        }
    }

    pub fn column(&self, name: &str) -> &[f64] {
        &self.columns[name]
    }

    /// RMS and greatest difference between a column and a run recorded at 1 kHz, over times from
    /// `from` (s).
    pub fn difference(
        &self,
        name: &str,
        from: f64,
        truth: &[Truth],
        value: impl Fn(&Truth) -> f64,
    ) -> (f64, f64) {
        let (mut square, mut greatest, mut count) = (0.0, 0.0_f64, 0.0);
        for (time, expected) in self.column("t").iter().zip(self.column(name)) {
            if *time < from {
                continue;
            }
            let at = &truth[(time * 1000.0).round() as usize];
            assert!((at.time - time).abs() < 1e-9);
            let error = value(at) - expected;
            square += error * error;
            greatest = greatest.max(error.abs());
            count += 1.0;
        }
        ((square / count).sqrt(), greatest)
    }
}
