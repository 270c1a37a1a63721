//! The estimator's own judgement: [`robhaz_estimator::Health`] of `kalman` over the whole log; torques that are read before
//! gears which lose a part of them.

use crate::check::dead::OTHER_AXIS;
use crate::check::judgement::{AGREE, BETTER, Judgement, OFTEN};
use crate::check::wiring::Wiring;
use crate::check::{Channel, Finding, Readings, Stated, limits, still, wirings};
use robhaz_estimator::{Confirmation, EstimateError, SensorFrame, Sides, TorqueScale};
use robhaz_model::Robot;
use robhaz_score::signals::deviation;

pub const TEST: &str = "agreement of all";
pub const TORQUE_SCALE: &str = "scale of torques, mass";
pub const GEARS: &str = "efficiency of the gears";
const CHANNEL: &str = "all";
/// Deviations by which a ratio of the torques is beyond 0, and beyond 1, if it is a scale: 0.1 % by chance.
const SCALE: f64 = 3.0;
/// Deviation of a rate over its noise up to which a link does not turn: that of a noise at rest that is right.
const QUIET: f64 = 2.0;
/// Efficiencies that are tried.
const EFFICIENCIES: [f64; 5] = [1.0, 0.9, 0.8, 0.7, 0.6];
/// Median of a normalised square if all that is stated holds: of chi-square with one degree of freedom.
const MIDDLE: f64 = 0.455;

/// Whether the readings agree, without a look at other wirings.
pub fn as_wired(log: &Readings<'_>) -> Finding {
    let own = Judgement::of(&log.frames, log.stated, &Wiring::OF_LOG);
    contradiction(&own, log.certain())
}

/// All findings. `order`: the encoders to which the torques belong, if these show it.
pub fn findings(log: &Readings<'_>, order: Option<[usize; 3]>) -> Vec<Finding> {
    let (frames, stated, certain) = (&*log.frames, log.stated, log.certain());
    let own = Judgement::of(frames, stated, &Wiring::OF_LOG);
    if own.absurd > OFTEN {
        return vec![torque_scale(&own, stated), contradiction(&own, certain)];
    }
    let part = wirings::part(frames);
    let (of_wirings, other) = wirings::finding(log, part, order, own.agrees());
    let mut findings = Vec::new();
    let judged = match &other {
        Some(other) => Judgement::of(frames, stated, other),
        None => {
            // Fast drives and rare readings leave the filters behind, as such gears do.
            let is_close = certain <= 0.0;
            findings.extend(is_close.then(|| gears(part, stated)).flatten());
            let torques = [0, 1, 2].map(Channel::Torque).into_iter();
            let torques = torques.map(|channel| (channel.to_string(), channel.values(frames)));
            let wheels = frames.iter().map(|f| (f.time, f.wheel_angle));
            let turning = still::turning(wheels, stated.robot);
            let limits = limits::finding(torques, &turning, &own.parity, [MIDDLE, 0.0]);
            findings.extend(limits);
            own
        }
    };
    let mut disagreement = contradiction(&judged, certain);
    let mut others = log.findings.iter().chain(&findings);
    if disagreement.is_fault() && !others.any(Finding::is_fault) {
        disagreement = or_other_side(disagreement, log, other.as_ref());
    }
    if disagreement.is_fault()
        && no_link_turns(log)
        && let Some(remedy) = &mut disagreement.remedy
    {
        *remedy += "\non ground that is not level links turn, and here none does beyond its noise";
        *remedy += OTHER_AXIS;
    }
    findings.extend([torque_scale(&judged, stated), of_wirings, disagreement]);
    findings
}

/// With another efficiency of the gears than that stated the readings agree, and fit far better.
fn gears(part: &[SensorFrame], stated: &Stated<'_>) -> Option<Finding> {
    let of = |efficiency: f64| {
        let mut stated = *stated;
        stated.settings.gear_efficiency = efficiency;
        let found = Judgement::of(part, &stated, &Wiring::OF_LOG);
        (efficiency, found.nis - found.of_encoders)
    };
    let (own, as_stated) = of(stated.settings.gear_efficiency);
    if as_stated <= AGREE {
        return None;
    }
    let is_other = |efficiency: &f64| (efficiency - own).abs() > f64::EPSILON;
    let tried = EFFICIENCIES.into_iter().filter(is_other).map(of);
    let (best, least) = tried.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (least < BETTER * as_stated && least < AGREE).then(|| {
        let figure = format!(
            "driving and braking torques fit gears of an efficiency of {best:.1}; stated is {own:.2} (contradiction {least:.1} in place of {as_stated:.1})"
        );
        let remedy = format!("state drive.gear_efficiency = {best:.1}, for torques before the gears: currents times torque_constant and gear_ratio");
        Finding::ok(GEARS, "torques 1 to 3", figure)
            .with("efficiency", best, "-")
            .fault(remedy)
    })
}

