//! Torques as drivers give them: limited and then with noise, filtered, of another size, with a dead band.

use super::common::faults::normal;
use super::common::{Failure, drive, error_of, readings_of, report, scene};
use robhaz_estimator::SensorFrame;
use robhaz_log::check::{Report, Verdict};
use robhaz_study::TruthRun;
use std::f64::consts::PI;

/// What `check` says of 100 Hz of a scene with typical sensors, with changed torques: `change` gets each torque's
/// values and its number.
fn checked(
    name: &str,
    keys: &[&str],
    change: impl Fn(&mut [f64], usize),
) -> Result<Report, Failure> {
    let (scene, mut frames) = drive(name, keys, 11)?;
    for i in 0..3 {
        let value = |frame: &SensorFrame| frame.motor_torque[i].unwrap_or(f64::NAN);
        let mut values: Vec<f64> = frames.iter().map(value).collect();
        change(&mut values, i);
        for (frame, value) in frames.iter_mut().zip(values) {
            frame.motor_torque[i] = Some(value);
        }
    }
    report(&scene, &frames)
}

/// The faults, one in a line.
fn faults(report: &Report) -> Vec<String> {
    let line = |f: &robhaz_log::check::Finding| format!("{} {}: {}", f.test, f.channel, f.figure);
    report.faults().map(line).collect()
}

/// A first-order low pass of this time constant, in readings.
fn filter(values: &mut [f64], readings: f64) {
    let share = -(-1.0 / readings).exp_m1();
    let mut passed = values[0];
    for value in values {
        passed += share * (*value - passed);
        *value = passed;
    }
}

/// A current that is cut off at 1.5 and 2.5 N m, with noise after it or behind a filter of 50 ms, is named; where the
/// drive itself has this limit, what is read acts, and nothing is wrong.
#[test]
fn a_noisy_limit_is_the_drives_or_a_fault() -> Result<(), Failure> {
    for name in ["smooth", "sine"] {
        for limit in [1.5, 2.5] {
            for sigma in [0.02, 0.1] {
                let found = checked(name, &[], |torque, _| {
                    let mut random = normal();
                    torque
                        .iter_mut()
                        .for_each(|x| *x = x.clamp(-limit, limit) + sigma * random());
                })?;
                let is_named = found
                    .faults()
                    .any(|f| f.test == "limit" && f.channel.contains("torque 1"));
                // What is cut off of the waves is little: 3 N m at most.
                assert!(
                    is_named || name == "sine" && limit > 2.0,
                    "{name} {limit} {sigma}: {:?}",
                    faults(&found)
                );
            }
            let key = format!("drive.torque_limit={limit}");
            let own = checked(name, &[&key], |_, _| {})?;
            assert!(
                own.faults().next().is_none(),
                "{name} {limit}: {:?}",
                faults(&own)
            );
        }
        let filtered = checked(name, &[], |torque, _| {
            torque.iter_mut().for_each(|x| *x = x.clamp(-1.5, 1.5));
            filter(torque, 5.0);
        })?;
        // Behind the filter the torques are late, too, which moves what the equations leave.
        let is_named = |f: &&robhaz_log::check::Finding| ["limit", "delay"].contains(&f.test);
        assert!(
            filtered.faults().any(|f| is_named(&f)),
            "{name}: {:?}",
            faults(&filtered)
        );
    }
    Ok(())
}

