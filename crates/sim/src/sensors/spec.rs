//! Parameters of the sensor models, and named grades.

use robhaz_model::named;

/// Counts of the encoder per turn of the wheel: 500 pulses of the motor's encoder, four edges each,
/// gear 80:1.
pub const ENCODER_COUNTS: f64 = 500.0 * 4.0 * 80.0;

/// Parameters of all sensors. A value of 0 switches its error off; with every error off, readings
/// equal the truth.
///
/// A "drawn" error is constant: it is drawn once per run and sensor from a normal distribution with
/// mean 0, and the parameter is its standard deviation. For white noise the parameter is the
/// standard deviation of one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorSpec {
    /// Counts of the encoder per turn of the wheel; 0 for an exact angle.
    pub encoder_counts: f64,
    /// Relative gain error of the torque, -, drawn.
    pub torque_gain: f64,
    /// Offset of the torque, N m, drawn.
    pub torque_offset: f64,
    /// White noise of the torque, N m.
    pub torque_noise: f64,
    /// Quantisation step of the motor current, as a torque at the wheel, N m.
    pub torque_step: f64,
    /// Coulomb friction F in the reading alone, not in the plant, N m: the reading contains tau + F
    /// sign(omega).
    pub torque_friction: f64,
    /// Where inclinometers and gyros sit.
    pub imu: ImuPlace,
    /// White noise of the angle sensor in pin Q, rad; of an IMU in the body only.
    pub pin_noise: f64,
    /// Bias of that sensor, rad, drawn.
    pub pin_bias: f64,
    /// White noise of the inclinometers, rad.
    pub inclination_noise: f64,
    /// Bias of the inclinometers, rad, drawn.
    pub inclination_bias: f64,
    /// Time constant of the inclinometers' low pass, s.
    pub inclination_lag: f64,
    /// Whether inclinometers measure the specific force, which contains their link's acceleration,
    /// or gravity alone.
    pub specific_force: bool,
    /// White noise of the gyros, rad/s.
    pub rate_noise: f64,
    /// Bias of the gyros at the start, rad/s, drawn.
    pub rate_bias: f64,
    /// Random walk of the gyros' bias, (rad/s)/sqrt(s).
    pub rate_walk: f64,
    /// Relative scale error of the gyros, -, drawn.
    pub rate_scale: f64,
    /// Standard deviation of the error of the given contact angles, rad.
    pub contact_angle_error: f64,
    /// Correlation time of the contact angles' error, s; 0 for white noise.
    pub contact_angle_time: f64,
    /// Jitter: standard deviation of the sampling time about the time stamp, s.
    pub jitter: f64,
    /// Probability that a reading of a channel is lost, -.
    pub dropped: f64,
}

named! {
    /// Where inclinometers and gyros sit.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum ImuPlace {
        /// One of each on link 1 and on link 2.
        #[default]
        Links = "links",
        /// One of each in the body, and an angle sensor in pin Q.
        Body = "body",
    }
}

named! {
    /// Named sets of sensor parameters.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Grade {
        /// Ideal sensors: readings equal the truth.
        Ideal = "ideal",
        /// Typical sensors of a research robot: the robot's own encoder, calibrated current
        /// measurement, industrial inclinometers, a MEMS gyro zeroed at rest.
        ///
        /// - torque: gain error 2 %, offset and noise 0.1 N m each (1 % of the drive's limit). Assumed:
        ///   a Hall current sensor of the class of the ACS712 (total error 1.5 % at room temperature),
        ///   and a gear efficiency known about as well.
        /// - inclinometer: noise 0.1 deg; bias 0.1 deg, mounting and zero error together. Assumed; a
        ///   MEMS inclinometer itself resolves 0.0035 deg in 10 Hz (data sheet of the SCA100T).
        /// - angle of pin Q: noise and bias 0.1 deg each, a step of an ADC of 12 bits over a turn.
        ///   Assumed.
        /// - gyro: noise 0.1 deg/s per sample at 1 kHz: the density 0.005 deg/s/sqrt(Hz) of a consumer
        ///   MEMS gyro (data sheet of the MPU-6050) over 500 Hz.
        /// - contact angles: 2 deg RMS with a correlation time of 0.3 s. Assumed: at 0.2 m/s that is 60
        ///   mm of ground and an error of 2 mm in height over that length.
        Typical = "typical",
        /// Low-cost sensors without calibration, read by a heavily loaded computer: about three times
        /// the errors of `typical`, and further errors.
        ///
        /// - encoder: one edge per pulse is counted instead of four.
        /// - torque: gain error 6 %, offset and noise 0.3 N m each; quantisation step 0.04 N m: an ADC
        ///   of 10 bits over +-20 N m, twice the drive's limit.
        /// - inclinometer: noise and bias 0.3 deg each; lag 20 ms, a low pass of 8 Hz, the lower end of
        ///   8 to 28 Hz of an over-damped MEMS inclinometer (data sheet of the SCA100T).
        /// - gyro: noise 0.3 deg/s per sample. Scale error 1 %: the tolerance of +-3 % of a consumer
        ///   MEMS gyro (MPU-6050) taken as three standard deviations. Bias 0.3 deg/s after zeroing and
        ///   a random walk of 0.01 deg/s/sqrt(s), 0.6 deg/s in an hour: assumed, well inside the +-20
        ///   deg/s over temperature of the same data sheet.
        /// - contact angles: 6 deg RMS.
        /// - sampling: jitter 20 us, assumed for a heavily loaded real-time computer. It affects
        ///   differences of angles most: at 2 rad/s and 1 kHz it is 3 % of the speed. 1 % of the
        ///   readings are lost.
        Poor = "poor",
    }
}

impl Grade {
    /// The sensors of this grade.
    pub fn sensors(self) -> SensorSpec {
        match self {
            Self::Ideal => SensorSpec {
                contact_angle_time: 0.3,
                ..SensorSpec::default()
            },
            Self::Typical => SensorSpec {
                encoder_counts: ENCODER_COUNTS,
                torque_gain: 0.02,
                torque_offset: 0.1,
                torque_noise: 0.1,
                pin_noise: 0.1_f64.to_radians(),
                pin_bias: 0.1_f64.to_radians(),
                inclination_noise: 0.1_f64.to_radians(),
                inclination_bias: 0.1_f64.to_radians(),
                specific_force: true,
                rate_noise: 0.1_f64.to_radians(),
                contact_angle_error: 2.0_f64.to_radians(),
                ..Self::Ideal.sensors()
            },
            Self::Poor => SensorSpec {
                encoder_counts: ENCODER_COUNTS / 4.0,
                torque_gain: 0.06,
                torque_offset: 0.3,
                torque_noise: 0.3,
                torque_step: 0.04,
                pin_noise: 0.3_f64.to_radians(),
                pin_bias: 0.3_f64.to_radians(),
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
                ..Self::Typical.sensors()
            },
        }
    }
}
