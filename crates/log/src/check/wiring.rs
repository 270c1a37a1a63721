//! Wirings of the wheels and links of one side.

use crate::check::Channel;
use crate::check::rewire::{moved, names};
use robhaz_estimator::{PAIRINGS, SensorFrame};

/// The columns of the log that are encoders and torques of wheels 1 to 3, and whether the
/// links are exchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wiring {
    pub encoders: [usize; 3],
    pub torques: [usize; 3],
    pub links: bool,
}

impl Wiring {
    /// That of the log.
    pub const OF_LOG: Self = Self {
        encoders: PAIRINGS[0],
        torques: PAIRINGS[0],
        links: false,
    };

    /// All wirings in which torque i belongs to encoder `order[i]`; without `order` in which it
    /// belongs to any.
    pub fn all(order: Option<[usize; 3]>) -> Vec<Self> {
        let mut all = Vec::new();
        for encoders in PAIRINGS {
            for torques in PAIRINGS {
                let of = |links| Self {
                    encoders,
                    torques,
                    links,
                };
                if order.is_none_or(|order| torques.map(|i| order[i]) == encoders) {
                    all.extend([false, true].map(of));
                }
            }
        }
        all.sort_by_key(Self::moved);
        all
    }

    /// Number of channels that are not where the log says.
    pub fn moved(&self) -> usize {
        let wheels = moved(self.encoders).count() + moved(self.torques).count();
        wheels + 4 * usize::from(self.links)
    }

    /// A frame that is wired so.
    pub fn of(&self, frame: &SensorFrame) -> SensorFrame {
        let mut wired = *frame;
        wired.wheel_angle = self.encoders.map(|i| frame.wheel_angle[i]);
        wired.motor_torque = self.torques.map(|i| frame.motor_torque[i]);
        if self.links {
            std::mem::swap(&mut wired.link1, &mut wired.link2);
        }
        wired
    }

    /// The channels that it changes.
    pub fn channels(&self) -> String {
        let encoders = moved(self.encoders).map(Channel::Encoder);
        let mut names = names(encoders.chain(moved(self.torques).map(Channel::Torque)));
        if self.links {
            names.push("gyro 1, inclinometer 1, gyro 2, inclinometer 2".to_owned());
        }
        names.join(", ")
    }

    /// What to do, in words: which reading takes the column of which.
    pub fn words(&self) -> String {
        let mut parts = Vec::new();
        for (order, name) in [(self.torques, "motor_torque"), (self.encoders, "angle")] {
            let reading = |i: usize| format!("wheel{}_{name}", i + 1);
            match moved(order).collect::<Vec<usize>>()[..] {
                [] => {}
                [a, b] => {
                    let (a, b) = (reading(a), reading(b));
                    parts.push(format!("exchange the columns of {a} and {b}"));
                }
                _ => {
                    let takes = |i| format!("{} that of {}", reading(i), reading(order[i]));
                    let takes: Vec<String> = moved(order).map(takes).collect();
                    parts.push(format!("give other columns: {}", takes.join(", ")));
                }
            }
        }
        if self.links {
            parts.push("exchange the columns of links 1 and 2".to_owned());
        }
        parts.join("; ")
    }
}
