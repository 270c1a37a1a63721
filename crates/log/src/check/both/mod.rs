//! Both sides of a rover: exchanges of left and right, and the signs of what lies across.
//!
//! Each side goes through the tests of one side. What these cannot show, the estimator of both sides
//! does: it runs with left and right exchanged, or a sign turned, and the case whose innovations and
//! misfit are least fits best. Roll and yaw also show directly, against their rates and the wheels, and
//! zeros of the joints over the way.

mod across;
mod agreement;
mod contradiction;
mod frames;
mod roll;
mod steering;
#[cfg(test)]
pub mod testing;
mod torques;
mod wiring;
mod wirings;

pub use contradiction::{Consistency, contradiction};

use crate::check::{
    BodyNoise, Finding, Level, RIGHT_FILE, SIDES, Stated, StatedBoth, UNITS, Verdict, check_side,
    check_start, clock, delay, drive, ground, in_step, is_of_robot_file, left_out, level, limits,
    links, on_links, rest, speeds, start, torque_spikes, way, wheels,
};
use crate::frames::side_frame;
use rayon::prelude::*;
use robhaz_estimator::SensorFrame;
use robhaz_estimator::whole::{SideReadings, WholeFrame};
use robhaz_model::WholeRover;

/// Names of the sides.
const SIDE_NAMES: [&str; 2] = ["left", "right"];

/// Turn from which on a drive is none straight on, rad.
const STRAIGHT: f64 = 0.17;
/// Turn at a start from which on the sides push each other, rad: straight starts on even ground have up to 0.01, S-curves
/// 0.08 and more.
const STARTS_STRAIGHT: f64 = 0.03;
/// The same of a slow rover, whose start is short, rad: beyond what straight starts have.
/// Chosen.
const SLOW_TURN: f64 = 0.01;
/// Way across of its front and rear wheels over that along, from which on they are dragged as it starts, -.
/// Chosen: half of what a turn in the drive needs, since the torques of a start are small.
const STARTS_DRAGGED: f64 = 0.05;
/// What the tests of both sides need, as [`left_out`] says it.
const OPPOSED: &str = "they need wheels that count forward on both sides";
/// Tests of one side that take it for one that drives straight on.
const STRAIGHT_ON: [&str; 8] = [
    super::agreement::GEARS,
    on_links::TEST,
    wheels::TEST,
    links::ACCELERATION,
    ground::SIGNS,
    ground::SCALE,
    drive::PAIRING,
    drive::BY_DIRECTION,
];
/// Tests of one side that the estimator of both sides answers, or that are not of a side.
const OF_BOTH: [&str; 7] = [
    SIDES,
    super::agreement::TEST,
    super::wirings::TEST,
    super::agreement::TORQUE_SCALE,
    level::TEST,
    limits::TEST,
    way::ZERO,
];
/// Tests of one side whose faults hide an exchange of the sides. Of noise and zeros none is hidden.
const HIDES: [&str; 7] = [
    on_links::TEST,
    links::SIGN,
    wheels::TEST,
    start::TEST,
    super::torques::TEST,
    drive::PAIRING,
    drive::BY_DIRECTION,
];

