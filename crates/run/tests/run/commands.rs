//! Commands of the wheels: from when on they act, and that every way to run the loop gives the same
//! truth.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at the first surprise"
)]

use robhaz_model::WheelCommand;
use robhaz_run::{DrivenPlant, Frame, RunDescription, RunEnd, Sink, SinkError, run};
use robhaz_scene::{ControlChoice, ControlKind, EngineKind, Grade, Scene, SensorChoice};
use robhaz_sim::{Plant, Truth};

/// A scene of a duration (s) with an engine.
fn scene(engine: EngineKind, duration: f64) -> Scene {
    let mut scene = Scene::default();
    scene.engine.kind = engine;
    scene.record.duration = duration;
    scene.record.compare_from = 0.0;
    scene
}

/// What is commanded after record `k`: the plan for half a second, then torques and set speeds in
/// turn, each held for 50 to 300 ms, and the plan between them.
fn commands(k: usize) -> [WheelCommand; 3] {
    match k {
        1200..1250 => [
            WheelCommand::Torque(1.5),
            WheelCommand::Planned,
            WheelCommand::Speed(1.0),
        ],
        1400..1700 => [WheelCommand::Torque(0.6); 3],
        1800..2000 => [WheelCommand::Speed(1.5); 3],
        _ => [WheelCommand::Planned; 3],
    }
}

/// The truth of 2.5 s under [`commands`].
fn commanded(engine: EngineKind) -> Vec<Truth> {
    let mut plant = Plant::new(&scene(engine, 2.5).plant_setup()).unwrap();
    let next = |k| {
        let truth = *plant.next_truth().unwrap();
        plant.command(commands(k));
        truth
    };
    (0..=2500).map(next).collect()
}

/// Closed form: a commanded torque is the motor torque from the next record on, and no longer than
/// it is held.
#[test]
fn a_command_acts_from_the_next_record_on() {
    for engine in EngineKind::ALL {
        let truth = commanded(engine);
        let torque = |k: usize| truth[k].wheels[0].torque;
        assert!((torque(1200) - 1.5).abs() > 0.1);
        for k in 1201..=1250 {
            assert!((torque(k) - 1.5).abs() < 1e-15, "{} {k}", engine.name());
        }
        assert!((torque(1251) - 1.5).abs() > 1e-6);
        for k in 1401..=1700 {
            assert!((torque(k) - 0.6).abs() < 1e-15, "{} {k}", engine.name());
        }
        // The drive goes on with nearly this torque: its integral has followed with 0.1 s for 0.3
        // s.
        let (before, after) = (truth[1700].wheels[0], truth[1701].wheels[0]);
        let kept = (after.torque - 5.0 * (2.0 - after.omega) - before.torque).abs();
        assert!(kept < 0.1, "{} {kept}", engine.name());
    }
}

/// Equivalence: both engines move alike under commands that jump, though `direct` steps over many
/// records while they are held.
#[test]
fn the_engines_agree_under_commands() {
    let [rapier, direct] = EngineKind::ALL.map(commanded);
    let mut square = [0.0; 2];
    for (a, b) in rapier.iter().zip(&direct) {
        for (a, b) in a.wheels.iter().zip(&b.wheels) {
            square[0] += (a.normal_force - b.normal_force).powi(2);
            square[1] += (a.traction - b.traction).powi(2);
        }
    }
    let count = 3.0 * rapier.len() as f64;
    let [normal, traction] = square.map(|sum| (sum / count).sqrt());
    // As without commands, 1e-3 of the mean load; a jump of a set speed moves T by 50 N within 20
    // ms, of which rapier's step of 0.2 ms is a hundredth.
    assert!(normal < 0.05 && traction < 0.2, "{normal} N {traction} N");
    let [a, b] = [&rapier, &direct].map(|run| run[2500].body.position);
    assert!((a - b).norm() < 1e-4, "{a} {b}");
}

/// Keeps truth and commands.
#[derive(Default)]
struct Kept {
    truth: Vec<Truth>,
    commands: Vec<Option<[WheelCommand; 3]>>,
}

impl Sink for Kept {
    fn begin(&mut self, _: &RunDescription) -> Result<(), SinkError> {
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        self.truth.extend(frame.truth);
        self.commands.push(frame.commands);
        Ok(())
    }

    fn end(&mut self, _: Option<&RunEnd>) -> Result<(), SinkError> {
        Ok(())
    }
}

/// Equivalence: a run with all estimators and sinks, and the driven plant alone, have the same
/// bits. Motor torques are those commanded one sample before. Without a control that takes readings
/// there are no commands.
#[test]
fn every_loop_gives_the_same_truth() {
    for engine in EngineKind::ALL {
        let mut scene = scene(engine, 3.0);
        scene.sensors = SensorChoice::of(Grade::Typical);
        let mut open = Kept::default();
        run(&scene, &mut [&mut open]).unwrap();
        assert!(open.commands.iter().all(Option::is_none));
        scene.control = ControlChoice {
            kind: ControlKind::Shared,
            estimator: Some("kalman-no-angles".to_owned()),
            ..ControlChoice::default()
        };
        let mut closed = Kept::default();
        run(&scene, &mut [&mut closed]).unwrap();
        assert_ne!(closed.truth, open.truth);
        let mut plant = DrivenPlant::new(&scene, &scene.plant_setup()).unwrap();
        for truth in &closed.truth {
            assert_eq!(*truth, plant.next_truth().unwrap(), "{}", engine.name());
        }
        for (commands, truth) in closed.commands.iter().zip(&closed.truth[1..]) {
            let torques = truth.wheels.map(|wheel| WheelCommand::Torque(wheel.torque));
            assert_eq!(*commands, Some(torques));
        }
    }
}
