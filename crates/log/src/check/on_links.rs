//! Which wheels hang on which link: a link that turns moves its wheels over the ground, and turns them.
//!
//! Q is at the height of its arm above an axle, so that a wheel on a link that turns by dtheta (nose up positive) rolls
//! `(h + r) dtheta` further than one on a link that does not: `h` by the way of its axle, `r` as its angle is that
//! to its link. What it does not turn, it slips, with its traction. So for the differences of the wheels from their mean,
//!
//! ```text
//! (h + r) dtheta_i = r dphi_i - c int tau_i dt
//! ```
//!
//! with the same c, not negative, for all. On the link with one wheel it is that wheel which goes ahead or stays behind:
//! front and rear wheel cannot be exchanged, encoders and torques together, nor can the middle wheel hang on the other
//! link. Masses, zeros and constant scales have no part in it.

use crate::check::recording::add;
use crate::check::rewire::{self, moved};
use crate::check::wiring::Wiring;
use crate::check::{Change, Channel, Finding, Readings};
use robhaz_estimator::PAIRINGS;
use robhaz_model::Carrier;
use robhaz_score::signals::{integral, mean};

/// Part of a footprint over which changes are compared: on a shorter way counts are coarse, on a longer one few are
/// independent.
const SPAN: f64 = 0.25;
/// Part of such a way from which on the robot drives.
const DRIVES: f64 = 0.3;
/// Share of what the links make that turns and slip of the wheels explain. Of 417 correct logs 60 % are beyond it, 27 % have
/// hardly any such changes.
const EXPLAINED: f64 = 0.7;
/// Logarithm of the odds by which readings tell one wiring from another: 1 100 to 1. Of those logs another wiring fitted
/// better by up to 5.6, and explained 54 %.
const CERTAIN: f64 = 7.0;
/// Logarithm of the odds that counts as none.
const EQUAL: f64 = 1e-6;

pub const TEST: &str = "wheels on their links";
const CHANNEL: &str = "all";
/// The channel of a fault of the robot file.
pub const ROBOT_FILE: &str = "robot file";

/// What may be: the wheels whose columns, of encoder and torque, each wheel has, and the links that the wheels hang on.
#[derive(Clone, Copy)]
struct Hung {
    order: [usize; 3],
    carriers: [Carrier; 3],
}

/// Differences of the wheels from their mean, over a part of a footprint and less their mean over the log.
struct Changes {
    /// Of the way by the angles, m, and of the integral of the torque, N m s.
    turned: [Vec<f64>; 3],
    worked: [Vec<f64>; 3],
    /// What each link makes, m.
    links: [[Vec<f64>; 2]; 3],
    /// Number of independent ones.
    count: f64,
}

impl Changes {
    /// `None` of a robot that does not drive.
    fn of(log: &Readings<'_>) -> Option<Self> {
        let (recording, geometry) = (&log.recording, &log.stated.robot.geometry);
        let radius = geometry.wheel_radius;
        let span = SPAN * geometry.wheelbase();
        let steps = recording.steps(span / (radius * recording.usual_spin()?));
        let change = |x: &[f64]| -> Vec<f64> {
            let pairs = x.iter().zip(x.iter().skip(steps));
            pairs.map(|(from, to)| to - from).collect()
        };
        let scaled = |x: &[f64], by: f64| x.iter().map(|x| by * x).collect::<Vec<f64>>();
        let turned = (recording.wheel_angle.each_ref()).map(|angle| change(&scaled(angle, radius)));
        let worked = (recording.torque.each_ref()).map(|x| change(&integral(x, recording.dt)));
        let height = |i: usize| radius - (geometry.axles[i] - geometry.pins.q).y;
        let links = [0, 1, 2].map(|i| {
            (recording.inclination.each_ref()).map(|angle| change(&scaled(angle, height(i))))
        });
        let of_wheels = turned.iter().chain(&worked);
        let all: Vec<&Vec<f64>> = of_wheels.chain(links.iter().flatten()).collect();
        let drives = |k: &usize| {
            let way = turned.iter().map(|x| x[*k]).sum::<f64>() / 3.0;
            way.abs() > DRIVES * span && all.iter().all(|x| x[*k].is_finite())
        };
        let kept: Vec<usize> = (0..turned[0].len()).filter(drives).collect();
        let pick = |x: &Vec<f64>| kept.iter().map(|k| x[*k]).collect::<Vec<f64>>();
        Some(Self {
            turned: differences(&turned.each_ref().map(pick)),
            worked: differences(&worked.each_ref().map(pick)),
            links: links.each_ref().map(|of| of.each_ref().map(pick)),
            count: kept.len() as f64 / steps as f64,
        })
    }

