//! Is a recorded log what the estimators take it for? Signs, units, wiring, delays, zeros, ranges
//! and noise, from the readings alone.
//!
//! | module | question | from |
//! |---|---|---|
//! | `jumps` | Single wrong angles of the wheels, encoders that were reset | what torque and inertia allow |
//! | `torque_spikes` | Single wrong torques, numbers that stand for no reading | what a drive can do |
//! | `clock` | Was the clock set? Where is the log split? Errors and resolution of the stamps | the wheels as a clock |
//! | `dead` | Has a channel no value, or the same one throughout? | the readings alone |
//! | `still` | Is a channel stuck or saturated? | repeated values |
//! | `torques` | Is a torque a signed number? | readings near zero |
//! | `recorded` | What did the sensors of a body read, of which readings of links are made? | the linkage |
//! | `speeds` | Are columns of angles speeds? | each wheel passes the same ground |
//! | `rest` | Are zeros and noise those of the budget? | the rest before the first motion |
//! | `changes`, `links` | Signs, units, exchange; delay of gyroscopes and inclinometers | integral of the rate |
//! | `noise` | Noise of the links' sensors while driving, single wrong readings | what ground can do |
//! | `pin_delay` | Delay of the angle of pin Q | each wheel passes the same ground |
//! | `way` | Zero of the angle of pin Q; does it turn where the ground asks for it? | the same |
//! | `newton` | Late torques, their size | the robot that starts |
//! | `in_step` | Delays of encoders behind each other | wheels start and stop together |
//! | `wheels` | Signs and counts of the encoders | the wheels against each other |
//! | `course`, `ground` | Scale of the encoders, signs and exchange of the links' sensors | each wheel passes the same ground |
//! | `level` | The zero that all inclinometers have in common | work of the torques on the way |
//! | `start` | Signs of the torques, of all encoders | the robot that starts |
//! | `drive` | Exchanged wheels, delay of the torques | answer of a speed control |
//! | `on_links` | Exchanged wheels, encoder and torque together; the link of the middle one | turns of the links |
//! | `limits` | Are torques cut off at a limit? | the equations there |
//! | `wirings` | Which wiring of wheels and links fits? | innovations of all filters of `kalman` |
//! | `agreement` | Are torques read before gears that lose a part of them? | the same |
//! | `agreement` | Do the torques fit the robot's mass? | work of the torques, and height, in `kalman` |
//! | `agreement` | Does `kalman` agree with all? | innovations of all its filters |
//! | `both` | Both sides: left and right exchanged, signs of what lies across | innovations of the estimator of both sides |
//!
//! Each finding has a verdict, the figure behind it, and what to do. A test that a log cannot
//! answer says so.

mod agreement;
mod both;
mod changes;
mod clock;
mod course;
mod dead;
mod delay;
mod drive;
mod ground;
mod in_step;
mod judgement;
mod jumps;
mod level;
mod limits;
mod links;
mod newton;
mod noise;
mod on_links;
mod pin_delay;
mod readings;
mod recorded;
mod recording;
mod report;
mod rest;
mod rewire;
mod speeds;
mod start;
mod stated;
mod still;
pub(crate) mod torque_spikes;
mod torques;
mod way;
mod wheels;
mod wiring;
mod wirings;

pub(crate) use both::contradiction;
pub use both::{Consistency, check_both};
pub(crate) use level::Level;
pub use report::{Finding, Report, Verdict};
pub use stated::{BodyNoise, Stated, StatedBoth};
pub(crate) use torques::signs_are_lost;

pub(crate) use readings::Readings;
pub(crate) use recorded::Recorded;
pub(crate) use recording::Recording;
pub(crate) use rewire::{Change, Channel};

use self::recording::LARGEST_TURN;
use robhaz_estimator::{EstimatorSettings, PAIRINGS, SensorFrame, Sides};
use robhaz_model::Robot;

