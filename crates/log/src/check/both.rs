//! Both sides of a rover: exchanges of left and right, and the signs of what lies across.
//!
//! Each side goes through the tests of one side. What these cannot show, the estimator of both sides
//! does: it runs with left and right exchanged, or a sign turned, and the case whose innovations and
//! misfit are least fits best. Roll and yaw also show directly, against their rates and the wheels.

use crate::check::check;
use crate::check::report::{Finding, Verdict};
use crate::check::stated::{BodyNoise, Stated};
use robhaz_estimator::whole::{WholeEstimator, WholeFrame};
use robhaz_estimator::{DRIVING_SPEED, EstimatorSettings, LinkReading, SensorFrame};
use robhaz_model::{BodyMount, BodyReading, Coupling, PathAngle, Suspension, Units, WholeRover};
use robhaz_score::signals::{derivative, fit, high_pass, median, smooth};

const TEST: &str = "left and right";
/// Sum over that of the log as wired below which another case is a fault.
const BETTER: f64 = 0.8;
/// The same of pins and coupling, with the misfit's.
const BETTER_OF_JOINTS: f64 = 0.97;
/// Misfit over that of the log as wired of such a case.
const BETTER_MISFIT: f64 = 0.75;
/// Sum over the least one up to which a case fits as well.
const AS_WELL: f64 = 1.05;
/// Share of the frames from which on wheels are mostly dragged across.
const MOSTLY: f64 = 0.3;
/// Correlation that shows a sign.
const CORRELATED: f64 = 0.5;
/// Time over which speeds and torques are averaged, s.
const SMOOTHING: f64 = 0.1;
/// Time over which set speeds and slopes do not change, s.
const SLOWLY: f64 = 0.5;
/// Share of the torques' differences that a speed control explains.
const EXPLAINED: f64 = 0.5;
/// Turn from which on a drive is none straight on, rad.
const STRAIGHT: f64 = 0.17;
/// Tests of one side that take it for one that drives straight on.
const STRAIGHT_ON: [&str; 5] = [
    "sign and counts",
    "acceleration",
    "links on the ground",
    "distance",
    "wiring of wheels",
];
/// Sum of a frame without an estimate: far above that of any contradiction.
const REFUSED: f64 = 1e3;
/// Longest part of a log for which the cases are tried, s: some metres.
const LONGEST: f64 = 16.0;
/// Turn of the body that shows a sign, rad.
const LEAST_TURN: f64 = 0.03;
/// Tests of one side that the estimator of both sides answers, or that are not of a side.
const OF_BOTH: [&str; 4] = [
    "sides",
    "agreement of all",
    "wheels and links",
    "scale of torques, mass",
];

/// What is stated of a log of both sides.
#[derive(Clone, Copy, Debug)]
pub struct StatedBoth<'a> {
    /// The nominal rover.
    pub rover: &'a WholeRover,
    /// Settings of its estimator.
    pub settings: EstimatorSettings,
    /// White noise and constant error of the angles of the joints, rad.
    pub joint: [f64; 2],
}

/// Checks the frames of a log of both sides, in order of time.
pub fn check_both(frames: &[WholeFrame], stated: &StatedBoth<'_>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (side, name) in ["left", "right"].into_iter().enumerate() {
        findings.extend(of_side(frames, stated, side, name));
    }
    // In a turn the set speeds differ.
    let is_straight = turn(frames) < STRAIGHT;
    let follows = [0, 1, 2].map(|i| torque_follows(frames, i).filter(|_| is_straight));
    let torques = torques(follows);
    if torques.verdict == Verdict::Fault {
        // A side by itself would look for the cause in itself.
        findings.retain(|f| f.test != "wiring of wheels");
    }
    findings.push(torques);
    findings.push(roll(frames));
    findings.push(yaw(frames, stated.rover));
    findings.extend(exchanges(frames, stated, follows));
    findings
}

