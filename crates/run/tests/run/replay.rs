//! Equivalence: recorded readings pass through the same loop as a simulation, on one thread or
//! several, and the estimates are equal to the bit. Without this a log and a simulation could not
//! be compared.

use robhaz_estimator::{Estimate, EstimateError, GroundPoint, SensorFrame};
use robhaz_run::{
    Frame, Run, RunDescription, RunEnd, RunError, Sample, Sink, SinkError, Source, run,
};
use robhaz_scene::{Grade, Scene, SensorChoice};
use std::cell::Cell;

/// Readings in memory, without truth.
struct Log {
    samples: std::vec::IntoIter<Sample>,
    /// The file ends in the middle of a sample.
    is_torn: bool,
}

impl Source for Log {
    fn next_sample(&mut self) -> Result<Option<Sample>, RunError> {
        match self.samples.next() {
            None if self.is_torn => Err(RunError::Stopped { cause: "line 7" }),
            sample => Ok(sample),
        }
    }

    fn mean_step(&self) -> Option<f64> {
        None
    }
}

/// What a sink receives.
#[derive(Default)]
struct Kept {
    readings: Vec<(f64, SensorFrame)>,
    estimates: Vec<Vec<Result<Estimate, EstimateError>>>,
    truths: usize,
    /// The completed points of the ground of each estimator, and those of the end.
    ground: Vec<Vec<GroundPoint>>,
    ends: Vec<Option<RunEnd>>,
    /// The text of a double is different for different bits.
    clearances: Vec<String>,
    /// Time of every record that has the ground in memory, and that ground.
    memory: Vec<(f64, Vec<Vec<GroundPoint>>)>,
}

impl Sink for Kept {
    fn begin(&mut self, _: &RunDescription) -> Result<(), SinkError> {
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        self.readings.push((frame.time, *frame.sensors));
        self.estimates.push(frame.estimates.to_vec());
        self.truths += usize::from(frame.truth.is_some());
        self.ground.resize(frame.estimates.len(), Vec::new());
        for (k, points) in self.ground.iter_mut().enumerate() {
            points.extend_from_slice(frame.ground.completed(k));
        }
        self.clearances.push(format!("{:?}", frame.clearances));
        if frame.ground.has_memory() {
            let of_each = (0..frame.estimates.len()).map(|k| frame.ground.in_memory(k).to_vec());
            self.memory.push((frame.time, of_each.collect()));
        }
        Ok(())
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        // The records have had the first points of the whole.
        let wholes = end.iter().flat_map(|end| &end.ground);
        for (points, whole) in self.ground.iter_mut().zip(wholes) {
            let first = whole.get(..points.len());
            assert_eq!(format!("{first:?}"), format!("{:?}", Some(&points[..])));
            *points = whole.to_vec();
        }
        self.ends.push(end.cloned());
        Ok(())
    }
}

/// Half a second with sensor and model errors and all presets.
fn scene() -> Scene {
    let mut scene = Scene {
        sensors: SensorChoice::of(Grade::Typical),
        seed: 5,
        ..Scene::default()
    };
    scene.model_error.viscous_damping = 0.1;
    scene.model_error.pins = 0.001;
    scene.record.duration = 0.5;
    scene.record.compare_from = 0.1;
    scene
}

/// The description of a log of the scene's robot.
fn description(scene: &Scene) -> Result<RunDescription, RunError> {
    Ok(RunDescription {
        world: None,
        both: None,
        ..RunDescription::of(scene)?
    })
}

/// The records of a simulation.
fn simulated(scene: &Scene) -> Result<Kept, RunError> {
    let mut kept = Kept::default();
    run(scene, &mut [&mut kept])?;
    Ok(kept)
}

/// The readings of a simulation as a log, which may end in the middle of a line.
fn replay(kept: &Kept, is_torn: bool) -> Box<Log> {
    let sample = |(time, sensors): &(f64, SensorFrame)| Sample {
        both: None,
        time: *time,
        truth: None,
        sensors: *sensors,
        is_record: true,
    };
    let samples: Vec<Sample> = kept.readings.iter().map(sample).collect();
    Box::new(Log {
        samples: samples.into_iter(),
        is_torn,
    })
}

