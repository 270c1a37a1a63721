//! Faulty readings: no panic, no number that is not finite, no number without a flag, and a full
//! recovery soon after.

use proptest::prelude::*;
use robhaz_estimator::{
    Estimate, EstimateError, Estimator, EstimatorSettings, Flags, LinkReading, SensorFrame,
};
use robhaz_model::Robot;

const STEP: f64 = 1e-3;

/// Exact readings of a robot that starts from rest at time 0 and rolls on level ground at 0.2 m/s,
/// without a load.
fn clean(time: f64) -> SensorFrame {
    // Speed 2 (1 - exp(-t/T)) rad/s. Inertia of rotor and disc, and damping; the force that moves
    // the robot is left out.
    let (speed, lag) = (2.0, 0.3);
    let fade = (-time / lag).exp();
    // A torque that is constant to the bit counts as stuck.
    let ripple = 1e-9 * (1e3 * time).sin();
    let torque = 0.15 * speed * (1.0 - fade) + 0.0939 * speed * fade / lag + ripple;
    let link = LinkReading {
        inclination: Some(0.0),
        rate: Some(0.0),
        rate_error: 0.0,
    };
    SensorFrame {
        time,
        wheel_angle: [Some(speed * (time - lag * (1.0 - fade))); 3],
        motor_torque: [Some(torque); 3],
        link1: link,
        link2: link,
        contact_angle: [Some(0.0); 3],
        ..SensorFrame::default()
    }
}

/// The readings of a frame, in a fixed order.
fn readings(frame: &mut SensorFrame) -> [&mut Option<f64>; 13] {
    let [w1, w2, w3] = &mut frame.wheel_angle;
    let [t1, t2, t3] = &mut frame.motor_torque;
    let [c1, c2, c3] = &mut frame.contact_angle;
    let (l1, l2) = (&mut frame.link1, &mut frame.link2);
    [
        w1,
        w2,
        w3,
        t1,
        t2,
        t3,
        c1,
        c2,
        c3,
        &mut l1.inclination,
        &mut l1.rate,
        &mut l2.inclination,
        &mut l2.rate,
    ]
}

/// Faults of a reading.
#[derive(Clone, Copy, Debug)]
enum Fault {
    /// None.
    Good,
    /// Missing, or beyond the limits: must be flagged.
    Bad(Option<f64>),
    /// Wrong but within the limits: not detectable at once.
    Wrong(f64),
}

fn fault() -> impl Strategy<Value = Fault> {
    let absurd = prop::sample::select(vec![
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::MAX,
        -f64::MAX,
        1e12,
        -1e12,
    ]);
    prop_oneof![
        6 => Just(Fault::Good),
        2 => Just(Fault::Bad(None)),
        2 => absurd.prop_map(|v| Fault::Bad(Some(v))),
        1 => (-1.5_f64..1.5).prop_map(Fault::Wrong),
    ]
}

/// Steps of time, s.
fn step() -> impl Strategy<Value = f64> {
    let odd = prop::sample::select(vec![
        0.0,
        -1e-3,
        -10.0,
        1e-12,
        f64::MIN_POSITIVE,
        0.4,
        0.6,
        1e9,
        f64::MAX,
        -f64::MAX,
        f64::NAN,
        f64::INFINITY,
    ]);
    prop_oneof![9 => Just(STEP), 1 => odd]
}

fn faulty() -> impl Strategy<Value = Vec<(f64, [Fault; 13])>> {
    prop::collection::vec((step(), prop::array::uniform13(fault())), 1..150)
}

fn presets() -> [EstimatorSettings; 3] {
    [
        EstimatorSettings::paper_wheels(),
        EstimatorSettings::kalman(),
        EstimatorSettings::kalman_without_angles(),
    ]
}

/// Whether an estimator reads the reading number `k`: not the contact angles if they are unknown.
fn counts(settings: &EstimatorSettings, k: usize) -> bool {
    !(6..9).contains(&k) || settings.needs_contact_angles()
}