/// The tests of one side, whose links' readings are made of those of the body and the joints.
fn of_side(
    frames: &[WholeFrame],
    stated: &StatedBoth<'_>,
    side: usize,
    name: &str,
) -> Vec<Finding> {
    let (rover, budget) = (stated.rover, stated.settings.budget);
    let geometry = &rover.side.geometry;
    let mut mount = BodyMount::new(geometry, stated.joint[0]).keeping_jumps();
    let bogie_first =
        matches!(geometry.suspension, Suspension::Bogie { body } if body.index() == 1);
    let sign = if side == 0 { 1.0 } else { -1.0 };
    let mut coupling = PathAngle::<6>::new(geometry.wheel_radius, stated.joint[0]);
    let of_frame = |frame: &WholeFrame| {
        let angle = coupling.update(frame.time, frame.coupling, &frame.wheel_angle);
        // A rear bogie does not turn the rockers.
        let turned = match rover.coupling {
            Coupling::Differential => angle.map(|(angle, rate)| (sign * angle, sign * rate)),
            Coupling::RearBogie => Some((0.0, 0.0)),
        };
        let wheels = |of: &[Option<f64>; 6]| [0, 1, 2].map(|i| of[3 * side + i]);
        let [_, rate, _] = frame.rates;
        let links = mount.links(
            frame.time,
            &BodyReading {
                inclination: frame
                    .inclination
                    .zip(turned)
                    .map(|(body, (angle, _))| body + angle),
                rate: rate.zip(turned).map(|(body, (_, rate))| body + rate),
                pin: frame.pins[side].map(|pin| if bogie_first { pin } else { -pin }),
                wheels: wheels(&frame.wheel_angle),
            },
        );
        let [link1, link2] = LinkReading::of(&links);
        SensorFrame {
            time: frame.time,
            wheel_angle: wheels(&frame.wheel_angle),
            motor_torque: wheels(&frame.motor_torque),
            link1,
            link2,
            contact_angle: [None; 3],
        }
    };
    let of_side: Vec<SensorFrame> = frames.iter().map(of_frame).collect();
    let stated_side = Stated {
        robot: &rover.side,
        budget: budget.of_body_sensors(&rover.side, stated.joint),
        viscous_damping: stated.settings.viscous_damping,
        compression: stated.settings.compression,
        sides: stated.settings.sides,
        body: Some(BodyNoise {
            inclination: budget.inclination_noise,
            rate: budget.rate_noise,
            pin: stated.joint[0],
        }),
    };
    let mut findings = check(&of_side, &stated_side).findings;
    let turned = turn(frames);
    // The body's inclination follows both sides, and a delay of one side's ground is none of it.
    let is_of_body = |f: &Finding| f.test == "delay" && f.channel.contains("body_inclination");
    findings.retain(|f| !OF_BOTH.contains(&f.test) && !is_of_body(f));
    if turned > STRAIGHT {
        findings.retain(|f| !STRAIGHT_ON.contains(&f.test));
        let figure = format!("turned by {:.0} deg", turned.to_degrees());
        let remedy = "record a drive straight on, too: in a turn wheels of a side pass other ground at other speeds";
        findings.push(Finding::ok("wheels of a side", "all", figure).cannot_tell(remedy));
    }
    for finding in &mut findings {
        finding.channel = format!("{name}: {}", finding.channel);
    }
    findings
}

/// Size of the yaw over a log, rad.
fn turn(frames: &[WholeFrame]) -> f64 {
    let steps = frames.windows(2).filter_map(|w| {
        let [_, _, rate] = w[0].rates;
        Some(rate? * (w[1].time - w[0].time))
    });
    steps.sum::<f64>().abs()
}

