//! The table at the end of a run.

use crate::testing::finished;
use robhaz_record::{BrokenOff, EstimatorSummary, Summary, comparison_table};
use robhaz_score::{ForceErrors, Progress};
use serde_json::json;

fn summary(missing: u64) -> Summary {
    let errors = |scale: f64| ForceErrors {
        rmse: [scale, 2.0 * scale, 3.0 * scale],
        rmse_all: 2.0 * scale,
        nrmse: Some(2.0 * scale / 50.0),
        bias: [scale, -scale, 0.0],
        max_abs: 20.0 * scale,
        max_abs_time_s: 7.5,
    };
    let estimator = |scale| EstimatorSummary {
        normal_force: Some(errors(scale)),
        traction: Some(errors(0.5)),
        mean_normal_force: Some([50.0; 3]),
        samples: 90,
        missing,
        ..EstimatorSummary::default()
    };
    Summary {
        scene: "smooth".to_owned(),
        engine: Some("rapier".to_owned()),
        seed: Some(1),
        duration_s: 20.0,
        wall_s: 0.8,
        real_time_factor: 25.0,
        step_s: Some(1e-4),
        record_rate_hz: 1000.0,
        compare_from_s: 2.0,
        version: "0.1.0".to_owned(),
        progress: Some(Progress {
            distance: 3.72,
            asked: 3.78,
            stuck_since: None,
            spinning: [0.1, 0.0, 1.9],
        }),
        estimators: [("paper-body", 5.0), ("paper-wheels", 4.0)]
            .map(|(name, scale)| (name.to_owned(), estimator(scale)))
            .into(),
        ..finished()
    }
}

/// A run is one table of at most 100 columns, one line an estimator, with every number under its
/// wheel.
#[test]
fn one_run_fits_the_terminal() {
    let text = comparison_table(&[("smooth", &summary(0))]);
    for line in text.lines().filter(|l| !l.starts_with("smooth:")) {
        assert!(line.chars().count() <= 100, "{line}");
    }
    let row = text
        .lines()
        .find(|l| l.contains("paper-body"))
        .expect("a row");
    let cells: Vec<_> = row
        .split(['│', '┆'])
        .map(|c| c.split_whitespace().collect::<Vec<_>>().join(" "))
        .filter(|c| !c.is_empty())
        .collect();
    assert_eq!(
        cells,
        [
            "paper-body",
            "5.00 10.0",
            "10.00 20.0",
            "15.00 30.0",
            "10.00 20.0",
            "100.00",
            "1.00"
        ]
    );
    assert!(text.contains("25.0 times real time"), "{text}");
    assert!(!text.contains("no estimate"), "{text}");
}

/// The friction law is named where it is not the default.
#[test]
fn another_friction_law_is_named() {
    let line = |law: &str, slip_stiffness, rolling_resistance| {
        let mut summary = summary(0);
        if let Some(friction) = &mut summary.friction {
            friction.law = law.to_owned();
            let value = friction.parameters.get_mut("slip_stiffness");
            *value.expect("a parameter of the brush model") = slip_stiffness;
            friction.rolling_resistance = rolling_resistance;
        }
        comparison_table(&[("smooth", &summary)])
    };
    assert!(line("adams", None, 0.0).contains("(engine rapier, step 0.100 ms)."));
    let found = line("brush", Some(5.0), 0.02);
    let expected = "step 0.100 ms, friction brush with C = 5, rolling resistance 0.02).";
    assert!(found.contains(expected), "{found}");
    assert!(line("rigid", None, 0.0).contains("step 0.100 ms, friction rigid)."));
}