/// Checks the frames of a log of both sides, in order of time. `known`: what an estimate has found of exchanges, signs
/// and sizes. Where that contradicts nothing only the joints are compared again.
pub fn check_both(
    frames: &[WholeFrame],
    stated: &StatedBoth<'_>,
    known: Option<&Consistency>,
) -> Vec<Finding> {
    let (side, noise) = (&stated.rover.side, stated.settings.budget.torque_noise);
    let (found, frames) = torque_spikes::of_both(frames, side, noise);
    let of_torques = found
        .into_iter()
        .map(|(i, f)| of_named_side(f, SIDE_NAMES[i / 3]));
    let frames = &frames::without_yaw_bias(&frames, &stated.settings.budget);
    let left: Vec<SensorFrame> = frames.iter().map(|frame| side_frame(frame, 0)).collect();
    let mut stated = *stated;
    let of_stamps = clock::jitter(&left, &mut stated.settings.budget);
    let stated = &stated;
    // Without one, or with one that no rover can have, all others look wrong.
    let mut unusable = across::silences(frames, stated.rover);
    unusable.extend(across::ranges(frames, stated.rover));
    let mut moving = across::stuck(frames, stated);
    unusable.extend(moving.extract_if(.., |finding| finding.is_fault()));
    for (side, name) in SIDE_NAMES.into_iter().enumerate() {
        let speeds = with_side(frames, stated, side, speeds::finding);
        unusable.extend(speeds.map(|found| of_named_side(found, name)));
    }
    if !unusable.is_empty() {
        let remedy = "correct these readings first";
        let others = Finding::ok("other tests", "all", "left out").cannot_tell(remedy);
        unusable.extend(of_torques);
        unusable.extend([of_stamps, others]);
        return unusable;
    }
    let mut findings: Vec<Finding> = [of_stamps].into_iter().chain(of_torques).collect();
    let sides = SIDE_NAMES.into_par_iter().enumerate();
    let sides = sides.map(|(side, name)| of_side(frames, stated, side, name));
    findings.extend(sides.collect::<Vec<_>>().into_iter().flatten());
    findings.extend(moving);
    let noise = across::noise_at_rest(frames, stated);
    // Of a coupling that is too loud the inclination of each side is made.
    if noise
        .iter()
        .any(|f| f.is_fault() && f.channel != "body_roll")
    {
        let is_of_inclination =
            |f: &Finding| f.test == rest::NOISE && f.channel.ends_with("body_inclination");
        findings.retain(|f| !is_of_inclination(f));
    }
    findings.extend(noise);
    // A way, or a robot, that is another one for a side is so for both together.
    let is_unit =
        |f: &Finding| start::is_of_unit(f) || f.is_fault() && f.test == links::ACCELERATION;
    if findings.iter().any(is_of_robot_file) {
        findings.push(left_out(RIGHT_FILE));
    } else if findings.iter().any(is_unit) {
        findings.push(left_out(UNITS));
    } else {
        let is_compared = known.is_some_and(|known| known.contradiction.is_none());
        across_sides(frames, stated, is_compared, &mut findings);
    }
    findings
}

/// What both sides show together, added to the findings of each by itself. `is_compared`: see
/// [`wirings::findings`].
fn across_sides(
    frames: &[WholeFrame],
    stated: &StatedBoth<'_>,
    is_compared: bool,
    findings: &mut Vec<Finding>,
) {
    let rover = stated.rover;
    if let Some(opposed) = across::opposed(frames, rover) {
        // A side by itself would look for the cause in the body.
        findings.retain(|f| f.test != start::TEST);
        findings.extend([opposed, left_out(OPPOSED)]);
        return;
    }
    // In a turn the set speeds differ.
    let is_straight = frames::body_turn(frames) < STRAIGHT;
    let pace = frames::pace(frames, rover);
    // One wheel that is late makes its side late.
    let is_of_wheel = |f: &Finding| f.is_fault() && f.channel.ends_with(in_step::OF_WHEELS);
    if is_straight && !findings.iter().any(is_of_wheel) {
        findings.extend(frames::in_step(frames));
    }
    let follows =
        [0, 1, 2].map(|i| torques::follows(frames, rover, i, pace).filter(|_| is_straight));
    let of_torques = torques::finding(follows);
    if of_torques.is_fault() {
        // A side by itself would look for the cause in itself.
        findings.retain(|f| f.test != drive::PAIRING);
    }
    let mut faults = findings.iter().filter(|f| f.is_fault());
    let is_upset = faults.any(|f| HIDES.contains(&f.test));
    findings.push(of_torques);
    let mut zeros = across::zeros(frames, stated);
    for (zero, side) in zeros.iter_mut().zip(SIDE_NAMES) {
        take_rest(zero, side, findings);
        // One remedy for one pin: the way tells its zero from that of the body.
        if zero.verdict != Verdict::CannotTell {
            findings.retain(|f| f.test != ground::OFFSET || !f.channel.starts_with(side));
        }
    }
    // The small gain by which a joint's wiring shows is as well that of a zero that is off.
    let zeroed = !zeros.iter().any(Finding::is_fault);
    findings.extend(zeros);
    findings.push(roll::roll(frames, stated, pace));
    let at_rest = Level::of_both(frames, rover, &stated.settings).roll_at_rest();
    findings.push(roll::zero(frames, stated, at_rest));
    // The same ground under all wheels of a side is that of the body's own pitch.
    let is_passed = |f: &&Finding| f.test == ground::SCALE && f.verdict == Verdict::Ok;
    let pitched = findings.iter().filter(is_passed).count() == 2;
    let flags = [is_upset, zeroed, pitched];
    let found = wirings::findings(frames, stated, pace, follows, flags, is_compared);
    let of_torques = findings.iter_mut().find(|f| f.test == torques::TEST);
    if let (Some(finding), Some(remedy)) = (of_torques, found.of_torques) {
        finding.remedy = Some(remedy);
    }
    findings.extend(found.findings);
    let wired = found.frames;
    // With what was found corrected: exchanged wheels turn the yaw, too.
    let yaw = across::yaw(&wired, rover, &stated.settings.budget);
    if !yaw.is_fault() {
        findings.extend(steering::steering(&wired, rover));
    }
    findings.push(yaw);
    if !is_compared && !findings.iter().any(Finding::is_fault) {
        findings.push(contradiction::sizes(&wired, stated, pace));
    }
    let level = Level::of_both(&wired, rover, &stated.settings);
    findings.push(level.finding("body_inclination"));
    let is_found = findings.iter().any(Finding::is_fault);
    findings.extend(agreement::findings(&wired, stated, is_found));
}