fn finite(e: &Estimate) -> bool {
    let mut numbers = vec![e.time, e.posture.body];
    numbers.extend(e.normal_force);
    numbers.extend(e.traction);
    numbers.extend(e.posture.links);
    let report = e.kalman.as_ref();
    numbers.extend(report.iter().flat_map(|k| k.covariance).flatten());
    numbers.extend(report.iter().flat_map(|k| k.angle_sigma));
    numbers.extend(
        e.pin_from_q
            .iter()
            .chain(&e.pin_force)
            .flat_map(|v| [v.x, v.y]),
    );
    numbers.extend(e.residual);
    numbers.extend(e.parity.iter().flat_map(|p| [p.value, p.sigma]));
    if let Some(errors) = report.map(|k| &k.reading_errors) {
        let pairs = errors
            .torque_offset
            .iter()
            .chain(errors.contact_angle.iter().flatten())
            .chain(&errors.rate_bias);
        numbers.extend(
            pairs
                .chain([&errors.gear_friction])
                .flat_map(|(v, s)| [*v, *s]),
        );
    }
    numbers.iter().all(|n| n.is_finite())
}

/// Variances are not negative and bound the covariances.
fn proper(covariance: &[[f64; 6]; 6]) -> bool {
    (0..6).all(|i| {
        (0..6).all(|j| {
            let bound = covariance[i][i] * covariance[j][j];
            covariance[i][j] * covariance[i][j] <= bound * (1.0 + 1e-6) + 1e-9
        }) && covariance[i][i] >= -1e-9
    })
}

/// Feeds clean frames from `from` on, `seconds` long.
fn feed(estimator: &mut Estimator, from: f64, seconds: f64) -> Option<Estimate> {
    let mut last = None;
    for k in 1..=(seconds / STEP) as u32 {
        last = estimator.update(&clean(from + STEP * f64::from(k))).ok();
    }
    last
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any frames give an error or finite numbers, and each detectable fault is flagged.
    #[test]
    fn faults_are_refused_or_flagged(frames in faulty(), warm in any::<bool>()) {
        for settings in presets() {
            let mut estimator = Estimator::new(&Robot::default_a(), settings);
            let (mut time, mut started) = (0.0, warm);
            if warm {
                feed(&mut estimator, 0.0, 0.2);
                time = 0.2;
            }
            for (step, faults) in &frames {
                let mut frame = clean(time);
                frame.time = time + step;
                let mut bad = started && !(*step > 0.0 && *step <= 0.5);
                for (k, (reading, fault)) in readings(&mut frame).into_iter().zip(faults).enumerate() {
                    match fault {
                        Fault::Good => {}
                        Fault::Bad(value) => {
                            bad |= counts(&settings, k);
                            *reading = *value;
                        }
                        Fault::Wrong(value) => *reading = Some(*value),
                    }
                }
                match estimator.update(&frame) {
                    Err(EstimateError::Time { .. }) => continue,
                    // No filter has started, so that no gap stops one.
                    Err(EstimateError::Missing { .. }) => {
                        (time, started) = (frame.time, false);
                        continue;
                    }
                    Err(_) => {}
                    Ok(estimate) => {
                        prop_assert!(finite(&estimate), "{estimate:?}");
                        if let Some(covariance) = estimate.kalman.as_ref().map(|k| &k.covariance) {
                            prop_assert!(proper(covariance), "{covariance:?}");
                        }
                        let flagged = estimate.flags.contains(Flags::SENSOR_MISSING)
                            || estimate.flags.contains(Flags::SENSOR_STALE);
                        prop_assert!(flagged || !bad, "{frame:?}");
                    }
                }
                started = true;
                if frame.time.abs() < 1e6 {
                    time = frame.time;
                }
            }
        }
    }

    /// Some time after faults (missing and implausible readings, false times) the estimator agrees
    /// with an undisturbed one: 4 s for the paper's filters, eight crossover times; for `kalman` a
    /// second beyond the parity gate before it discards its states, and three to estimate them
    /// anew. 1 N is 2 % of a wheel's load, and what an offset of 0.1 N m makes of a traction.
    #[test]
    fn it_recovers(frames in faulty()) {
        let seconds = 4.0;
        for settings in presets() {
            let mut estimator = Estimator::new(&Robot::default_a(), settings);
            feed(&mut estimator, 0.0, 1.0);
            let mut undisturbed = estimator.clone();
            let mut time = 1.0;
            for (step, faults) in &frames {
                let mut frame = clean(time + STEP);
                frame.time = time + step;
                for (reading, fault) in readings(&mut frame).into_iter().zip(faults) {
                    if let Fault::Bad(value) = fault {
                        *reading = *value;
                    }
                }
                let _ = estimator.update(&frame);
                time += STEP;
            }
            let found = feed(&mut estimator, time, seconds).expect("clean frames");
            let expected = feed(&mut undisturbed, 1.0, time - 1.0 + seconds).expect("clean frames");
            prop_assert_eq!(found.flags, Flags::NONE);
            for i in 0..3 {
                let error = found.normal_force[i] - expected.normal_force[i];
                prop_assert!(error.abs() < 1.0, "{:?} {:?}", found.normal_force, expected.normal_force);
            }
        }
    }
}

