//! Angles and rates of links 1 and 2 from an inertial sensor in the body and the angle of pin Q, as
//! rovers have them.

use crate::{Geometry, PathAngle, Posture, Suspension};

/// Readings of one sample; `None` where one is missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyReading {
    /// Turn of the body from the nominal pose, rad, nose up positive.
    pub inclination: Option<f64>,
    /// Angular rate of the body, rad/s, nose up positive.
    pub rate: Option<f64>,
    /// Angle theta_1 - theta_2 of pin Q from the nominal pose, rad.
    pub pin: Option<f64>,
    /// Turns of the wheels relative to their links, rad.
    pub wheels: [Option<f64>; 3],
}

/// Readings of the inclinometer and the rate gyroscope on one link; `None` where a reading is
/// missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkReading {
    /// Turn from the nominal pose, rad, counter-clockwise.
    pub inclination: Option<f64>,
    /// Angular rate, rad/s, counter-clockwise.
    pub rate: Option<f64>,
    /// Standard deviation of the rate beyond the noise of a gyroscope, rad/s: of a rate that follows
    /// from the angle of a joint, as [`BodyMount`] gives it. 0 of a gyroscope on the link.
    pub rate_error: f64,
}

/// The angle of pin Q gives the shape of the linkage, and with it the angle of each link against
/// the body; its rate is that of [`PathAngle`].
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMount {
    geometry: Geometry,
    pin: PathAngle<3>,
}

impl BodyMount {
    /// For a robot, and readings of the pin with white noise (rad a sample).
    pub fn new(geometry: &Geometry, noise: f64) -> Self {
        Self {
            geometry: geometry.clone(),
            pin: PathAngle::new(geometry.wheel_radius, noise),
        }
    }

    /// The same, but every reading of the pin counts, also one that jumps: to look for such readings.
    #[must_use]
    pub fn keeping_jumps(mut self) -> Self {
        self.pin.keeps_jumps = true;
        self
    }

    /// As before its first reading.
    #[must_use]
    pub fn started_anew(&self) -> Self {
        Self {
            geometry: self.geometry.clone(),
            pin: self.pin.started_anew(),
        }
    }

    /// The readings of the links at `time`, s. Without a reading of the pin there are none but, of
    /// a bogie, those of the link that the body is fixed to; none of both where the linkage cannot
    /// close at the angle of the pin.
    ///
    /// A reading of the pin that jumps counts as missing until the next one confirms it, so that a
    /// single wrong reading changes nothing.
    pub fn links(&mut self, time: f64, reading: &BodyReading) -> [LinkReading; 2] {
        let Some((opening, rate)) = self.pin.update(time, reading.pin, &reading.wheels) else {
            return self.without_pin(reading);
        };
        let Ok(posture) = Posture::close(&self.geometry, opening, 0.0) else {
            return Default::default();
        };
        // With link 2 at rest link 1 turns as the pin, and the body with them.
        let [share, ..] = posture.rates(&self.geometry, 1.0, 0.0);
        let (body, error) = (share * rate, self.pin.rate_error());
        // Angle and rate of each link beyond those of link 2, and its part in an error of the pin's rate.
        let links = [(opening, rate, 1.0 - share), (0.0, 0.0, share)];
        links.map(|(angle, rate, share)| LinkReading {
            inclination: (reading.inclination).map(|of_body| of_body - posture.body + angle),
            rate: reading.rate.map(|of_body| of_body - body + rate),
            rate_error: libm::fabs(share) * error,
        })
    }