    fn left(&self, hung: &Hung) -> Left {
        let of_link = |i: usize| self.links[i][hung.carriers[i].index()].clone();
        let made = differences(&[0, 1, 2].map(of_link));
        let (mut sums, mut all) = ([0.0; 3], 0.0);
        for (i, made) in made.iter().enumerate() {
            let [turned, worked] = [&self.turned, &self.worked].map(|of| &of[hung.order[i]]);
            for ((made, turned), worked) in made.iter().zip(turned).zip(worked) {
                let left = made - turned;
                all += made * made;
                add(&mut sums, [left * left, left * worked, worked * worked]);
            }
        }
        let [squares, both, of_work] = sums;
        // Traction does not pull a wheel back. Without torques it is not a number, and none.
        let slip = (-both / of_work).max(0.0);
        Left {
            made: all,
            of_wheels: squares + 2.0 * slip * both + slip * slip * of_work,
        }
    }
}

/// Sums of squares of what the links make, m^2, and of what the wheels leave of it.
struct Left {
    made: f64,
    of_wheels: f64,
}

impl Left {
    fn explained(&self) -> f64 {
        let left = self.of_wheels / self.made;
        if self.made > 0.0 { 1.0 - left } else { 0.0 }
    }
}

/// Differences of three wheels from their mean, less their own means.
fn differences(x: &[Vec<f64>; 3]) -> [Vec<f64>; 3] {
    let count = x[0].len();
    let of_wheel = |i: usize| {
        let apart = (0..count).map(|k| x[i][k] - (x[0][k] + x[1][k] + x[2][k]) / 3.0);
        let apart: Vec<f64> = apart.collect();
        let middle = mean(&apart).unwrap_or(0.0);
        apart.iter().map(|x| x - middle).collect()
    };
    [0, 1, 2].map(of_wheel)
}

/// The finding, for readings whose torques belong to their encoders.
pub fn finding(log: &Readings<'_>) -> Finding {
    let carriers = log.stated.robot.geometry.carriers;
    let unknown = "drive with all wheels over an obstacle of some centimetres";
    let Some(changes) = Changes::of(log) else {
        return Finding::ok(TEST, CHANNEL, "the robot does not drive").cannot_tell(unknown);
    };
    let hung = |order: [usize; 3]| Hung { order, carriers };
    let own = changes.left(&hung(PAIRINGS[0]));
    let mut on_other = hung(PAIRINGS[0]);
    on_other.carriers[1] = match carriers[1] {
        Carrier::Link1 => Carrier::Link2,
        Carrier::Link2 => Carrier::Link1,
    };
    let mut others = vec![on_other];
    others.extend(PAIRINGS[1..].iter().copied().map(hung));
    // The fewest changes first.
    others.sort_by_key(|hung| moved(hung.order).count());
    let judged = |hung: Hung| (hung, changes.left(&hung));
    let others: Vec<(Hung, Left)> = others.into_iter().map(judged).collect();
    // The logarithm of the odds of another one to what is stated.
    let odds = |left: &Left| 0.5 * changes.count * (own.of_wheels / left.of_wheels).ln();
    let most = others.iter().map(|(_, left)| odds(left));
    let most = most.fold(f64::NEG_INFINITY, f64::max);
    let figure = format!(
        "turns and slip of the wheels explain {:.0} % of what the links ask of them",
        100.0 * own.explained().max(0.0)
    );
    let finding =
        |figure: String| Finding::ok(TEST, CHANNEL, figure).with("explained", own.explained(), "-");
    let mut fitting = others
        .iter()
        .filter(|(_, left)| odds(left) > most - CERTAIN && left.explained() > EXPLAINED);
    if most > CERTAIN
        && let Some((hung, left)) = fitting.next()
    {
        let explained = left.explained();
        let finding = finding(format!("{figure}, otherwise {:.0} %", 100.0 * explained))
            .with("explained otherwise", explained, "-")
            .with("logarithm of the odds", odds(left), "-");
        let as_well: Vec<Hung> = fitting.map(|(hung, _)| *hung).collect();
        return hung.fault(finding, &as_well);
    }
    let is_other = |left: &Left| -odds(left) > CERTAIN || odds(left).abs() <= EQUAL;
    match own.explained() > EXPLAINED && others.iter().all(|(_, left)| is_other(left)) {
        true => finding(figure),
        false => finding(figure).cannot_tell(unknown),
    }
}

impl Hung {
    fn wiring(self) -> Wiring {
        Wiring {
            encoders: self.order,
            torques: self.order,
            links: false,
        }
    }

    fn words(self) -> String {
        match moved(self.order).count() {
            0 => format!(
                "the middle wheel hangs on link {}: correct `carriers` of the robot file",
                self.carriers[1].index() + 1
            ),
            _ => self.wiring().words(),
        }
    }

    fn fault(self, mut finding: Finding, as_well: &[Self]) -> Finding {
        let remedy = self.words() + &rewire::as_well(as_well.iter().map(|hung| hung.words()));
        finding.channel = match moved(self.order).collect::<Vec<_>>()[..] {
            [] => ROBOT_FILE.to_owned(),
            [a, b] => {
                let of: [fn(usize) -> Channel; 2] = [Channel::Encoder, Channel::Torque];
                finding = finding.change(of.map(|of| Change::Exchange(of(a), of(b))));
                self.wiring().channels()
            }
            _ => self.wiring().channels(),
        };
        finding.fault(remedy)
    }
}
