//! Events of wheels, end stops and bars, found by comparing each sample with the one before.

use robhaz_model::{Bar, PinStop, named};
use robhaz_sim::clearance::Clearances;
use robhaz_sim::{Truth, WheelTruth};
use serde::{Deserialize, Serialize};

named! {
    /// Contact and slip state of a wheel.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum WheelState {
        /// It touches the ground, and its slip speed is not above the limit of its friction law
        /// (half the limit if it slipped at the sample before).
        Grips = "grips",
        /// It touches the ground, and its slip speed is above that limit.
        Slips = "slips",
        /// It has no contact.
        InTheAir = "in the air",
    }
}

named! {
    /// One of the two end stops of pin Q.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum EndStop {
        /// At the largest theta1 - theta2.
        Upper = "upper",
        /// At the smallest theta1 - theta2.
        Lower = "lower",
    }
}

impl EndStop {
    /// The stop that an angle theta1 - theta2 (rad) is nearer to.
    pub fn nearest(stop: &PinStop, angle: f64) -> Self {
        if (angle - stop.upper).abs() < (angle - stop.lower).abs() {
            Self::Upper
        } else {
            Self::Lower
        }
    }
}

/// The kind of an event. Wheels are counted from 0: front, middle, rear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// A wheel loses its contact.
    ContactLost(usize),
    /// The number of contacts of a wheel changes from zero to one or two.
    ContactRegained(usize),
    /// A wheel with one contact gets a second one.
    TwoContacts(usize),
    /// Of two contacts one is left.
    OneContact(usize),
    /// A wheel starts to slip with the rim faster than the wheel's centre. A later change of sign
    /// is no event.
    Spins(usize),
    /// A wheel starts to slip with the rim slower than the wheel's centre. A later change of sign
    /// is no event.
    Slides(usize),
    /// A wheel that slipped grips again, without losing its contact in between.
    Grips(usize),
    /// Pin Q reaches an end stop, at theta1 - theta2 in rad.
    StopReached(EndStop, f64),
    /// Pin Q leaves an end stop, at theta1 - theta2 in rad.
    StopLeft(EndStop, f64),
    /// Body or a link begins to touch the ground. The force of this contact is not modelled: from
    /// here on all forces are wrong.
    BarTouches(Bar),
    /// Body or a link is clear of the ground again.
    BarClear(Bar),
}

/// An event at its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Time, s.
    pub time: f64,
    /// Kind.
    pub kind: EventKind,
}

/// Finds the events of a run.
#[derive(Clone, Debug)]
pub struct EventDetector {
    stop: PinStop,
    contacts: [u32; 3],
    wheels: [Option<WheelState>; 3],
    on_stop: bool,
    /// Which bars touch the ground, in the order of [`Bar::ALL`].
    touching: [bool; 4],
}

impl EventDetector {
    /// Share of the slip limit below which a wheel that slipped grips again: a wheel at the limit
    /// slips once, not at every sample.
    const HYSTERESIS: f64 = 0.5;

    /// Creates a detector that assumes one contact per wheel, free end stops and bars clear of the
    /// ground before the first sample; slip states are unknown. A wheel slips beyond the slip limit
    /// of its truth, where T/N has its largest value.
    pub fn new(stop: PinStop) -> Self {
        Self {
            stop,
            contacts: [1; 3],
            wheels: [None; 3],
            on_stop: false,
            touching: [false; 4],
        }
    }

    /// State of a wheel (0 to 2) at the last sample; `None` before the first.
    pub fn wheel(&self, wheel: usize) -> Option<WheelState> {
        self.wheels[wheel]
    }