#[test]
fn a_replayed_run_gives_the_same_estimates_to_the_bit() -> Result<(), RunError> {
    let scene = scene();
    let simulated = simulated(&scene)?;
    let mut replayed = Kept::default();
    let source = replay(&simulated, false);
    let end = Run::of(description(&scene)?, source).until(&mut [&mut replayed], &|| None)?;

    assert_eq!(simulated.truths, 501);
    assert_eq!(replayed.truths, 0);
    assert_eq!(replayed.estimates.len(), 501);
    assert!(replayed.estimates.iter().all(|row| row.len() == 5));
    // The text of a double is different for different bits, and NaN equals NaN.
    for (a, b) in simulated.estimates.iter().zip(&replayed.estimates) {
        assert_eq!(format!("{a:?}"), format!("{b:?}"));
    }
    assert!(end.is_complete());
    assert_eq!(end.step, None);
    assert!((end.duration - 0.5).abs() < 1e-12);
    Ok(())
}

/// A simulation on several threads gives the records of one loop: readings, estimates, clearances,
/// ground, end. With fewer records than samples.
#[test]
fn a_run_on_threads_has_the_records_of_one_loop() -> Result<(), RunError> {
    let mut scene = scene();
    scene.record.duration = 2.5;
    scene.record.rate = 250.0;
    let mut one = Kept::default();
    let end = Run::new(&scene)?.until(&mut [&mut one], &|| None)?;
    let mut several = Kept::default();
    let other = Run::new(&scene)?
        .on_threads()
        .until(&mut [&mut several], &|| None)?;

    assert_eq!(several.truths, 626);
    assert_eq!(one.readings, several.readings);
    assert_eq!(one.clearances, several.clearances);
    assert_eq!(
        format!("{:?}", one.estimates),
        format!("{:?}", several.estimates)
    );
    assert_eq!(format!("{:?}", one.ground), format!("{:?}", several.ground));
    assert_eq!(format!("{:?}", end.ground), format!("{:?}", other.ground));
    assert_eq!((end.duration, end.step), (other.duration, other.step));
    // Every 0.2 s from the start, and what the estimators knew then.
    assert_eq!(several.memory.len(), 13);
    for found in &several.memory {
        let same = one
            .memory
            .iter()
            .find(|of_one| of_one.0.total_cmp(&found.0).is_eq());
        assert_eq!(format!("{:?}", same), format!("{:?}", Some(found)));
    }
    Ok(())
}

/// A source that fails keeps what came before: the sinks end with the cause.
#[test]
fn a_source_that_fails_ends_the_sinks() -> Result<(), RunError> {
    let scene = scene();
    let simulated = simulated(&scene)?;
    let mut replayed = Kept::default();
    let source = replay(&simulated, true);
    let result = Run::of(description(&scene)?, source).until(&mut [&mut replayed], &|| None);
    assert!(matches!(result, Err(RunError::Stopped { .. })));
    assert_eq!(replayed.readings.len(), 501);
    let [Some(end)] = replayed.ends.as_slice() else {
        panic!("{:?}", replayed.ends);
    };
    assert_eq!(end.broken_off.as_deref(), Some("stopped by line 7"));
    Ok(())
}

/// A run on recorded readings that is stopped has exactly the records up to there, although its
/// estimators are ahead.
#[test]
fn a_stopped_run_ends_where_it_was_stopped() -> Result<(), RunError> {
    let scene = scene();
    let simulated = simulated(&scene)?;
    let asked = Cell::new(0);
    let stop = || {
        asked.set(asked.get() + 1);
        (asked.get() > 300).then_some("the test")
    };
    let mut replayed = Kept::default();
    let source = replay(&simulated, false);
    let result = Run::of(description(&scene)?, source).until(&mut [&mut replayed], &stop);
    assert!(matches!(
        result,
        Err(RunError::Stopped { cause: "the test" })
    ));
    assert_eq!(replayed.readings, simulated.readings[..300]);
    Ok(())
}

/// The ground that the estimators find while they drive is the same, point by point.
#[test]
fn replayed_readings_give_the_same_ground() -> Result<(), RunError> {
    let mut scene = scene();
    scene.record.duration = 2.5;
    let simulated = simulated(&scene)?;
    let mut replayed = Kept::default();
    let source = replay(&simulated, false);
    Run::of(description(&scene)?, source).until(&mut [&mut replayed], &|| None)?;
    assert!(simulated.ground.iter().any(|points| !points.is_empty()));
    assert_eq!(
        format!("{:?}", simulated.ground),
        format!("{:?}", replayed.ground)
    );
    Ok(())
}

/// A source without a record is an error, and the sinks end without one.
#[test]
fn a_source_without_records_is_an_error() -> Result<(), RunError> {
    let mut kept = Kept::default();
    let source = replay(&Kept::default(), false);
    let result = Run::of(description(&scene())?, source).until(&mut [&mut kept], &|| None);
    assert!(matches!(result, Err(RunError::Empty)));
    assert_eq!(kept.ends, [None]);
    Ok(())
}