/// While a reading is missing, the stated deviations that depend on it grow from frame to frame,
/// and flags say so.
#[test]
fn missing_readings_degrade_the_covariance() {
    let mut settled = Estimator::new(&Robot::default_a(), EstimatorSettings::kalman());
    feed(&mut settled, 0.0, 2.0);
    type Sigma = fn(&Estimate) -> Option<f64>;
    // Number of the reading in `readings`, and what must grow.
    let cases: [(usize, &str, Sigma); 6] = [
        (1, "encoder", |e| e.sigma_traction(1)),
        (4, "torque", |e| e.sigma_traction(1)),
        (7, "contact angle", |e| e.sigma_normal(1)),
        (7, "contact angle", |e| {
            Some(e.kalman?.reading_errors.contact_angle?[1].1)
        }),
        (9, "inclinometer", |e| Some(e.kalman?.angle_sigma[0])),
        (10, "gyroscope", |e| Some(e.kalman?.angle_sigma[0])),
    ];
    for (missing, name, sigma) in cases {
        let (mut with, mut without) = (settled.clone(), settled.clone());
        let mut last = 0.0;
        for k in 1..=300 {
            let frame = clean(2.0 + STEP * f64::from(k));
            let mut gap = frame;
            *readings(&mut gap)[missing] = None;
            let full = with.update(&frame).expect("complete");
            let less = without.update(&gap).expect("held over");
            let (full, less_sigma) = (sigma(&full).expect("stated"), sigma(&less).expect("stated"));
            // In the first frames the angle about which the equations are linearised changes it by
            // as much, later by 1e-5 of it, and by 4.5e-3 where a mapped slope corrects that angle.
            assert!(
                k < 10 || less_sigma > full * (1.0 - 5e-3),
                "{name}, frame {k}: {less_sigma} {full}"
            );
            // The ratio to the deviation with the reading grows, too, until other readings give as
            // much as the missing one would have. A mapped slope gives it at once at each place of the
            // memory, every 49 frames: between them the deviation with the reading is up to 8 % larger.
            if k % 99 == 1 {
                let more = less_sigma / full;
                assert!(more > 0.92 * last, "{name}, frame {k}: {more} {last}");
                last = more;
            }
            assert!(less.flags.contains(Flags::SENSOR_MISSING), "{name}");
            if k != 100 {
                // At 100 rounding decides.
                let stale = less.flags.contains(Flags::SENSOR_STALE);
                assert_eq!(stale, k > 100, "{name}, frame {k}");
            }
        }
    }
}

/// A reading that is missing for hours neither makes the covariance overflow nor changes later
/// estimates.
#[test]
fn a_sensor_may_stay_away_for_long() {
    for missing in 0..13 {
        for settings in presets() {
            let mut estimator = Estimator::new(&Robot::default_a(), settings);
            feed(&mut estimator, 0.0, 0.5);
            // At 5 Hz, so that an hour takes no time.
            let frames = 18_000;
            for k in 1..=frames {
                let mut frame = clean(0.5 + 0.2 * f64::from(k));
                *readings(&mut frame)[missing] = None;
                if let Ok(estimate) = estimator.update(&frame) {
                    assert!(
                        finite(&estimate),
                        "reading {missing}, frame {k}: {estimate:?}"
                    );
                    let flagged = estimate.flags.contains(Flags::SENSOR_MISSING);
                    assert_eq!(flagged, counts(&settings, missing));
                    if let Some(covariance) = estimate.kalman.as_ref().map(|k| &k.covariance) {
                        assert!(
                            proper(covariance),
                            "reading {missing}, frame {k}: {covariance:?}"
                        );
                    }
                }
            }
            let now = 0.5 + 0.2 * f64::from(frames);
            let mut fresh = Estimator::new(&Robot::default_a(), settings);
            let expected = feed(&mut fresh, now, 2.0).expect("clean frames");
            let found = feed(&mut estimator, now, 2.0).expect("clean frames");
            assert_eq!(found.flags, Flags::NONE, "reading {missing}");
            for i in 0..3 {
                let error = found.normal_force[i] - expected.normal_force[i];
                // Of 78 errors four may lie beyond two deviations; one does, after an hour without
                // the inclination of link 1, with 2.1.
                let bound = found.sigma_normal(i).map_or(0.5, |sigma| 3.0 * sigma);
                assert!(
                    error.abs() < bound,
                    "reading {missing}: {:?} {:?}",
                    found.normal_force,
                    expected.normal_force
                );
            }
        }
    }
}