/// The sign of the roll against its rate: changes over a tenth of a second.
fn roll(frames: &[WholeFrame]) -> Finding {
    let readings = frames
        .iter()
        .filter_map(|f| Some((f.time, f.roll?, f.rates[0]?)));
    let (mut turned, mut angle, mut products, mut squares) = (0.0, Vec::new(), 0.0, 0.0);
    let mut last: Option<(f64, f64)> = None;
    for (time, roll, rate) in readings {
        if let Some((before, old)) = last.replace((time, rate)) {
            turned += 0.5 * (old + rate) * (time - before);
        }
        angle.push((time, roll, turned));
    }
    // Twice the step of the filter of a gyroscope's drift: slow drifts cancel.
    let step = angle.partition_point(|(t, ..)| *t < angle.first().map_or(0.0, |a| a.0) + 0.5);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (a, b) in angle.iter().zip(angle.iter().skip(step.max(1))) {
        let (by_roll, by_rate) = (b.1 - a.1, b.2 - a.2);
        products += by_roll * by_rate;
        squares += by_rate * by_rate;
        (low, high) = (low.min(by_rate), high.max(by_rate));
    }
    let (test, channel) = ("roll and its rate", "body_roll, body_roll_rate");
    let range = high - low;
    if range.is_nan() || range < LEAST_TURN {
        let figure = "the body rolls by less than 2 deg in half a second";
        let remedy = "drive over bumps under one side, or lift one side by hand, while recording";
        return Finding::ok(test, channel, figure).cannot_tell(remedy);
    }
    let ratio = products / squares;
    let figure = format!("the roll changes {ratio:.2} times as its rate says");
    let finding = Finding::ok(test, channel, figure).with("ratio", ratio, "-");
    match ratio {
        ratio if ratio < 0.0 => finding.fault(
            "turn the sign of body_roll or of body_roll_rate: lift the left side by hand, then both must be positive",
        ),
        ratio if !(0.7..=1.4).contains(&ratio) => finding.fault("check the units of both"),
        _ => finding,
    }
}

/// The sign of the yaw rate against the wheels: in a turn to the left the right ones are faster.
fn yaw(frames: &[WholeFrame], rover: &WholeRover) -> Finding {
    let radius = rover.side.geometry.wheel_radius;
    let track: f64 = rover.half_tracks.iter().sum::<f64>() / 3.0;
    let (mut products, mut squares, mut turned, mut last) = (0.0, 0.0, 0.0_f64, None);
    for frame in frames {
        let sum = |side: usize| {
            let wheels = frame.wheel_angle[3 * side..][..3].iter();
            wheels.copied().sum::<Option<f64>>()
        };
        let (Some(left), Some(right), [.., Some(rate)]) = (sum(0), sum(1), frame.rates) else {
            continue;
        };
        let faster = radius * (right - left) / (6.0 * track);
        if let Some((time, before)) = last.replace((frame.time, faster)) {
            let by_gyro: f64 = rate * (frame.time - time);
            products += by_gyro * (faster - before);
            squares += by_gyro * by_gyro;
            turned += by_gyro;
        }
    }
    let (test, channel) = ("yaw and wheels", "body_yaw_rate");
    if turned.abs() < 10.0 * LEAST_TURN {
        let figure = format!("turned by {:.1} deg", turned.to_degrees());
        let remedy = "drive a turn of 20 deg or more";
        return Finding::ok(test, channel, figure).cannot_tell(remedy);
    }
    let ratio = products / squares;
    let figure = format!(
        "turned by {:.0} deg; the wheels {ratio:.2} times as much, in a skid turn more than 1",
        turned.to_degrees()
    );
    let finding = Finding::ok(test, channel, figure).with("ratio", ratio, "-");
    match ratio < 0.0 {
        true => finding.fault(
            "turn the sign of body_yaw_rate, to the left positive; or left and right wheels are exchanged",
        ),
        false => finding,
    }
}

/// What may be exchanged, or turned.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Case {
    angles: [bool; 3],
    torques: [bool; 3],
    pins: bool,
    coupling: bool,
    roll: bool,
}

impl Case {
    /// As wired, then all others, those with fewer changes first.
    fn all() -> Vec<Self> {
        let mut all = vec![Self::default()];
        let of = |i: usize| [0, 1, 2].map(|k| k == i);
        for i in 0..3 {
            let (angles, torques) = (of(i), of(i));
            all.push(Self {
                torques,
                ..Self::default()
            });
            all.push(Self {
                angles,
                ..Self::default()
            });
            all.push(Self {
                angles,
                torques,
                ..Self::default()
            });
        }
        all.push(Self {
            pins: true,
            ..Self::default()
        });
        all.push(Self {
            coupling: true,
            ..Self::default()
        });
        all.push(Self {
            roll: true,
            ..Self::default()
        });
        let (angles, torques) = ([true; 3], [true; 3]);
        all.push(Self {
            torques,
            ..Self::default()
        });
        all.push(Self {
            angles,
            ..Self::default()
        });
        all.push(Self {
            angles,
            torques,
            ..Self::default()
        });
        all.push(Self {
            angles,
            torques,
            pins: true,
            ..Self::default()
        });
        all
    }

