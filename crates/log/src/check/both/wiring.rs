//! Wirings of left and right, signs and sizes of readings of both sides.

use super::SIDE_NAMES;
use robhaz_estimator::whole::WholeFrame;
use robhaz_scene::coupling_angle;

/// What to do about the axes of the body's sensor.
const AXES: &str =
    "exchange the columns of body_inclination and body_roll, and of body_rate and body_roll_rate";

/// What to do about front and rear wheels.
pub const ENDS: &str =
    "exchange the columns of wheel1 and wheel3 of both sides, angles, torques and steering";

/// A change of the readings; wheels 0 to 2 of both sides.
#[derive(Clone, Copy, PartialEq)]
pub enum Change {
    /// Encoders of left and right are exchanged.
    Angle(usize),
    /// Torques are.
    Torque(usize),
    /// Pins are.
    Pins,
    /// The pin of a side counts the other way: of the left side, 0, or of the right one.
    Pin(usize),
    /// The angle of differential or rear bogie is so many times as large, or (-1) counts the other way.
    Coupling(f64),
    /// Roll and its rate do.
    Roll,
    /// Roll and inclination are exchanged, and their rates.
    Axes,
    /// The same of a sensor that is turned about its vertical axis: by a right angle to the left, or to the right.
    Turned(f64),
    /// Front and rear wheels are exchanged, on both sides.
    Ends,
    /// All torques are so many times as large.
    Torques(f64),
    /// Those of a side are, of the left one, 0, or of the right one.
    TorquesOf(usize, f64),
    /// The angles of both pins are so many times as large.
    PinsSize(f64),
    /// The gears have this efficiency: a setting of the estimator, and none of the readings.
    Gears(f64),
}

use Change::{Angle, Axes, Coupling, Ends, Pin, Pins, Roll, Torque, Turned};

/// As wired, then all others that are tried, those with fewer changes first.
pub fn wirings() -> Vec<Vec<Change>> {
    type Of = fn(usize) -> Change;
    let of = |wheels: &[usize], changes: &[Of]| -> Vec<Change> {
        let each = |change: &Of| wheels.iter().map(|i| change(*i)).collect::<Vec<_>>();
        changes.iter().flat_map(each).collect()
    };
    let kinds: [&[Of]; 3] = [&[Torque], &[Angle], &[Angle, Torque]];
    let [.., both] = kinds;
    let mut all = vec![Vec::new()];
    for i in 0..3 {
        all.extend(kinds.map(|changes| of(&[i], changes)));
    }
    let of_body = [Roll, Axes, Turned(1.0), Turned(-1.0)];
    all.extend([Pins, Pin(0), Pin(1), Coupling(-1.0)].map(|change| vec![change]));
    all.extend(of_body.map(|change| vec![change]));
    // The wheels of a bogie, in front or behind.
    all.extend([of(&[0, 1], both), of(&[1, 2], both)]);
    all.extend(kinds.map(|changes| of(&[0, 1, 2], changes)));
    all.push([of(&[0, 1, 2], both), vec![Pins]].concat());
    all.push(vec![Ends]);
    all
}

impl Change {
    fn apply(self, frame: &mut WholeFrame) {
        match self {
            Angle(i) => frame.wheel_angle.swap(i, i + 3),
            Torque(i) => frame.motor_torque.swap(i, i + 3),
            Pins => frame.pins.swap(0, 1),
            Pin(side) => scale(frame.pins.get_mut(side), -1.0),
            Ends => {
                for k in [0, 3] {
                    frame.wheel_angle.swap(k, k + 2);
                    frame.motor_torque.swap(k, k + 2);
                    frame.steering.swap(k, k + 2);
                }
            }
            Self::Torques(size) => scale(&mut frame.motor_torque, size),
            Self::TorquesOf(side, size) => {
                scale(frame.motor_torque.iter_mut().skip(3 * side).take(3), size);
            }
            Coupling(size) => scale([&mut frame.coupling], size),
            Self::PinsSize(size) => scale(&mut frame.pins, size),
            Axes => {
                std::mem::swap(&mut frame.roll, &mut frame.inclination);
                frame.rates.swap(0, 1);
            }
            Turned(way) => {
                Axes.apply(frame);
                let [roll_rate, rate, _] = &mut frame.rates;
                scale([&mut frame.roll, roll_rate], way);
                scale([&mut frame.inclination, rate], -way);
            }
            Roll => scale([&mut frame.roll, &mut frame.rates[0]], -1.0),
            Self::Gears(_) => {}
        }
    }