    fn without_pin(&self, reading: &BodyReading) -> [LinkReading; 2] {
        let mut found = [LinkReading::default(); 2];
        if let Suspension::Bogie { body } = self.geometry.suspension
            && let Some(link) = found.get_mut(body.index())
        {
            (link.inclination, link.rate) = (reading.inclination, reading.rate);
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Carrier;

    /// Closed form: a linkage that turns steadily along the path, seen from its body and its pin,
    /// gives the angles and rates of its links; of a four-bar through its loop, of a bogie on
    /// either link. What the start of filter and low pass leaves of the rates after 4 s is below
    /// 1e-6.
    #[test]
    fn links_are_found_from_the_body() {
        let bogie = |body| {
            let mut geometry = Geometry::b();
            geometry.make_bogie(body);
            geometry
        };
        for geometry in [Geometry::a(), bogie(Carrier::Link1), bogie(Carrier::Link2)] {
            let mut mount = BodyMount::new(&geometry, 1e-4);
            for k in 0..=4000 {
                let t = f64::from(k) * 1e-3;
                let (theta, rates) = ([0.1 + 0.03 * t, -0.05 - 0.02 * t], [0.03, -0.02]);
                let posture = Posture::close(&geometry, theta[0], theta[1]).expect("closes");
                let [body, ..] = posture.rates(&geometry, rates[0], rates[1]);
                let reading = BodyReading {
                    inclination: Some(posture.body),
                    rate: Some(body),
                    pin: Some(theta[0] - theta[1]),
                    wheels: [Some(2.0 * t); 3],
                };
                let found = mount.links(t, &reading);
                for i in 0..2 {
                    let LinkReading {
                        inclination: angle,
                        rate,
                        ..
                    } = found[i];
                    assert!((angle.expect("a reading") - theta[i]).abs() < 1e-12);
                    let error = rate.expect("a reading") - rates[i];
                    assert!(t < 4.0 || error.abs() < 1e-6, "{error}");
                }
            }
        }
    }

    /// Equivalence: encoders at a quarter of the samples, each in frames of its own, give the rate
    /// of encoders in every sample; without the pin the link with the body keeps its readings.
    #[test]
    fn slow_encoders_give_the_same_rate() {
        let mut geometry = Geometry::b();
        geometry.make_bogie(Carrier::Link1);
        let [mut each, mut slow] = [0, 1].map(|_| BodyMount::new(&geometry, 1e-4));
        for k in 0..=4000_usize {
            let t = 1e-3 * k as f64;
            let reading = BodyReading {
                inclination: Some(0.0),
                rate: Some(0.0),
                pin: Some(0.05 * t),
                wheels: [Some(2.0 * t); 3],
            };
            let few = BodyReading {
                wheels: [0, 1, 2].map(|i| (k % 4 == i).then_some(2.0 * t)),
                ..reading
            };
            let [a, b] = [each.links(t, &reading), slow.links(t, &few)];
            let [a, b] = [a, b].map(|found| found[1].rate.expect("a reading"));
            assert!(k < 2000 || (a - b).abs() < 1e-4, "{a} {b}");
        }
        let found = slow.links(4.001, &BodyReading::default());
        assert_eq!(found, [LinkReading::default(); 2]);
        let body = BodyReading {
            inclination: Some(0.1),
            ..BodyReading::default()
        };
        let found = slow.links(4.002, &body).map(|link| link.inclination);
        assert_eq!(found, [Some(0.1), None]);
    }

    /// Equivalence: behind a single wrong reading of the pin, or of an encoder, the links are those of
    /// the readings without it. A step of the pin that stays counts from its second reading on.
    #[test]
    fn a_single_wrong_reading_changes_nothing() {
        let run = |pin: fn(u32) -> f64, wheel: fn(u32) -> f64| {
            let mut mount = BodyMount::new(&Geometry::a(), 2e-3);
            let mut links = [[LinkReading::default(); 2]; 100];
            for (k, links) in (0..).zip(&mut links) {
                let t = 1e-2 * f64::from(k);
                let reading = BodyReading {
                    inclination: Some(0.0),
                    rate: Some(0.0),
                    pin: Some(0.02 * t + pin(k)),
                    wheels: [Some(2.0 * t + wheel(k)), Some(2.0 * t), Some(2.0 * t)],
                };
                *links = mount.links(t, &reading);
            }
            links
        };
        let clean = run(|_| 0.0, |_| 0.0);
        let spike = run(|k| if k == 50 { -0.26 } else { 0.0 }, |_| 0.0);
        let angles = |links: [LinkReading; 2]| links.map(|link| link.inclination);
        assert_eq!(spike[50], [LinkReading::default(); 2]);
        assert_eq!(
            (&spike[..50], angles(spike[52])),
            (&clean[..50], angles(clean[52]))
        );
        for (found, expected) in spike[51..].iter().zip(&clean[51..]) {
            for (found, expected) in found.iter().zip(expected) {
                let error = found
                    .rate
                    .zip(expected.rate)
                    .map(|(a, b)| a - b)
                    .expect("rates");
                // A tenth of the rate that the pin has: one reading less.
                assert!(error.abs() < 2e-3, "{error}");
            }
        }
        let turned = run(|_| 0.0, |k| if k == 50 { 3.0 } else { 0.0 });
        assert_eq!(angles(turned[99]), angles(clean[99]));
        let step = run(|k| if k < 50 { 0.0 } else { 0.3 }, |_| 0.0);
        assert_eq!(step[50], [LinkReading::default(); 2]);
        assert!(angles(step[51]).iter().all(Option::is_some));
    }

    /// Missing readings: without the pin's a four-bar has none; without the body's inclination it
    /// has rates. At rest these are 0.
    #[test]
    fn missing_readings_leave_what_they_show() {
        let mut mount = BodyMount::new(&Geometry::a(), 1e-3);
        let mut reading = BodyReading {
            inclination: Some(0.1),
            rate: Some(0.0),
            ..BodyReading::default()
        };
        assert_eq!(mount.links(0.0, &reading), [LinkReading::default(); 2]);
        reading.pin = Some(0.05);
        let whole = mount.links(0.001, &reading);
        assert!(
            whole
                .iter()
                .all(|link| link.inclination.is_some() && link.rate == Some(0.0))
        );
        reading.inclination = None;
        let rates = mount.links(0.002, &reading);
        assert!(
            rates
                .iter()
                .all(|link| link.inclination.is_none() && link.rate.is_some())
        );
    }
}