    /// Looks at the next sample and passes every event to `found`: of the wheels in their order, of
    /// pin Q, of the bars in their order. Without clearances there is no event of a bar.
    pub fn sample(
        &mut self,
        truth: &Truth,
        clearances: Option<&Clearances>,
        found: &mut dyn FnMut(Event),
    ) {
        let time = truth.time;
        let mut at = |kind| found(Event { time, kind });
        for (i, wheel) in truth.wheels.iter().enumerate() {
            let events = [
                self.contact_event(i, wheel.contacts),
                self.slip_event(i, wheel),
            ];
            events.into_iter().flatten().for_each(&mut at);
        }
        self.stop_event(truth).into_iter().for_each(&mut at);
        if let Some(clearances) = clearances {
            self.bar_events(clearances).for_each(at);
        }
    }

    fn contact_event(&mut self, i: usize, now: u32) -> Option<EventKind> {
        let before = std::mem::replace(&mut self.contacts[i], now);
        match (before, now) {
            (before, now) if before == now => None,
            (_, 0) => Some(EventKind::ContactLost(i)),
            (0, _) => Some(EventKind::ContactRegained(i)),
            (_, 1) => Some(EventKind::OneContact(i)),
            _ => Some(EventKind::TwoContacts(i)),
        }
    }

    fn slip_event(&mut self, i: usize, wheel: &WheelTruth) -> Option<EventKind> {
        let before = self.wheels[i];
        let slipped = before == Some(WheelState::Slips);
        let share = if slipped { Self::HYSTERESIS } else { 1.0 };
        let slips = wheel.slip_speed.abs() > share * wheel.slip_limit;
        let state = match (wheel.contacts, slips) {
            (0, _) => WheelState::InTheAir,
            (_, true) => WheelState::Slips,
            (_, false) => WheelState::Grips,
        };
        self.wheels[i] = Some(state);
        match (before, state) {
            (before, state) if before == Some(state) => None,
            (_, WheelState::Slips) if wheel.slip_speed > 0.0 => Some(EventKind::Spins(i)),
            (_, WheelState::Slips) => Some(EventKind::Slides(i)),
            (Some(WheelState::Slips), WheelState::Grips) => Some(EventKind::Grips(i)),
            _ => None,
        }
    }

    fn stop_event(&mut self, truth: &Truth) -> Option<EventKind> {
        let on_stop = truth.stop_torque.abs() > 0.0;
        if std::mem::replace(&mut self.on_stop, on_stop) == on_stop {
            return None;
        }
        let angle = truth.links[0].angle - truth.links[1].angle;
        let stop = EndStop::nearest(&self.stop, angle);
        Some(if on_stop {
            EventKind::StopReached(stop, angle)
        } else {
            EventKind::StopLeft(stop, angle)
        })
    }

    fn bar_events(&mut self, clearances: &Clearances) -> impl Iterator<Item = EventKind> {
        let bars = Bar::ALL.into_iter().zip(clearances.touching);
        bars.zip(&mut self.touching)
            .filter_map(|((bar, touches), touching)| {
                let touches = touches?;
                let before = std::mem::replace(touching, touches);
                (before != touches).then_some(if touches {
                    EventKind::BarTouches(bar)
                } else {
                    EventKind::BarClear(bar)
                })
            })
    }
}

/// Numbers of five kinds of events in a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EventCounts {
    /// A wheel lost its contact.
    pub contact_lost: u64,
    /// Changes of a wheel from one contact to two.
    pub two_contacts: u64,
    /// A wheel began to slip.
    pub slips: u64,
    /// Pin Q reached an end stop.
    pub end_stops: u64,
    /// Body or a link began to touch the ground; `None` where the clearance was not measured.
    pub touches: Option<u64>,
}