/// A pin's zero that is off over the way takes what the pin shows at rest in place of a finding of its own.
fn take_rest(zero: &mut Finding, side: &str, findings: &mut Vec<Finding>) {
    let of_pin = format!("{side}: pin_angle");
    let is_of_rest =
        |f: &mut Finding| f.test == rest::ZERO && f.channel == of_pin && f.verdict != Verdict::Ok;
    if zero.is_fault()
        && let Some(remedy) = &mut zero.remedy
        && let Some(of_rest) = findings.extract_if(.., is_of_rest).next()
    {
        *remedy += &format!(
            "\nthis is the mean over the drive, which bumps under one side shift; {}",
            of_rest.remedy.unwrap_or_default()
        );
    }
}

/// What a test says of the frames of one side, with what is stated of it.
fn with_side<T>(
    frames: &[WholeFrame],
    stated: &StatedBoth<'_>,
    side: usize,
    test: impl Fn(&[SensorFrame], &Stated<'_>) -> T,
) -> T {
    let (rover, mut settings) = (stated.rover, stated.settings);
    let budget = stated.settings.budget;
    settings.budget = budget.of_body_sensors(&rover.side, stated.joint);
    let mut readings = SideReadings::new(rover, stated.joint[0]).keeping_jumps();
    let of_frame = |frame: &WholeFrame| readings.frames(frame)[side];
    let of_side: Vec<SensorFrame> = frames.iter().map(of_frame).collect();
    let stated_side = Stated {
        robot: &rover.side,
        settings,
        compare_from: stated.compare_from,
        body: Some(BodyNoise {
            inclination: budget.inclination_noise,
            rate: budget.rate_noise,
            pin: stated.joint[0],
        }),
    };
    test(&of_side, &stated_side)
}

/// Whether the rover turns as it starts: each side then pushes the other one.
fn starts_turning(frames: &[WholeFrame], rover: &WholeRover) -> bool {
    let start = frames::start(frames);
    let turned = frames::body_turn(start);
    let mut turns = start.iter().filter_map(frames::wheel_turns);
    let ends = turns
        .next()
        .map(|first| (first, turns.next_back().unwrap_or(first)));
    let geometry = &rover.side.geometry;
    let way = ends.map_or(0.0, |(first, last)| {
        geometry.wheel_radius * (last - first).abs() / 6.0
    });
    let across = 0.5 * geometry.wheelbase() * turned;
    turned > STARTS_STRAIGHT || turned > SLOW_TURN && across > STARTS_DRAGGED * way
}

/// What a start straight on shows of the signs of each side, and of the size of the torques.
fn of_start(frames: &[WholeFrame], stated: &StatedBoth<'_>) -> Vec<Finding> {
    if starts_turning(frames, stated.rover) {
        return Vec::new();
    }
    let sides = SIDE_NAMES.into_iter().enumerate();
    let found = sides.flat_map(|(side, name)| {
        let found = with_side(frames, stated, side, check_start);
        found.into_iter().map(move |f| of_named_side(f, name))
    });
    found.collect()
}

/// The tests of one side, whose links' readings are made of those of the body and the joints.
fn of_side(
    frames: &[WholeFrame],
    stated: &StatedBoth<'_>,
    side: usize,
    name: &str,
) -> Vec<Finding> {
    let turned = frames::body_turn(frames);
    let starts_turning = starts_turning(frames, stated.rover);
    let mut excused = Vec::new();
    if starts_turning {
        excused.extend([start::TEST, start::SIZE]);
    }
    if turned > STRAIGHT {
        excused.extend(STRAIGHT_ON);
    }
    let mut findings = with_side(frames, stated, side, |frames, stated| {
        check_side(frames, stated, true, &excused).findings
    });
    let is_late = |f: &Finding| f.test == delay::TEST && f.channel == drive::LATE;
    // The body's inclination follows both sides, and a delay of one side's ground is none of it.
    let is_of_body = |f: &Finding| f.test == delay::TEST && f.channel.contains("body_inclination");
    findings.retain(|f| !OF_BOTH.contains(&f.test) && !is_of_body(f));
    findings.retain(|f| !excused.contains(&f.test));
    // Each side pushes the other one, and has no law of motion of its own.
    findings.retain(|f| excused.is_empty() || !is_late(f));
    if starts_turning {
        let figure = "the rover turns as it starts";
        let finding = Finding::ok(start::TEST, "torques 1 to 3", figure);
        findings.push(finding.cannot_tell("start straight on, after a rest"));
    }
    if turned > STRAIGHT {
        let figure = format!("turned by {:.0} deg", turned.to_degrees());
        let remedy = "record a drive straight on, too: in a turn wheels of a side pass other ground at other speeds";
        findings.push(Finding::ok("wheels of a side", "all", figure).cannot_tell(remedy));
    }
    for finding in &mut findings {
        if finding.test == start::TEST
            && let Some(remedy) = &mut finding.remedy
            && remedy.contains("body_inclination")
        {
            *remedy += "\nor the body's IMU is turned by half a turn: state forward = \"-x\" of imu.body; or its orientation is that of the world in its axes: turn the signs of x, y and z of the quaternion";
        }
    }
    let named = findings.into_iter().map(|f| of_named_side(f, name));
    named.collect()
}

/// The finding with the side in its channel, and with the readings' own names in its remedy.
fn of_named_side(mut finding: Finding, name: &str) -> Finding {
    finding.channel = format!("{name}: {}", finding.channel);
    if let Some(remedy) = &mut finding.remedy {
        for reading in ["pin_angle", "wheel1_", "wheel2_", "wheel3_"] {
            let own = format!("{name}_{reading}");
            *remedy = remedy.replace(&own, reading).replace(reading, &own);
        }
    }
    finding
}

#[cfg(test)]
mod tests {
    use super::testing::{rover, turn_left};
    use super::*;

    /// A turn of 0.015 rad in 1.5 s is one of a rover that drives 45 mm, whose front wheels go across by a tenth of that, and
    /// none of one that drives 0.45 m; one of 0.3 rad always is.
    #[test]
    fn a_slow_start_turns_by_less() {
        let rover = rover();
        let turns = |speed: f64, rate: f64| {
            let frames = turn_left(|f| {
                let angle = speed * f.time / rover.side.geometry.wheel_radius;
                f.wheel_angle = [Some(angle); 6];
                f.rates[2] = Some(rate);
            });
            starts_turning(&frames, &rover)
        };
        assert!(turns(0.03, 0.01) && !turns(0.3, 0.01) && turns(0.3, 0.2));
        assert!(!turns(0.003, 0.001));
    }
}