/// Clocks: a late frame is refused and changes nothing; a clock that is set back starts everything
/// anew; after one false time stamp the estimator continues.
#[test]
fn clocks_may_be_set() {
    for settings in presets() {
        let mut estimator = Estimator::new(&Robot::default_a(), settings);
        feed(&mut estimator, 100.0, 1.0);
        let before = estimator.clone();
        for late in [
            101.0,
            100.9995,
            100.6,
            f64::NAN,
            f64::INFINITY,
            101.0 + 1e-9,
        ] {
            let mut frame = clean(101.0);
            frame.time = late;
            let refused = estimator.update(&frame);
            assert!(matches!(refused, Err(EstimateError::Time { .. })), "{late}");
        }
        let mut other = before;
        assert_eq!(
            estimator.update(&clean(101.001)),
            other.update(&clean(101.001))
        );

        let mut frame = clean(101.002);
        frame.time = 1e15;
        let jumped = estimator.update(&frame).expect("complete");
        assert!(jumped.flags.contains(Flags::SENSOR_STALE));
        let back = estimator.update(&clean(101.003)).expect("complete");
        assert!(back.flags.contains(Flags::SENSOR_STALE));
        let after = feed(&mut estimator, 101.003, 0.1).expect("complete");
        assert_eq!(after.flags, Flags::NONE);
    }
}

/// Frames every microsecond are accepted, though rounding makes some of their differences smaller:
/// by 4e-16 s at 3 s, and by 5e-8 s in seconds since 1970.
#[test]
fn a_microsecond_between_frames_is_enough() {
    for settings in presets() {
        for start in [3.0, 1.7e9] {
            let mut estimator = Estimator::new(&Robot::default_a(), settings);
            let (mut last, mut shorter) = (f64::NEG_INFINITY, 0);
            for k in 0..2000 {
                let time = start + 1e-6 * f64::from(k);
                let mut frame = clean(1e-6 * f64::from(k));
                frame.time = time;
                shorter += u32::from(time - last < 1e-6);
                let estimate = estimator.update(&frame).expect("one microsecond later");
                assert!(finite(&estimate));
                last = time;
            }
            // Else the test would prove nothing.
            assert!(shorter > 100, "{shorter}");
        }
    }
}

/// Equivalence: an encoder that was reset, or whose first angle was false, is used again with the second reading from
/// the new zero; the forces are those of the encoder that was not, to what one lost reading costs.
#[test]
fn an_encoder_may_count_from_a_new_zero() {
    for settings in presets() {
        let mut estimator = Estimator::new(&Robot::default_a(), settings);
        feed(&mut estimator, 0.0, 1.0);
        let mut with_zero = estimator.clone();
        let (mut flagged, mut worst) = (0, 0.0_f64);
        for k in 1..=1000 {
            let frame = clean(1.0 + STEP * f64::from(k));
            let mut moved = frame;
            moved.wheel_angle[1] = frame.wheel_angle[1].map(|angle| angle - 5000.0);
            let expected = with_zero.update(&frame).expect("complete");
            let found = estimator.update(&moved).expect("complete");
            flagged += u32::from(found.flags != expected.flags);
            for i in 0..3 {
                worst = worst.max((found.normal_force[i] - expected.normal_force[i]).abs());
            }
        }
        assert_eq!(flagged, 2);
        assert!(worst < 2.0, "{worst}");
    }
}