impl EventCounts {
    /// Counts an event.
    pub fn add(&mut self, event: &Event) {
        match event.kind {
            EventKind::ContactLost(_) => self.contact_lost += 1,
            EventKind::TwoContacts(_) => self.two_contacts += 1,
            EventKind::Spins(_) | EventKind::Slides(_) => self.slips += 1,
            EventKind::StopReached(..) => self.end_stops += 1,
            EventKind::BarTouches(_) => *self.touches.get_or_insert(0) += 1,
            EventKind::ContactRegained(_)
            | EventKind::OneContact(_)
            | EventKind::Grips(_)
            | EventKind::StopLeft(..)
            | EventKind::BarClear(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STOP: PinStop = PinStop {
        lower: -0.7,
        upper: 0.6,
        stiffness: 2000.0,
        damping: 20.0,
    };

    fn truth(time: f64, contacts: u32, slip_speed: f64, stop_torque: f64) -> Truth {
        let mut truth = Truth {
            time,
            stop_torque,
            ..Truth::default()
        };
        for wheel in &mut truth.wheels {
            wheel.contacts = 1;
        }
        truth.wheels[1].contacts = contacts;
        truth.wheels[1].slip_speed = slip_speed;
        truth.wheels[1].slip_limit = 0.02;
        truth.links[0].angle = 0.61;
        truth
    }

    /// Every change is found once, with its time, and a wheel near the slip limit does not flicker.
    #[test]
    fn every_change_is_found_once() {
        let mut detector = EventDetector::new(STOP);
        let mut found = Vec::new();
        let samples = [
            (1, 0.0, 0.0),
            (1, 0.021, 0.0),
            (1, 0.015, 0.0),
            (1, 0.009, 0.0),
            (0, 0.0, 0.0),
            (2, -0.03, 0.0),
            (1, 0.0, 3.0),
            (1, 0.0, 0.0),
        ];
        for (k, (contacts, slip, stop)) in (0_u32..).zip(samples) {
            detector.sample(&truth(f64::from(k), contacts, slip, stop), None, &mut |e| {
                found.push((e.time, e.kind));
            });
        }
        let expected = [
            (1.0, EventKind::Spins(1)),
            (3.0, EventKind::Grips(1)),
            (4.0, EventKind::ContactLost(1)),
            (5.0, EventKind::ContactRegained(1)),
            (5.0, EventKind::Slides(1)),
            (6.0, EventKind::OneContact(1)),
            (6.0, EventKind::Grips(1)),
            (6.0, EventKind::StopReached(EndStop::Upper, 0.61)),
            (7.0, EventKind::StopLeft(EndStop::Upper, 0.61)),
        ];
        assert_eq!(found, expected);
        assert_eq!(detector.wheel(1), Some(WheelState::Grips));
        let mut counts = EventCounts::default();
        for (time, kind) in found {
            counts.add(&Event { time, kind });
        }
        assert_eq!(
            (counts.contact_lost, counts.slips, counts.end_stops),
            (1, 2, 1)
        );
    }

    /// By hand: the body touches twice, link 3 once meanwhile; a clearance that is not a number
    /// changes nothing.
    #[test]
    fn every_touch_of_a_bar_is_found_once() {
        let mut detector = EventDetector::new(STOP);
        let (mut found, mut counts) = (Vec::new(), EventCounts::default());
        let samples = [
            [0.1, 0.1],
            [0.0, 0.1],
            [f64::NAN, 0.1],
            [0.0, -0.01],
            [0.2, 0.0],
            [-0.1, 0.1],
        ];
        for (k, [body, link3]) in (0_u32..).zip(samples) {
            let clearances = Clearances::of([body, 0.3, 0.3, link3]);
            let truth = truth(f64::from(k), 1, 0.0, 0.0);
            detector.sample(&truth, Some(&clearances), &mut |event| {
                counts.add(&event);
                found.push((event.time, event.kind));
            });
        }
        let expected = [
            (1.0, EventKind::BarTouches(Bar::Body)),
            (3.0, EventKind::BarTouches(Bar::Link3)),
            (4.0, EventKind::BarClear(Bar::Body)),
            (5.0, EventKind::BarTouches(Bar::Body)),
            (5.0, EventKind::BarClear(Bar::Link3)),
        ];
        assert_eq!(found, expected);
        assert_eq!(counts.touches, Some(3));
    }
}