    fn of(&self, frame: &WholeFrame) -> WholeFrame {
        let mut wired = *frame;
        for i in 0..3 {
            if self.angles[i] {
                wired.wheel_angle.swap(i, i + 3);
            }
            if self.torques[i] {
                wired.motor_torque.swap(i, i + 3);
            }
        }
        if self.pins {
            wired.pins.swap(0, 1);
        }
        if self.coupling {
            wired.coupling = wired.coupling.map(|angle| -angle);
        }
        if self.roll {
            wired.roll = wired.roll.map(|roll| -roll);
            wired.rates[0] = wired.rates[0].map(|rate| -rate);
        }
        wired
    }

    /// Whether each torque then answers its own encoder.
    fn fits(&self, follows: [Option<bool>; 3]) -> bool {
        let is_one = |i: usize| self.angles[i] != self.torques[i];
        (0..3).all(|i| follows[i].is_none_or(|follows| follows != is_one(i)))
    }

    /// Whether it is of pins and coupling, or of everything.
    fn is_of_joints(&self) -> bool {
        self.pins || self.coupling
    }

    /// What to do, in words.
    fn words(&self, coupling: Coupling) -> String {
        let mut parts = Vec::new();
        for (wheels, name) in [(self.angles, "angle"), (self.torques, "motor_torque")] {
            for i in (1..=3).filter(|i| wheels[i - 1]) {
                parts.push(format!(
                    "exchange the columns of left_wheel{i}_{name} and right_wheel{i}_{name}"
                ));
            }
        }
        if self.pins {
            parts.push("exchange the columns of left_pin_angle and right_pin_angle".to_owned());
        }
        if self.coupling {
            let name = match coupling {
                Coupling::Differential => "differential_angle",
                Coupling::RearBogie => "rear_bogie_angle",
            };
            parts.push(format!("turn the sign of {name}"));
        }
        if self.roll {
            parts.push("turn the signs of body_roll and body_roll_rate".to_owned());
        }
        parts.join("; ")
    }
}

/// The part of a log from a second before the wheels turn.
fn part<'a>(frames: &'a [WholeFrame], rover: &WholeRover) -> &'a [WholeFrame] {
    let least = DRIVING_SPEED * Units::of(&rover.side).speed() / rover.side.geometry.wheel_radius;
    let start = frames.first().map_or([None; 6], |f| f.wheel_angle);
    let moves = |f: &WholeFrame| {
        let turns = f.wheel_angle.iter().zip(start);
        let mut turns = turns.filter_map(|(a, b)| Some((*a)? - b?));
        turns.any(|turn| turn.abs() > 0.1_f64.max(least))
    };
    let from = frames
        .iter()
        .find(|f| moves(f))
        .map_or(0.0, |f| f.time - 1.0);
    let begin = frames.partition_point(|f| f.time < from);
    let end = frames.partition_point(|f| f.time < from + LONGEST);
    &frames[begin..end.max(begin)]
}

/// What the estimator of both sides says of a log that is wired as a case.
#[derive(Clone, Copy, Debug, Default)]
struct Judgement {
    /// Mean over the frames of the sum of all mean NIS of both sides and a third of the misfit.
    sum: f64,
    /// The misfit's part of it.
    misfit: f64,
    /// Share of the frames in which wheels are dragged across.
    dragged: f64,
    /// Sums over the frames of the squares of the roll rate and of that which the ground under both
    /// sides asks for, and of their product, rad^2/s^2.
    roll: [f64; 3],
}