/// Checks the frames of a log, in order of time, against what is stated.
pub fn check(frames: &[SensorFrame], stated: &Stated<'_>) -> Report {
    check_side(frames, stated, false, &[])
}

/// The same; `is_of_both`: of a log of both sides, whose time stamps have a finding already.
fn check_side(
    frames: &[SensorFrame],
    stated: &Stated<'_>,
    is_of_both: bool,
    excused: &[&'static str],
) -> Report {
    let mut stated = *stated;
    // `kalman` takes contact angles if each wheel has some.
    let has_angle = |i: usize| frames.iter().any(|f| f.contact_angle[i].is_some());
    let usual = match (0..3).all(has_angle) {
        true => EstimatorSettings::kalman(),
        false => EstimatorSettings::kalman_without_angles(),
    };
    stated.settings.method = usual.method;
    let budget = &mut stated.settings.budget;
    let (of_torques, without) = torque_spikes::of_side(frames, stated.robot, budget.torque_noise);
    let (of_jumps, mended) = jumps::findings(&without, stated.robot, budget.encoder_counts);
    let mut findings = vec![clock::finding(&mended)];
    findings.extend((!is_of_both).then(|| clock::jitter(&mended, budget)));
    findings.push(sides(&stated));
    let Some(mut log) = Readings::new(mended, &stated, is_of_both) else {
        let finding = Finding::ok("log", "all", "less than three frames");
        return Report::new(vec![finding.cannot_tell("record some seconds")]);
    };
    (log.findings, log.excused) = (findings, excused);
    if log.has_other_side() && !is_of_both {
        log.pushed = Level::of_side(&log.frames, stated.robot, &stated.settings).pushed;
    }
    log.take(of_jumps);
    log.take(of_torques.into_iter().map(|(_, finding)| finding));
    if let Some(speeds) = speeds::finding(&log.frames, &stated) {
        log.take([speeds, left_out("they need angles of the wheels")]);
        return log.report();
    }
    if !log.check_channels() {
        return log.report();
    }
    log.take(wheels::findings(&log));
    log.take(links::units(&log));
    let (acceleration, forward) = links::acceleration(&log);
    if let Some(gravity) = links::gravity(&acceleration, &log)
        && log.stops(std::slice::from_ref(&gravity), is_of_robot_file)
    {
        log.take([gravity, left_out(RIGHT_FILE)]);
        return log.report();
    }
    log.take([acceleration]);
    match log.recording.turn() {
        turn if turn > LARGEST_TURN => log.check_fast_drive(turn),
        _ => log.check_by_ground(forward),
    }
    log.report()
}

/// What the start of one side of two shows alone: signs, and the size of the torques.
fn check_start(frames: &[SensorFrame], stated: &Stated<'_>) -> Vec<Finding> {
    let log = Readings::new(frames, stated, true);
    let Some(log) = log.filter(|log| log.recording.turn() <= LARGEST_TURN) else {
        return Vec::new();
    };
    let (_, forward) = links::acceleration(&log);
    let mut findings = start::findings(&log, forward);
    findings.extend(start::size(newton::Start::of(&log)));
    findings
}

impl Readings<'_> {
    /// Each channel by itself. Whether all have values that change; of a log in which some have not, what the
    /// others show, too.
    fn check_channels(&mut self) -> bool {
        let stated = self.stated;
        let driving = still::driving(&self.frames, stated.robot);
        let (dead, silences) = dead::findings(&self.frames, stated, &driving);
        self.take(dead.iter().map(|(_, finding)| finding.clone()));
        self.take(silences);
        let without = |findings| dead::without(findings, &dead);
        self.take(without(still::findings(&self.frames, stated, &driving)));
        self.take(without(torques::findings(&self.frames, stated)));
        let is_dead = |channel: Channel| dead.iter().any(|(of, _)| *of == channel);
        let encoders = [0, 1, 2].map(|i| is_dead(Channel::Encoder(i)));
        // Without any encoder nothing shows when the robot stands.
        if encoders.contains(&false) {
            self.take(without(rest::findings(&self.recording, stated)));
        }
        if dead.is_empty() {
            return true;
        }
        if !encoders.contains(&true) {
            self.take(wheels::findings(self));
            let mut of_links = [0, 1].map(Channel::of_link).into_iter().flatten();
            if !of_links.any(is_dead) {
                self.take(links::units(self));
            }
        }
        self.take([dead::left_out()]);
        false
    }

    /// The tests that need no ground: the wheels turn by `turn` (rad) between readings.
    fn check_fast_drive(&mut self, turn: f64) {
        let figure = format!("the wheels turn by {turn:.2} rad between readings");
        let remedy =
            "drive slower, or record at a higher rate: such readings do not show the ground";
        self.take([Finding::ok("motion", "all", figure).cannot_tell(remedy)]);
        self.take(start::unit(self));
        if torques::are_left_out(&self.findings) {
            self.take([torques::left_out()]);
            return;
        }
        self.take_unless_pushed(vec![agreement::as_wired(self)]);
    }

    /// The tests that follow the wheels over the ground. `forward`: see [`links::acceleration`].
    fn check_by_ground(&mut self, forward: f64) {
        if !torques::are_left_out(&self.findings) {
            self.take(start::findings(self, forward));
        }
        let (ground, on_ground) = ground::findings(self, forward > 0.0);
        let is_of_file = self.stops(&ground, is_of_robot_file);
        self.take(ground);
        if is_of_file {
            self.take([left_out(RIGHT_FILE)]);
            return;
        }
        let links = links::findings(self, on_ground);
        // With wrong signs or units a delay has no meaning.
        let are_right = !links.iter().any(Finding::is_fault);
        self.take(links);
        if are_right {
            self.take(noise::findings(self));
            let of_way = way::findings(self);
            if of_way.iter().any(Finding::is_fault) {
                // One remedy for one pin.
                self.findings.retain(|f| f.test != ground::OFFSET);
            }
            self.take(of_way);
            self.take(links::delays(self));
        }
        let distance = ground::distance(self);
        // Links and body follow the ground of the other side, too.
        self.take([distance.unless(
            self.has_other_side(),
            "the other side passed other ground: measure a way, distance over turns of the wheels",
        )]);
        self.take([level(self)]);
        self.take([in_step::of_wheels(&self.recording)]);
        if self.stops(&self.findings, start::is_of_unit) {
            // In another unit zero, noise and work of a torque are others, too.
            self.findings
                .retain(|f| !rest::is_of_torque(f) && f.test != level::TEST);
            self.take([left_out(UNITS)]);
            return;
        }
        if torques::are_left_out(&self.findings) {
            self.take([torques::left_out()]);
            return;
        }
        let start = newton::Start::of(self);
        self.take(start::size(start));
        let (drive, order) = drive::findings(self, start);
        let (jitter, step) = (self.stated.settings.budget.jitter, self.recording.dt);
        let or = format!("the stamps err by {:.1} ms", 1e3 * jitter);
        let unless_jitter = |f: Finding| {
            let is_jitter = f.test == delay::TEST && jitter > LARGEST_JITTER * step;
            f.unless(is_jitter, &or)
        };
        let drive: Vec<Finding> = drive.into_iter().map(unless_jitter).collect();
        let shows_forces = drive.iter().all(|f| f.test != drive::BY_DIRECTION);
        self.take_unless_pushed(drive);
        if !shows_forces {
            self.findings.retain(|f| f.test != level::TEST);
            return;
        }
        if order.is_none_or(|order| order == PAIRINGS[0]) {
            let on_links = [on_links::finding(self)];
            let is_of_file = self.stops(&on_links, is_of_robot_file);
            self.take(on_links);
            if is_of_file {
                self.take([left_out(RIGHT_FILE)]);
                return;
            }
        }
        match self.is_of_both {
            true => self.take(agreement::gears_of_side(self, order)),
            false => self.take_unless_pushed(agreement::findings(self, order)),
        }
    }

    /// Takes what a test of the torques found, but for faults that a push of the other side explains as well, as in a skid
    /// turn. Of the delays that one alone of the torques.
    fn take_unless_pushed(&mut self, findings: Vec<Finding>) {
        let push = self.pushed.unwrap_or(0.0);
        let way = if push > 0.0 { "push" } else { "brake" };
        let or = format!(
            "the other side holds it back, or drives it, as in a skid turn: the torques {way} harder than the slope needs, by {:.2} of this side's weight; record a drive straight on",
            push.abs()
        );
        let is_pushed = self.pushed.is_some();
        let unless_pushed = |finding: Finding| {
            let knows_no_push = match finding.test {
                delay::TEST => finding.channel == drive::LATE,
                test => [drive::PAIRING, wirings::TEST, agreement::TEST].contains(&test),
            };
            finding.unless(is_pushed && knows_no_push, &or)
        };
        self.take(findings.into_iter().map(unless_pushed));
    }

    fn report(mut self) -> Report {
        if self.stated.body.is_some() {
            self.findings.iter_mut().for_each(name_sensors_of_body);
        }
        Report::new(self.findings)
    }
}

