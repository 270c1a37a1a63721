//! Readings of scales and inclinations, and how exact they are.

/// Readings of one posture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Its line in the table, for messages. Simulated readings have the line that they get in a
    /// table of their own.
    pub line: u64,
    /// Inclinations of links 1 and 2 from the nominal pose, rad, nose up positive.
    pub inclinations: [f64; 2],
    /// Vertical force of the front, middle and rear wheel on its scale, N; `None` for a wheel on a
    /// plain block.
    pub forces: [Option<f64>; 3],
}

/// All readings of a weighing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurements {
    /// One for each posture.
    pub readings: Vec<Reading>,
    /// Weight of the whole robot (one side), N.
    pub weight: Option<f64>,
    /// Left less right forces of the postures with scales under both sides, whose mean is in
    /// [`Self::readings`].
    pub differences: Vec<Reading>,
}

impl Measurements {
    /// Number of readings of scales.
    pub fn count(&self) -> usize {
        let forces = self.readings.iter().flat_map(|r| r.forces);
        forces.flatten().count() + usize::from(self.weight.is_some())
    }
}

/// Standard deviations of the errors of a weighing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Of a scale's reading, N. Errors of readings are independent.
    pub scale: f64,
    /// Relative error of each scale, the same in all its readings. A wheel keeps its scale.
    pub scale_gain: f64,
    /// Constant error of each scale, N, such as a tare that is off.
    pub scale_zero: f64,
    /// Constant error of the inclinations of a link, rad: the same in all postures, independent for
    /// both links.
    pub inclination_offset: f64,
    /// Error of an inclination in one posture, rad.
    pub inclination: f64,
    /// Horizontal force between a wheel and its plate, N. The three sum to 0.
    pub horizontal_force: f64,
}

impl Accuracy {
    /// Variance of a scale that shows `force` (N) by its gain and zero, N^2.
    pub(crate) fn of_constant(&self, force: f64) -> f64 {
        (self.scale_gain * force).powi(2) + self.scale_zero.powi(2)
    }

    /// What a scale shows of `force` (N) with its errors over their standard deviations.
    pub(crate) fn shown(&self, force: f64, [gain, zero]: [f64; 2]) -> f64 {
        force * (1.0 + self.scale_gain * gain) + self.scale_zero * zero
    }

    /// Errors of gain and zero of a scale over their standard deviations. Nothing is drawn for one
    /// that is not stated.
    pub(crate) fn draw_scale(&self, normal: &mut impl FnMut() -> f64) -> [f64; 2] {
        [self.scale_gain, self.scale_zero].map(|sigma| if sigma > 0.0 { normal() } else { 0.0 })
    }

    /// Calibrated scales to 20 g, inclinometers like those of [`robhaz_estimator::NoiseBudget::typical`]
    /// averaged over seconds (an offset of 0.1 deg, 0.03 deg from posture to posture), wheels that
    /// turn freely or plates on balls: 0.2 N.
    pub const TYPICAL: Self = Self {
        scale: 0.2,
        scale_gain: 0.0,
        scale_zero: 0.0,
        inclination_offset: 0.1 * DEGREE,
        inclination: 0.03 * DEGREE,
        horizontal_force: 0.2,
    };
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