impl Judgement {
    fn of(frames: &[WholeFrame], stated: &StatedBoth<'_>, case: &Case) -> Self {
        let refused = Self {
            sum: REFUSED,
            ..Self::default()
        };
        let estimator = WholeEstimator::new(stated.rover, stated.settings, stated.joint);
        let (Ok(mut estimator), false) = (estimator, frames.is_empty()) else {
            return refused;
        };
        let side = &stated.rover.side;
        let track: f64 = stated.rover.half_tracks.iter().sum::<f64>() / 3.0;
        let mut found = Self::default();
        let mut last: Option<(f64, f64)> = None;
        for frame in frames {
            let Ok(estimate) = estimator.update(&case.of(frame)) else {
                found.sum += REFUSED;
                continue;
            };
            let misfit = (estimate.misfit / 3.0).min(REFUSED);
            found.misfit += misfit;
            found.sum += misfit;
            found.dragged += f64::from(u8::from(estimate.dragged));
            for health in estimate.sides.iter().filter_map(|s| Some(s.kalman?.health)) {
                let tests: [&[f64]; 4] = [
                    &health.encoder,
                    &health.slip,
                    &health.direction,
                    &health.inclination,
                ];
                found.sum += tests.into_iter().flatten().sum::<f64>();
            }
            let turned = frame.wheel_angle.iter().copied().sum::<Option<f64>>();
            if let (Some(turned), [Some(rate), ..]) = (turned, frame.rates)
                && let Some((time, before)) = last.replace((frame.time, turned))
            {
                let way = side.geometry.wheel_radius * (turned - before) / 6.0;
                let speed = way / (frame.time - time).max(f64::MIN_POSITIVE);
                let slopes = estimate
                    .sides
                    .each_ref()
                    .map(|s| s.contact_angle.iter().sum::<f64>() / 3.0);
                let asked = speed * (slopes[0] - slopes[1]) / (2.0 * track);
                let squares = [rate * rate, asked * asked, rate * asked];
                found
                    .roll
                    .iter_mut()
                    .zip(squares)
                    .for_each(|(sum, x)| *sum += x);
            }
        }
        // A count of frames.
        let count = frames.len() as f64;
        for mean in [&mut found.sum, &mut found.misfit, &mut found.dragged] {
            *mean /= count;
        }
        found
    }

    /// Whether it fits better than the log as wired: by all innovations, or, of joints, by these and
    /// the misfit. On drives of `examples/mujoco` without a skid turn no other case of a log that is
    /// wired right has less than 0.96 of its sum (`joints`: less than 0.99).
    fn is_better(&self, own: &Self, joints: bool) -> bool {
        let [by_all, by_misfit] = [self.sum / own.sum, self.misfit / own.misfit];
        by_all < BETTER || joints && by_all < BETTER_OF_JOINTS && by_misfit < BETTER_MISFIT
    }
}

/// Whether the difference of the torques of wheel `i` of both sides answers that of its encoders, as a
/// speed control does; false where one of both, torque or encoder, is exchanged. `None` where the log
/// does not show it.
fn torque_follows(frames: &[WholeFrame], i: usize) -> Option<bool> {
    let difference = |of: fn(&WholeFrame) -> &[Option<f64>; 6]| -> Vec<f64> {
        let of_frame = |frame: &WholeFrame| Some(of(frame)[i]? - of(frame)[i + 3]?);
        frames
            .iter()
            .map(|f| of_frame(f).unwrap_or(f64::NAN))
            .collect()
    };
    let steps = frames.windows(2).map(|w| w[1].time - w[0].time);
    let dt = median(steps.collect()).filter(|dt| *dt > 0.0)?;
    let half = ((0.5 * SMOOTHING / dt).round() as usize).max(1);
    let [angle, torque] = [
        difference(|f| &f.wheel_angle),
        difference(|f| &f.motor_torque),
    ];
    let speed = derivative(&angle, half, dt);
    // Set speeds differ in a turn, torques on a slope: both slowly.
    let slow = ((SLOWLY / dt).round() as usize).max(1);
    let [speed, angle, torque] = [speed, angle, smooth(&torque, half)].map(|x| high_pass(&x, slow));
    let found = fit(&torque, &[&speed, &angle])?;
    let size = |x: &[f64]| {
        x.iter()
            .filter(|x| x.is_finite())
            .map(|x| x * x)
            .sum::<f64>()
            .sqrt()
    };
    let of_speed = found.coefficients.first()? * size(&speed);
    let of_angle = found.coefficients.get(1)? * size(&angle);
    let answer = if of_speed.abs() > of_angle.abs() {
        of_speed
    } else {
        of_angle
    };
    (found.explained > EXPLAINED).then_some(answer < 0.0)
}