/// Errors of the stamps, over the step, from which on the wheels' speeds show no delay of the torques.
const LARGEST_JITTER: f64 = 0.4;

/// What other tests need of a robot file that has a fault.
const RIGHT_FILE: &str = "they need a robot file that is right";

/// The same of units.
pub(crate) const UNITS: &str = "they need angles and torques in their units";

/// What is said of the tests that have no meaning until a fault is corrected. `need`: what they need.
fn left_out(need: &str) -> Finding {
    let finding = Finding::ok("all other tests", "all", need);
    finding.cannot_tell("correct the fault, and check again")
}

fn is_of_robot_file(finding: &Finding) -> bool {
    finding.is_fault() && finding.channel.ends_with(on_links::ROBOT_FILE)
}

const SIDES: &str = "sides";

/// What the log is of, which no reading shows.
fn sides(stated: &Stated<'_>) -> Finding {
    match stated.settings.sides {
        Sides::Plane => Finding::ok(SIDES, "all", "a robot in the plane, or a test rig"),
        Sides::OneOfTwo => {
            let slope = stated.settings.budget.cross_slope.to_degrees();
            let figure = format!(
                "one side of two: the stated deviations contain pushes of the other one and a cross slope of {slope:.1} deg"
            );
            Finding::ok(SIDES, "all", figure)
                .with("cross slope", slope, "deg")
                .cannot_tell(Sides::REMEDY)
        }
    }
}

/// The zero that all inclinometers have in common.
fn level(log: &Readings<'_>) -> Finding {
    let stated = log.stated;
    let channel = stated.body.map_or(ground::CHANNEL, |_| "body_inclination");
    Level::of_side(&log.frames, stated.robot, &stated.settings).finding(channel)
}

/// Says which sensors of the body a fault of the links' readings may be of.
fn name_sensors_of_body(finding: &mut Finding) {
    if finding.channel == ground::CHANNEL {
        "body_inclination, pin_angle".clone_into(&mut finding.channel);
    }
    let is_of_link = ["gyro", "inclinometer"].map(|name| finding.channel.contains(name));
    if let Some(remedy) = &mut finding.remedy
        && is_of_link.contains(&true)
        && !remedy.contains("body_")
        && !remedy.contains("pin_angle")
    {
        *remedy += "\nmade of body_inclination, body_rate and pin_angle: what both links show alike is of the first two";
    }
}

/// Mean NIS from which on a contradiction between the readings is one: see
/// [`robhaz_score::Agreement::contradiction`].
pub fn certain(frames: &[SensorFrame], robot: &Robot) -> f64 {
    let recording = Recording::new(frames, robot);
    recording.map_or(0.0, |recording| recording.certain(robot))
}