    /// What to do, in words.
    pub fn words(self, coupling: robhaz_model::Coupling) -> String {
        let exchange = |part: &str| format!("exchange the columns of left_{part} and right_{part}");
        match self {
            Angle(i) => exchange(&format!("wheel{}_angle", i + 1)),
            Torque(i) => exchange(&format!("wheel{}_motor_torque", i + 1)),
            Pins => exchange("pin_angle"),
            Pin(side) => format!("turn the sign of {}_pin_angle", SIDE_NAMES[side]),
            Ends => ENDS.to_owned(),
            Coupling(..0.0) => format!("turn the sign of {}", coupling_angle(coupling)),
            Coupling(size) => format!("take {size:.2} of {}", coupling_angle(coupling)),
            Axes => AXES.to_owned(),
            Turned(way) => {
                let (of, forward) = match way > 0.0 {
                    true => ("body_inclination and body_rate", "-y"),
                    false => ("body_roll and body_roll_rate", "y"),
                };
                format!(
                    "{AXES}; then turn the signs of {of}: the sensor is mounted across (of imu.body with forward = \"x\": state forward = \"{forward}\")"
                )
            }
            Roll => "turn the signs of body_roll and body_roll_rate".to_owned(),
            Self::Torques(size) => format!("take {size:.2} of all torques"),
            Self::TorquesOf(side, size) => {
                format!("take {size:.2} of all {} torques", SIDE_NAMES[side])
            }
            Self::PinsSize(size) => format!("take {size:.2} of both pin angles"),
            Self::Gears(efficiency) => format!("state drive.gear_efficiency = {efficiency:.1}"),
        }
    }
}

fn scale<'a>(values: impl IntoIterator<Item = &'a mut Option<f64>>, by: f64) {
    let values = values.into_iter().flatten();
    values.for_each(|value| *value *= by);
}

/// A frame that is wired so.
pub fn wired(frame: &WholeFrame, wiring: &[Change]) -> WholeFrame {
    let mut wired = *frame;
    wiring.iter().for_each(|change| change.apply(&mut wired));
    wired
}

/// Whether each torque then answers its own encoder.
pub fn fits(wiring: &[Change], follows: [Option<bool>; 3]) -> bool {
    let is_one = |i: usize| wiring.contains(&Angle(i)) != wiring.contains(&Torque(i));
    (0..3).all(|i| follows[i].is_none_or(|follows| follows != is_one(i)))
}

/// Whether it is of pins and coupling, of everything, or of the axes of the body's sensor: what the misfit shows.
pub fn is_of_joints(wiring: &[Change]) -> bool {
    let is_of_joints = |c: &Change| matches!(c, Pins | Pin(_) | Coupling(_) | Axes | Turned(_));
    wiring.iter().any(is_of_joints)
}

/// Whether it is of the axes of the body's sensor.
pub fn is_of_axes(wiring: &[Change]) -> bool {
    wiring.iter().any(|c| matches!(c, Axes | Turned(_)))
}

/// What to do, in words.
pub fn words(wiring: &[Change], coupling: robhaz_model::Coupling) -> String {
    let words: Vec<String> = wiring.iter().map(|change| change.words(coupling)).collect();
    words.join("; ")
}