/// The torques of both sides: each answers its own encoder.
fn torques(follows: [Option<bool>; 3]) -> Finding {
    let (test, channel) = ("torques of the sides", "torques and encoders");
    let numbers = |which: Option<bool>| {
        let found = (1..=3).filter(|i| follows[i - 1] == which);
        found.map(|i| i.to_string()).collect::<Vec<_>>().join(", ")
    };
    let [wrong, unknown] = [Some(false), None].map(numbers);
    if !wrong.is_empty() {
        let figure = format!("of wheels {wrong} the torque answers the encoder of the other side");
        let remedy = format!(
            "exchange the columns of left and right of either the motor_torque or the angle of wheels {wrong}"
        );
        return Finding::ok(test, channel, figure).fault(remedy);
    }
    let finding = Finding::ok(
        test,
        channel,
        "the differences of left and right torques answer those of the encoders",
    );
    match unknown.is_empty() {
        true => finding,
        false => {
            let figure =
                format!("of wheels {unknown} the torques show no answer of a speed control");
            Finding::ok(test, channel, figure)
                .cannot_tell("drive over bumps under one side under speed control")
        }
    }
}

/// The sign of the roll against the ground: where the left wheels climb, the left side rises.
fn roll_on_ground(own: &Judgement) -> Finding {
    let (test, channel) = ("roll and ground", "body_roll_rate");
    let [rate, asked, product] = own.roll;
    let correlation = product / (rate * asked).sqrt();
    let figure = format!(
        "the roll follows the ground under both sides with a correlation of {correlation:.2}"
    );
    let finding = Finding::ok(test, channel, figure).with("correlation", correlation, "-");
    if correlation > CORRELATED {
        finding
    } else if correlation < -CORRELATED {
        finding.fault("turn the signs of body_roll and body_roll_rate, left side up positive; or left and right are exchanged")
    } else {
        finding.cannot_tell("drive over bumps under one side")
    }
}

/// Which exchange or sign the estimator of both sides agrees with.
fn exchanges(
    frames: &[WholeFrame],
    stated: &StatedBoth<'_>,
    follows: [Option<bool>; 3],
) -> Vec<Finding> {
    let part = part(frames, stated.rover);
    let cases = Case::all();
    let found: Vec<Judgement> =
        (cases.iter().map(|case| Judgement::of(part, stated, case))).collect();
    let own = found[0];
    let mut findings = vec![roll_on_ground(&own)];
    let least = found.iter().map(|f| f.sum).fold(f64::INFINITY, f64::min);
    let figure = format!(
        "{} exchanges and signs tried; contradiction (sum of the mean NIS of both sides, and the misfit) {:.1} as wired, {least:.1} at best",
        cases.len() - 1,
        own.sum
    );
    let finding = Finding::ok(TEST, "all", figure)
        .with("as wired", own.sum, "-")
        .with("at best", least, "-");
    let better = cases
        .iter()
        .zip(&found)
        .filter(|(case, f)| f.is_better(&own, case.is_of_joints()));
    let mut better: Vec<(&Case, f64)> = better.map(|(case, f)| (case, f.sum)).collect();
    let best = better
        .iter()
        .map(|(_, sum)| *sum)
        .fold(f64::INFINITY, f64::min);
    better.retain(|(_, sum)| *sum <= AS_WELL * best);
    // What the torques answer excludes some.
    if better.iter().any(|(case, _)| case.fits(follows)) {
        better.retain(|(case, _)| case.fits(follows));
    }
    let coupling = stated.rover.coupling;
    findings.push(if own.dragged > MOSTLY {
        finding.cannot_tell("wheels are dragged across, which no innovation allows for: drive straight on, over bumps")
    } else if let [(first, _), others @ ..] = &better[..] {
        let mut remedy = first.words(coupling);
        for (other, _) in others {
            remedy += &format!("\nfits as well: {}", other.words(coupling));
        }
        finding.fault(remedy)
    } else if found.iter().skip(1).any(|f| f.sum < own.sum * AS_WELL) {
        finding.cannot_tell("some exchanges of left and right fit as well: drive over bumps under one side; turn one wheel after the other by hand: its encoder and torque must change")
    } else {
        finding
    });
    findings
}
