//! Two runs of one scene, held against each other.

use robhaz_sim::Truth;

/// How far two runs of one scene are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// RMS difference of N over wheels and records, over the mean N, -.
    pub normal_force: f64,
    /// Greatest difference of a wheel's impulse of N over the run, of itself, -.
    pub impulse: f64,
    /// Distance of the bodies at the end, m.
    pub apart: f64,
}

/// Compares two runs, record by record.
pub fn agreement(a: &[Truth], b: &[Truth]) -> Agreement {
    let (mut square, mut sums, mut count) = (0.0, [[0.0; 3]; 2], 0.0);
    for (a, b) in a.iter().zip(b) {
        for (i, (a, b)) in a.wheels.iter().zip(&b.wheels).enumerate() {
            square += (a.normal_force - b.normal_force).powi(2);
            sums[0][i] += a.normal_force;
            sums[1][i] += b.normal_force;
            count += 1.0;
        }
    }
    let mean = sums[1].iter().sum::<f64>() / count;
    let impulse = (0..3)
        .map(|i| (sums[0][i] / sums[1][i] - 1.0).abs())
        .fold(0.0, f64::max);
    let apart = match (a.last(), b.last()) {
        (Some(a), Some(b)) => (a.body.position - b.body.position).norm(),
        _ => f64::NAN,
    };
    Agreement {
        normal_force: f64::sqrt(square / count) / mean,
        impulse,
        apart,
    }
}
