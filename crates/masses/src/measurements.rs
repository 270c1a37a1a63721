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
    /// Constant error of the inclinations of a link, rad: the same in all postures, independent for
    /// both links.
    pub inclination_offset: f64,
    /// Error of an inclination in one posture, rad.
    pub inclination: f64,
    /// Horizontal force between a wheel and its plate, N. The three sum to 0.
    pub horizontal_force: f64,
}

impl Accuracy {
    /// Scales to 20 g, inclinometers like those of [`robhaz_estimator::NoiseBudget::typical`]
    /// averaged over seconds (an offset of 0.1 deg, 0.03 deg from posture to posture), wheels that
    /// turn freely or plates on balls: 0.2 N.
    pub const TYPICAL: Self = Self {
        scale: 0.2,
        inclination_offset: 0.1 * DEGREE,
        inclination: 0.03 * DEGREE,
        horizontal_force: 0.2,
    };
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