/// Of a side of both: the efficiency of its gears. All else that [`findings`] says the estimator of both sides says.
pub fn gears_of_side(log: &Readings<'_>, order: Option<[usize; 3]>) -> Option<Finding> {
    if log.certain() > 0.0 {
        return None;
    }
    let part = wirings::part(&log.frames);
    let found = gears(part, log.stated)?;
    let own = Judgement::of(&log.frames, log.stated, &Wiring::OF_LOG);
    if own.absurd > OFTEN {
        return None;
    }
    let (_, other) = wirings::finding(log, part, order, own.agrees());
    other.is_none().then_some(found)
}

/// Whether the gyroscopes of both links show nothing but noise while the robot drives.
fn no_link_turns(log: &Readings<'_>) -> bool {
    let is_quiet = |k: usize| {
        let rate = log.recording.while_driving(&log.recording.rate[k]);
        deviation(&rate) < QUIET * Channel::Gyro(k).noise(log.stated)
    };
    (0..2).all(is_quiet)
}

/// Of readings that contradict each other as those of a robot in the plane, without another cause: whether they agree
/// as those of one side of two, whose other side pushes it.
fn or_other_side(finding: Finding, log: &Readings<'_>, wiring: Option<&Wiring>) -> Finding {
    let (mut one_of_two, certain) = (*log.stated, log.certain());
    if one_of_two.settings.sides != Sides::Plane {
        return finding;
    }
    one_of_two.settings.sides = Sides::OneOfTwo;
    let found = Judgement::of(&log.frames, &one_of_two, wiring.unwrap_or(&Wiring::OF_LOG));
    let agrees = found.agreement.contradiction(certain).is_none()
        && found.agreement.wrong(certain).is_none();
    match finding.remedy.clone().filter(|_| agrees) {
        Some(remedy) => finding.fault(format!(
            "if the robot has another side, state sides = \"one of two\": so the readings agree\n{remedy}"
        )),
        None => finding,
    }
}

/// The torques against the weight, as `kalman` has found them.
fn torque_scale(own: &Judgement, stated: &Stated<'_>) -> Finding {
    const CHANNEL: &str = "torques 1 to 3";
    if stated.settings.sides == Sides::OneOfTwo {
        let figure = "the torques of one side of two do not carry its weight alone";
        let remedy =
            "hold a wheel by a spring scale: its pull times the wheel radius is the torque";
        return Finding::ok(TORQUE_SCALE, CHANNEL, figure).cannot_tell(remedy);
    }
    let Some(scale) = own.scale else {
        return Finding::ok(TORQUE_SCALE, CHANNEL, "no estimate").cannot_tell("see the faults");
    };
    let fault = format!(
        "weigh the robot as it drives; if its mass is right, multiply `scale` of the three torques by {:.2}",
        1.0 / scale.ratio
    );
    let unknown = "drive gently over a slope of some degrees that is longer than the robot";
    of_scale(scale, stated.robot, [CHANNEL, "sigma"], [unknown, &fault])
}

