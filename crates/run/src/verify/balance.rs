//! Momentum and energy of a run, from the integrals that the engines carry, and differences between
//! two runs of one scene.

use robhaz_model::{Bar, Robot, Vec2};
use robhaz_sim::{Balance, Truth, mechanical_energy};

/// Momentum of bars and wheels, N s.
fn momentum(robot: &Robot, truth: &Truth) -> Vec2 {
    let bars = Bar::ALL.map(|bar| truth.bar(bar).velocity * robot.mass.of(bar).0);
    let wheels = [0, 1, 2].map(|i| truth.wheel_velocity(robot, i) * robot.mass.wheel);
    bars.iter().sum::<Vec2>() + wheels.iter().sum::<Vec2>()
}

/// The larger of two numbers; NaN if one of them is NaN.
fn greater(most: f64, found: f64) -> f64 {
    if most.is_nan() || found <= most {
        most
    } else {
        found
    }
}

/// Momentum error, -: largest difference over the records between the change of momentum and the
/// impulse of ground and gravity, relative to weight times duration.
pub fn momentum_error(robot: &Robot, truth: &[Truth], balance: &[Balance]) -> f64 {
    let (Some(first), Some(last)) = (truth.first(), truth.last()) else {
        return f64::NAN;
    };
    let weight = robot.mass.total() * robot.gravity;
    let ground = |b: &Balance| b.impulse.iter().sum::<Vec2>();
    let start = balance.first().map_or(Vec2::zeros(), ground);
    let errors = truth.iter().zip(balance).map(|(now, balance)| {
        let gravity = Vec2::new(0.0, -weight * (now.time - first.time));
        let gained = momentum(robot, now) - momentum(robot, first);
        (ground(balance) - start + gravity - gained).norm()
    });
    errors.fold(0.0, greater) / (weight * (last.time - first.time))
}

/// Energy balance of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// Work of the motors, J.
    pub motors: f64,
    /// Largest residual of the balance over the records, relative to its scale: see [`energy`], -.
    pub relative_error: f64,
}

/// Energy balance of a run.
///
/// The scale is the largest of the motors' work, the losses and the gain, but at least weight times
/// wheel radius (13.7 J for the default robot), because a parked robot has no energy turnover at
/// all. A thousandth of this floor lifts the robot by 0.1 mm.
pub fn energy(robot: &Robot, truth: &[Truth], balance: &[Balance]) -> Energy {
    let losses = |b: &Balance| b.gear_loss - b.ground_work - b.stop_work;
    let start = balance.first().copied().unwrap_or_default();
    let initial = truth.first().map(|t| mechanical_energy(robot, t));
    let since = |now: &Truth, b: &Balance| {
        [
            b.motor_work - start.motor_work,
            losses(b) - losses(&start),
            mechanical_energy(robot, now) - initial.unwrap_or(f64::NAN),
        ]
    };
    let left = truth.iter().zip(balance).map(|(now, balance)| {
        let [motors, losses, gain] = since(now, balance);
        (motors - losses - gain).abs()
    });
    let last = truth.last().zip(balance.last());
    let whole = last.map_or([f64::NAN; 3], |(now, balance)| since(now, balance));
    let floor = robot.mass.total() * robot.gravity * robot.geometry.wheel_radius;
    let scale = whole.iter().fold(floor, |s, e| s.max(e.abs()));
    Energy {
        motors: whole[0],
        relative_error: left.fold(0.0, greater) / scale,
    }
}

/// Differences between two runs of one scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// RMS difference of N over wheels and records, relative to the mean of N, -.
    pub normal_force: f64,
    /// Distance between the bodies at the end, m.
    pub apart: f64,
}

/// Compares two runs, record by record.
pub fn agreement(a: &[Truth], b: &[Truth]) -> Agreement {
    let (mut square, mut sum, mut count) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        for (a, b) in a.wheels.iter().zip(&b.wheels) {
            square += (a.normal_force - b.normal_force).powi(2);
            sum += b.normal_force;
            count += 1.0;
        }
    }
    let apart = match (a.last(), b.last()) {
        (Some(a), Some(b)) => (a.body.position - b.body.position).norm(),
        _ => f64::NAN,
    };
    Agreement {
        normal_force: f64::sqrt(square / count) / (sum / count),
        apart,
    }
}

/// Largest relative difference, over the wheels, of the ground's impulse on a wheel in two runs of
/// equal length, -.
///
/// The impulses are those that the engines integrate, so impacts between records are included.
pub fn impulse_difference(a: &Balance, b: &Balance) -> f64 {
    let pairs = a.impulse.iter().zip(&b.impulse);
    let differences = pairs.map(|(a, b)| (a - b).norm() / b.norm());
    differences.fold(0.0, greater)
}