/// Low passes of 50 to 200 ms, a mean of 300 ms and a delay of 200 ms: the lag is found within a fifth of it, also where
/// a low pass leaves the integral part of the control alone (95 ms). With that offset no delay is left.
#[test]
fn a_filter_of_the_current_is_measured() -> Result<(), Failure> {
    let mean = |torque: &mut [f64]| {
        let before = torque.to_vec();
        for (k, x) in torque.iter_mut().enumerate() {
            let from = &before[k.saturating_sub(29)..=k];
            *x = from.iter().sum::<f64>() / from.len() as f64;
        }
    };
    let late = |torque: &mut [f64]| {
        torque.copy_within(..torque.len() - 20, 20);
    };
    type OfDriver<'a> = &'a dyn Fn(&mut [f64]);
    let cases: [(f64, OfDriver<'_>); 5] = [
        (0.045, &|torque| filter(torque, 5.0)),
        (0.09, &|torque| filter(torque, 9.5)),
        (0.195, &|torque| filter(torque, 20.0)),
        (0.145, &mean),
        (0.2, &late),
    ];
    for name in ["smooth", "flat"] {
        for (lag, change) in cases {
            let found = checked(name, &[], |torque, _| change(torque))?;
            let mut delays = found.faults().filter(|f| f.test == "delay");
            let delay = delays.next().and_then(|f| f.numbers.first());
            let delay = delay
                .ok_or_else(|| format!("{name} {lag}: {:?}", faults(&found)))?
                .value;
            assert!((delay / lag - 1.0).abs() < 0.2, "{name} {lag}: {delay}");
            let earlier = (100.0 * delay).round() as usize;
            let mended = checked(name, &[], |torque, _| {
                change(torque);
                torque.copy_within(earlier.., 0);
            })?;
            assert!(
                mended.faults().all(|f| f.test != "delay"),
                "{name} {lag}: {:?}",
                faults(&mended)
            );
        }
    }
    Ok(())
}

/// All torques of 1.6 or 0.6 of their size show in the start on level ground; one of half its size shows against the
/// others. Honest ones are right, by 10 %.
#[test]
fn the_size_of_torques_shows() -> Result<(), Failure> {
    for name in ["smooth", "sine", "course", "flat"] {
        for (factor, is_other) in [(1.0, false), (1.6, true), (0.6, true)] {
            let found = checked(name, &[], |torque, _| {
                torque.iter_mut().for_each(|x| *x *= factor)
            })?;
            let of_start = found
                .findings
                .iter()
                .find(|f| f.test == "size at the start");
            let of_start = of_start.ok_or_else(|| format!("{name} {factor}"))?;
            let size = of_start.numbers[0].value;
            assert!((size / factor - 1.0).abs() < 0.1, "{name} {factor}: {size}");
            let is_fault = of_start.verdict == Verdict::Fault;
            assert_eq!(is_fault, is_other, "{name} {factor}");
        }
        for (wheel, factor) in [(1, 0.5), (0, 2.0)] {
            let found = checked(name, &[], |torque, i| {
                let factor = if i == wheel { factor } else { 1.0 };
                torque.iter_mut().for_each(|x| *x *= factor);
            })?;
            let named = format!("torque {}", wheel + 1);
            let mut of_one = found.faults().filter(|f| f.test == "size of one");
            // On level ground the torques do not differ.
            let is_named = of_one.any(|f| f.channel == named);
            assert_eq!(
                is_named,
                name != "flat",
                "{name} {factor}: {:?}",
                faults(&found)
            );
        }
    }
    Ok(())
}

/// A dead band that takes 0.3 N m off what is beyond it, and zeros of all torques that are off by 0.72 N m, of which each
/// alone may be friction: both are named.
#[test]
fn a_dead_band_and_a_common_offset_are_named() -> Result<(), Failure> {
    let soft = checked("smooth", &[], |torque, _| {
        torque
            .iter_mut()
            .for_each(|x| *x = x.signum() * (x.abs() - 0.3).max(0.0));
    })?;
    let named = soft
        .faults()
        .filter(|f| f.test == "signed" && f.figure.contains("a dead band"));
    assert_eq!(named.count(), 3, "{:?}", faults(&soft));
    let off = checked("smooth", &[], |torque, _| {
        torque.iter_mut().for_each(|x| *x += 0.72)
    })?;
    let mut zeros = off.faults().filter(|f| f.test == "zero at rest");
    assert!(
        zeros.any(|f| f.channel == "torques 1 to 3"),
        "{:?}",
        faults(&off)
    );
    Ok(())
}

/// Gears of an efficiency of 0.7: torques that are read before them drive a wheel with less than that, and brake
/// it with more. N errs by 7 to 9 %; `check` names the efficiency, and stated it leaves N as exact as without gears, and
/// no fault. Of readings behind the gears none is named.
#[test]
fn gears_that_lose_torque_are_named() -> Result<(), Failure> {
    for name in ["smooth", "sine"] {
        let scene = scene(name, &["sensors.grade=typical"])?;
        let truth = TruthRun::of(&scene)?;
        let samples: Vec<_> = truth.samples().step_by(10).collect();
        let behind = readings_of(&scene, samples.iter().copied(), 31);
        let mut settings =
            scene.nominal_settings(scene.estimators.last().ok_or("no estimator")?)?;
        let ([exact, _], _) = error_of(&scene, &samples, &behind, settings)?;
        for efficiency in [1.0, 0.7] {
            let mut before = behind.clone();
            for torque in before.iter_mut().flat_map(|frame| &mut frame.motor_torque) {
                // The robot drives forward.
                *torque = torque.map(|t| {
                    t * if t < 0.0 {
                        efficiency
                    } else {
                        1.0 / efficiency
                    }
                });
            }
            let said = faults(&report(&scene, &before)?);
            let is_named = |line: &String| {
                line.contains("efficiency of the gears")
                    && line.contains(&format!("of {efficiency:.1};"))
            };
            assert_eq!(
                said.iter().any(is_named),
                efficiency < 1.0,
                "{name} {efficiency}: {said:?}"
            );
            settings.gear_efficiency = 1.0;
            let ([wrong, _], _) = error_of(&scene, &samples, &before, settings)?;
            settings.gear_efficiency = efficiency;
            let ([right, _], _) = error_of(&scene, &samples, &before, settings)?;
            println!("{name} {efficiency}: {wrong:.4} {right:.4} of {exact:.4}; {said:?}");
            assert!(right < 1.1 * exact && (efficiency > 0.9 || wrong > 2.0 * exact));
        }
    }
    Ok(())
}

/// The size with the sign of the speed, of which each torque alone has few readings near zero: all turn back at zero and
/// never go on, at 200 and at 100 Hz. Signed ones do.
#[test]
fn a_torque_that_turns_back_at_zero_has_lost_its_sign() -> Result<(), Failure> {
    let scene = scene("sine", &["sensors.grade=typical"])?;
    let truth = TruthRun::of(&scene)?;
    let named = |frames: &[SensorFrame]| -> Result<usize, Failure> {
        let report = report(&scene, frames)?;
        let faults = report.faults().filter(|f| f.test == "signed");
        Ok(faults.filter(|f| f.figure.contains("turns back")).count())
    };
    for stride in [5, 10] {
        let signed = readings_of(&scene, truth.samples().step_by(stride), 11);
        let mut sizes = signed.clone();
        for (k, frame) in sizes.iter_mut().enumerate() {
            // At rest the speed has either sign, later it is forward.
            let sign = if frame.time < 0.8 && k % 2 == 0 {
                -1.0
            } else {
                1.0
            };
            for torque in &mut frame.motor_torque {
                *torque = torque.map(|torque| sign * torque.abs());
            }
        }
        assert_eq!((named(&sizes)?, named(&signed)?), (3, 0), "{stride}");
    }
    Ok(())
}

/// Torques in mN m are one fault, and neither a zero nor a noise of theirs.
#[test]
fn a_unit_of_the_torques_is_one_fault() -> Result<(), Failure> {
    let found = checked("smooth", &[], |torque, _| {
        torque.iter_mut().for_each(|x| *x *= 1e3);
    })?;
    let tests: Vec<&str> = found.faults().map(|f| f.test).collect();
    assert_eq!(tests, ["sign at the start"], "{:?}", faults(&found));
    Ok(())
}

/// Links that show noise alone over waves, as an IMU does whose y axis points forward: where the readings contradict each
/// other, the axes are named.
#[test]
fn an_imu_that_sees_the_turns_on_another_axis_is_named() -> Result<(), Failure> {
    let (scene, mut frames) = drive("sine", &[], 11)?;
    let mut random = normal();
    for frame in &mut frames {
        for link in [&mut frame.link1, &mut frame.link2] {
            for reading in [&mut link.inclination, &mut link.rate] {
                *reading = Some(0.1_f64.to_radians() * random());
            }
        }
    }
    let found = report(&scene, &frames)?;
    let mut remedies = found.faults().filter_map(|f| f.remedy.as_deref());
    let is_named = remedies.any(|r| r.contains("state `forward` and `up` of its [imu]"));
    assert!(is_named, "{:?}", faults(&found));
    Ok(())
}

/// Torques that count what drives as positive, on a way forth and back over waves: named, and with it no other cause.
/// With the direction of the wheel nothing is wrong.
#[test]
fn torques_of_the_direction_of_travel_are_named() -> Result<(), Failure> {
    let back = "drive.scaling=[{wheels=[1,2,3],from=9,to=60,factor=-1}]";
    let (scene, honest) = drive("sine", &[back], 11)?;
    let mut directed = honest.clone();
    for frame in directed.iter_mut().filter(|frame| frame.time > 9.3) {
        for torque in &mut frame.motor_torque {
            *torque = torque.map(|torque| -torque);
        }
    }
    let found = faults(&report(&scene, &directed)?);
    assert!(
        found.len() == 1 && found[0].starts_with("sign on the way back"),
        "{found:?}"
    );
    let none = faults(&report(&scene, &honest)?);
    assert!(none.is_empty(), "{none:?}");
    Ok(())
}

/// A gyroscope that is off by 0.05 rad/s in a log without a rest, so that the torques seem to fit a robot of less than no
/// mass: its zero is named, and no scale of the torques.
#[test]
fn a_zero_is_no_scale_of_the_torques() -> Result<(), Failure> {
    let (scene, mut frames) = drive("sine", &[], 11)?;
    frames.retain(|frame| frame.time > 3.0);
    let none = faults(&report(&scene, &frames)?);
    assert!(none.is_empty(), "{none:?}");
    for frame in &mut frames {
        frame.link1.rate = frame.link1.rate.map(|rate| rate + 0.05);
    }
    let report = report(&scene, &frames)?;
    let mut zeros = report.faults().filter(|f| f.test == "zero while driving");
    let zero = zeros
        .next()
        .ok_or_else(|| format!("{:?}", faults(&report)))?;
    // 2.86 deg/s.
    assert!(
        (zero.numbers[0].value / 2.865 - 1.0).abs() < 0.03,
        "{zero:?}"
    );
    let mut remedies = report.faults().filter_map(|f| f.remedy.as_deref());
    assert!(!remedies.any(|r| r.contains("of the three torques by")));
    Ok(())
}

/// Torques of 1.6 times their size in starts that show it less surely: not called right.
#[test]
fn a_size_beyond_what_is_right_is_not_called_so() -> Result<(), Failure> {
    let found = checked("sine", &[], |torque, _| {
        torque.iter_mut().for_each(|x| *x *= 1.42);
    })?;
    let size = found
        .findings
        .iter()
        .find(|f| f.test == "size at the start");
    let size = size.ok_or("no start")?;
    let is_beyond = size.numbers[0].value > 1.4;
    assert_eq!(is_beyond, size.verdict != Verdict::Ok, "{size:?}");
    assert!(is_beyond, "{size:?}");
    Ok(())
}

/// Torques that the other side of a robot pushes against, to and fro, contradict those of a robot in the plane: that it
/// may have another side is named.
#[test]
fn a_push_of_the_other_side_is_named() -> Result<(), Failure> {
    let push = |k: usize| {
        let time = 0.01 * k as f64 - 2.0;
        if time > 0.0 {
            (0.2 * PI * time).sin()
        } else {
            0.0
        }
    };
    let found = checked("sine", &[], |torque, _| {
        let pushed = torque.iter_mut().enumerate();
        pushed.for_each(|(k, torque)| *torque += push(k));
    })?;
    let mut remedies = found.faults().filter_map(|f| f.remedy.as_deref());
    let is_named = remedies.any(|r| r.contains("state sides = \"one of two\""));
    assert!(is_named, "{:?}", faults(&found));
    Ok(())
}

/// Negative torques that are read as unsigned numbers of 16 bits are one fault a torque, and none of what follows from
/// them is one.
#[test]
fn nothing_is_made_of_torques_without_their_signs() -> Result<(), Failure> {
    let changes: [fn(f64) -> f64; 2] = [|x| (1e3 * x).round().rem_euclid(65536.0) / 1e3, f64::abs];
    for change in changes {
        let found = checked("sine", &[], |torque, _| {
            torque.iter_mut().for_each(|x| *x = change(*x));
        })?;
        let tests: Vec<&str> = found.faults().map(|f| f.test).collect();
        assert_eq!(tests, ["signed"; 3], "{:?}", faults(&found));
    }
    Ok(())
}
