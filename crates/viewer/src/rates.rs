//! How many records of a run a recording keeps.

use robhaz_run::RunDescription;

/// Rate of the animation, Hz of simulated time.
const FRAME_RATE: f64 = 60.0;
/// Rate of the time series, Hz of simulated time: every eighth record at 1 kHz.
const SERIES_RATE: f64 = 125.0;
/// Longest planned duration of a run that is recorded at these rates, s: some 30 MB. A longer run
/// keeps as many frames and rows.
const FULL_RATE_TIME: f64 = 120.0;

/// Factor by which the recording of a run is thinned in time: 1 up to 120 s, in proportion to the
/// planned duration beyond.
pub(crate) fn thinning(run: &RunDescription) -> f64 {
    let factor = run.record.duration / FULL_RATE_TIME;
    if factor.is_finite() {
        factor.max(1.0)
    } else {
        1.0
    }
}

/// Rates of the time series and of the animation with a thinning, Hz of simulated time.
pub(crate) fn rates(thinning: f64) -> [f64; 2] {
    [SERIES_RATE / thinning, FRAME_RATE / thinning]
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_scene::Scene;

    /// Closed form: a run of any length keeps at most the rows and frames of one of two minutes.
    #[test]
    fn long_runs_have_recordings_of_a_bounded_size() {
        let mut run = RunDescription::of(&Scene::default()).expect("a robot");
        for (duration, expected) in [
            (20.0, 1.0),
            (120.0, 1.0),
            (3600.0, 30.0),
            (1e6, 1e6 / 120.0),
        ] {
            run.record.duration = duration;
            let factor = thinning(&run);
            assert!((factor - expected).abs() < 1e-9, "{duration} s: {factor}");
            for (rate, most) in rates(factor).into_iter().zip([15_000.0, 7_200.0]) {
                assert!(rate * duration <= most + 1e-6, "{duration} s: {rate} Hz");
            }
        }
    }
}