/// The finding of the torques' scale, for a robot or one side of a rover, with the names of channel and deviation, and
/// the remedies where it is unknown and where it is wrong.
pub fn of_scale(
    scale: TorqueScale,
    robot: &Robot,
    [channel, sigma]: [&'static str; 2],
    [unknown, fault]: [&str; 2],
) -> Finding {
    let is_scale = scale.ratio.min((scale.ratio - 1.0).abs()) > SCALE * scale.sigma;
    let finding = |figure: String| {
        Finding::ok(TORQUE_SCALE, channel, figure)
            .with("ratio", scale.ratio, "-")
            .with(sigma, scale.sigma, "-")
    };
    if scale.confirmation == Confirmation::Contradicts && !is_scale {
        let [fits, error] = [scale.ratio, scale.sigma].map(|of| of * robot.mass.total());
        // Three digits of a light robot; the cast saturates.
        let places = (2.0 - robot.mass.total().log10().floor()).clamp(1.0, 9.0) as usize;
        let figure = format!(
            "the torques do not lift the robot as its links say: they would fit {fits:.places$} +- {error:.places$} kg a side, which no scale and no mass explains"
        );
        return finding(figure).fault(
            "a zero of an inclinometer or a gyroscope explains it, or one that sits on another link, or is late: stand for a second on level ground, where all read 0, state their offsets, and check what each is mounted on",
        );
    }
    let finding = finding(scale.in_words(robot.mass.total()).to_string());
    match scale.confirmation {
        Confirmation::Confirmed => finding,
        Confirmation::Unconfirmed => finding.cannot_tell(unknown),
        Confirmation::Contradicts => finding.fault(fault),
    }
}

/// What is left with all changes that other tests ask for.
fn contradiction(own: &Judgement, certain: f64) -> Finding {
    let of_frames = |share: f64, channel: &str, what: &str| {
        let figure = format!("{:.1} % of the frames have {what}", 100.0 * share);
        Finding::ok(TEST, channel, figure).with("share", 100.0 * share, "%")
    };
    if own.absurd > OFTEN {
        let what = "a reading beyond what the robot can do";
        return of_frames(own.absurd, CHANNEL, what).fault("check units and gear ratios");
    }
    if let Some(excuse) = own.agreement.wrong(certain) {
        let what = "forces that neither weight nor impacts explain: `estimate` says so, too";
        let names: Vec<&str> = match own.agreement.contradiction(0.0) {
            Some(found) => found.faulty.names().collect(),
            None => vec![CHANNEL],
        };
        let finding = of_frames(own.agreement.out_of_range(), &names.join(", "), what);
        return match excuse {
            Some(excuse) => finding.cannot_tell(excuse.in_words()),
            None => finding.fault("correct the faults first; without any, check signs, zeros, dimensions, masses and noise budget"),
        };
    }
    let (largest, of) = own.agreement.largest();
    let contradiction = own.agreement.contradiction(certain);
    if let Some((found, first)) = contradiction.zip(own.agreement.first()) {
        let names: Vec<&str> = found.faulty.names().collect();
        let figure = format!(
            "readings contradict each other from {first:.1} s on (largest mean NIS {largest:.1}; from 4 on it is a contradiction, below it a sign, a pairing or a delay does not fit)"
        );
        if let Some(excuse) = found.excuse {
            return Finding::ok(TEST, CHANNEL, figure).cannot_tell(excuse.in_words());
        }
        let remedy =
            "correct the faults first; without any, check dimensions, masses and noise budget";
        let finding = Finding::ok(TEST, names.join(", "), figure).fault(remedy);
        return finding
            .with("from", first, "s")
            .with("largest", largest, "-");
    }
    if own.refused > OFTEN {
        let (channel, remedy) = match own.why {
            Some(EstimateError::Missing { field }) => (
                CHANNEL,
                format!(
                    "there is none before the first value of {}: find out why it was not read, or begin the log there",
                    reading_of(field)
                ),
            ),
            Some(EstimateError::Linkage(_)) => (
                "inclinometer 1, inclinometer 2",
                "check the inclinometers: the four-bar cannot close at such angles".to_owned(),
            ),
            Some(error) => (CHANNEL, format!("the estimator refuses them: {error}")),
            None => (CHANNEL, "see the faults".to_owned()),
        };
        return of_frames(own.refused, channel, "no estimate").fault(remedy);
    }
    let figure =
        format!("largest mean NIS {largest:.1} ({of}; 1 is right, a contradiction from 4 on)");
    Finding::ok(TEST, CHANNEL, figure).with("largest", largest, "-")
}

/// The name of a reading, of the field of a frame.
fn reading_of(field: &str) -> String {
    match field.trim_end_matches(']').split_once('[') {
        None => field.replace('.', "_"),
        Some((name, wheel)) => {
            let wheel = wheel.parse::<usize>().map_or(0, |wheel| wheel + 1);
            format!("wheel{wheel}_{}", name.trim_start_matches("wheel_"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::reading_of;

    #[test]
    fn fields_have_the_names_of_readings() {
        let names = ["link1.rate", "wheel_angle[1]", "motor_torque[2]"].map(reading_of);
        assert_eq!(names, ["link1_rate", "wheel2_angle", "wheel3_motor_torque"]);
    }
}
