//! How good sensors are: every parameter of every model, and named grades of them.

/// Counts of the encoder in a turn of the wheel: 500 pulses of the motor's encoder, four edges each, gear 80:1.
pub const ENCODER_COUNTS: f64 = 500.0 * 4.0 * 80.0;

/// The parameters of all sensors. Where a value is 0, that error is not there; with all of them 0 readings are the truth.
///
/// "Drawn" means once a run and sensor, from a normal distribution of this standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorSpec {
    /// Counts of the encoder in a turn of the wheel; 0 for an exact angle.
    pub encoder_counts: f64,
    /// Error of the torque's scale, relative, drawn.
    pub torque_gain: f64,
    /// Offset of the torque, N m, drawn.
    pub torque_offset: f64,
    /// White noise of the torque in a sample, N m.
    pub torque_noise: f64,
    /// Step in which the motor current is read, as a torque at the wheel, N m.
    pub torque_step: f64,
    /// Coulomb friction F that the reading holds although the plant has none, N m: tau + F sign(omega).
    pub torque_friction: f64,
    /// White noise of the inclinometers in a sample, rad.
    pub inclination_noise: f64,
    /// Bias of the inclinometers, rad, drawn.
    pub inclination_bias: f64,
    /// Time constant of the inclinometers' low pass, s.
    pub inclination_lag: f64,
    /// Whether inclinometers feel the acceleration of their link as well as gravity.
    pub specific_force: bool,
    /// White noise of the gyros in a sample, rad/s.
    pub rate_noise: f64,
    /// Bias of the gyros at the start, rad/s, drawn.
    pub rate_bias: f64,
    /// Random walk of the gyros' bias, rad/s in the square root of a second.
    pub rate_walk: f64,
    /// Error of the gyros' scale, relative, drawn.
    pub rate_scale: f64,
    /// Error of the contact angles that are given, RMS, rad.
    pub contact_angle_error: f64,
    /// Correlation time of that error, s; 0 for white noise.
    pub contact_angle_time: f64,
    /// Standard deviation of the time of sampling about the time stamp, s.
    pub jitter: f64,
    /// Share of the readings of each channel that are missing.
    pub dropped: f64,
}

impl SensorSpec {
    /// Readings are the truth.
    pub const fn ideal() -> Self {
        Self {
            encoder_counts: 0.0,
            torque_gain: 0.0,
            torque_offset: 0.0,
            torque_noise: 0.0,
            torque_step: 0.0,
            torque_friction: 0.0,
            inclination_noise: 0.0,
            inclination_bias: 0.0,
            inclination_lag: 0.0,
            specific_force: false,
            rate_noise: 0.0,
            rate_bias: 0.0,
            rate_walk: 0.0,
            rate_scale: 0.0,
            contact_angle_error: 0.0,
            contact_angle_time: 0.3,
            jitter: 0.0,
            dropped: 0.0,
        }
    }

    /// Sensors as one builds them into a research robot: the robot's own encoder, calibrated current sensing, industrial
    /// inclinometers, a MEMS gyro zeroed at rest.
    ///
    /// - torque: 2 % and 0.1 N m (1 % of the drive's limit), offset and noise alike: a Hall current sensor (the ACS712 class: total
    ///   error 1.5 % at room temperature) and a gear whose efficiency is known about as well; a chosen class.
    /// - inclinometer: 0.1 deg of noise, and of mounting and zero error together: a chosen class. A MEMS inclinometer resolves
    ///   far less (data sheet of the SCA100T: 0.0035 deg in 10 Hz); it is not what limits.
    /// - gyro: 0.1 deg/s in a sample at 1 kHz, the noise density 0.005 deg/s/sqrt(Hz) of a consumer MEMS gyro (data sheet of
    ///   the MPU-6050) over 500 Hz.
    /// - contact angles: 2 deg RMS over 0.3 s, 60 mm of ground at 0.2 m/s: a chosen class, 2 mm of
    ///   height over that length.
    pub const fn typical() -> Self {
        Self {
            encoder_counts: ENCODER_COUNTS,
            torque_gain: 0.02,
            torque_offset: 0.1,
            torque_noise: 0.1,
            inclination_noise: 0.1_f64.to_radians(),
            inclination_bias: 0.1_f64.to_radians(),
            specific_force: true,
            rate_noise: 0.1_f64.to_radians(),
            contact_angle_error: 2.0_f64.to_radians(),
            ..Self::ideal()
        }
    }

    /// Cheap sensors, not calibrated, read by a busy computer: about three times the errors of
    /// [`Self::typical`], and those that it leaves out.
    ///
    /// - encoder: one edge a pulse is counted instead of four.
    /// - torque: 6 %, 0.3 N m; read in steps of 0.04 N m: an ADC of 10 bits over +-20 N m, twice the drive's limit.
    /// - inclinometer: 0.3 deg; lag 20 ms, a low pass of 8 Hz, the low end of 8 to 28 Hz of an over-damped MEMS inclinometer
    ///   (data sheet of the SCA100T).
    /// - gyro: 0.3 deg/s in a sample; scale 1 %, the tolerance of +-3 % of a consumer MEMS gyro (MPU-6050) taken as three
    ///   standard deviations; bias 0.3 deg/s left after zeroing and a walk of 0.01 deg/s/sqrt(s), 0.6 deg/s in an
    ///   hour: chosen classes, well inside the +-20 deg/s over temperature of the same data sheet.
    /// - contact angles: 6 deg RMS.
    /// - sampling: jitter 20 us, a chosen class for a busy real-time computer; differences of angles feel it most: at 2 rad/s and
    ///   1 kHz it is 3 % of the speed. 1 % of the readings lost on the way.
    pub const fn poor() -> Self {
        Self {
            encoder_counts: ENCODER_COUNTS / 4.0,
            torque_gain: 0.06,
            torque_offset: 0.3,
            torque_noise: 0.3,
            torque_step: 0.04,
            inclination_noise: 0.3_f64.to_radians(),
            inclination_bias: 0.3_f64.to_radians(),
            inclination_lag: 0.02,
            rate_noise: 0.3_f64.to_radians(),
            rate_bias: 0.3_f64.to_radians(),
            rate_walk: 0.01_f64.to_radians(),
            rate_scale: 0.01,
            contact_angle_error: 6.0_f64.to_radians(),
            jitter: 2e-5,
            dropped: 0.01,
            ..Self::typical()
        }
    }
}

/// A name for how good the sensors are and how well the robot is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grade {
    /// Readings are the truth: [`SensorSpec::ideal`].
    Ideal,
    /// [`SensorSpec::typical`]
    Typical,
    /// [`SensorSpec::poor`]
    Poor,
}

impl Grade {
    /// All grades, from the best to the worst.
    pub const ALL: [Self; 3] = [Self::Ideal, Self::Typical, Self::Poor];

    /// Name in scene files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ideal => "ideal",
            Self::Typical => "typical",
            Self::Poor => "poor",
        }
    }

    /// The sensors of this grade.
    pub const fn sensors(self) -> SensorSpec {
        match self {
            Self::Ideal => SensorSpec::ideal(),
            Self::Typical => SensorSpec::typical(),
            Self::Poor => SensorSpec::poor(),
        }
    }
}