/// A run in which a bar touched the ground says so, with time and bar; one with clearance does not.
#[test]
fn a_bar_on_the_ground_is_reported() {
    let text = |first_touch: Option<(f64, &str)>| {
        let clearance = json!({
            "least_m": 0.01,
            "bar": "link2",
            "time_s": 3.0,
            "touches": 2,
            "first_touch": first_touch,
        });
        let mut summary = summary(0);
        summary.clearance = serde_json::from_value(clearance).expect("a clearance");
        comparison_table(&[("stairs", &summary)])
    };
    assert!(!text(None).contains("TOUCHED"));
    let touched = text(Some((4.25, "link2")));
    let said = "stairs: link2 TOUCHED THE GROUND at 4.25 s, body or links 2 times";
    assert!(touched.contains(said), "{touched}");
}

/// A run that is stuck or spins says so, one that travels does not.
#[test]
fn a_stuck_robot_is_reported() {
    let line = |since, spinning| {
        let mut summary = summary(0);
        summary.progress = Some(Progress {
            distance: 0.88,
            asked: 3.78,
            stuck_since: since,
            spinning,
        });
        comparison_table(&[("stairs", &summary)])
    };
    let stuck = line(Some(6.54), [13.4, 13.5, 13.5]);
    assert!(
        stuck.ends_with(
            "\nstairs: the robot is STUCK since 6.5 s: it came 0.88 m of the 3.78 m that the drive asked for; \
             the wheels spun for 13.4, 13.5 and 13.5 s (front, middle, rear)."
        ),
        "{stuck}"
    );
    let mut summary = summary(0);
    summary.progress = Some(Progress {
        distance: -0.001,
        asked: 0.58,
        stuck_since: Some(0.8),
        spinning: [2.9; 3],
    });
    let stood = comparison_table(&[("flat", &summary)]);
    assert!(stood.contains("it came 0.00 m of the 0.58 m"), "{stood}");
    let spins = line(None, [0.0, 2.5, 0.0]);
    assert!(spins.contains("spun for 0.0, 2.5 and 0.0 s"), "{spins}");
    assert!(!spins.contains("STUCK"), "{spins}");
    let travels = line(None, [0.5, 1.9, 0.0]);
    assert!(!travels.contains("spun"), "{travels}");
}

/// Several runs stand in one table, each under its label, each with its speed.
#[test]
fn several_runs_are_distinguished() {
    let (first, second) = (summary(0), summary(0));
    let text = comparison_table(&[("runs/a", &first), ("runs/b", &second)]);
    for label in ["runs/a", "runs/b"] {
        let mut rows = text.lines().filter(|l| l.contains(label));
        assert!(rows.next().is_some_and(|l| l.contains("paper-body")));
        assert!(rows.next().is_some_and(|l| l.contains("times real time")));
        assert!(rows.next().is_none());
    }
    assert_eq!(text.matches("paper-wheels").count(), 2);
}

/// A run that broke off does not pass for a complete one.
#[test]
fn a_broken_run_is_marked() {
    let mut broken = summary(0);
    broken.broken_off = Some(BrokenOff {
        reason: "stopped by Ctrl-C".to_owned(),
        time_s: 3.2,
    });
    broken.duration_s = 32.800_000_000_000_004;
    let text = comparison_table(&[("runs/a", &summary(0)), ("runs/b", &broken)]);
    assert!(!text.contains("runs/a broke off"), "{text}");
    assert!(text.contains("runs/b: 32.8 s simulated"), "{text}");
    assert!(
        text.contains("runs/b broke off at 3.200 s: stopped by Ctrl-C"),
        "{text}"
    );
}

/// Missing estimates are reported, and an estimator without any result has none in the table.
#[test]
fn missing_estimates_are_reported() {
    let mut gaps = summary(10);
    gaps.estimators[1].normal_force = None;
    gaps.estimators[1].traction = None;
    let text = comparison_table(&[("smooth", &gaps)]);
    assert!(
        text.contains("paper-body: no estimate in 10 of 100 records"),
        "{text}"
    );
    let row = text
        .lines()
        .find(|l| l.contains("paper-wheels"))
        .expect("a row");
    assert_eq!(row.matches(" - ").count(), 6, "{row}");
}
