//! Positions of pins, axles and centres of mass in the nominal pose.
//!
//! The real dimensions of ROBHAZ-6WHEEL were never published. Geometries A and B are derived: a
//! wheelbase of 0.60 m, static wheel loads equal within 5 %, and a reach of the front wheel of 0.18
//! m inside the end stops.

use crate::named;
use crate::{Outline, Vec2};

named! {
    /// One of the four rigid bars of the loop. Arrays over all bars have this order.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum Bar {
        /// The body, between P and S.
        Body = "body",
        /// Link 1, between P and Q.
        Link1 = "link1",
        /// Link 2, between Q and R.
        Link2 = "link2",
        /// Link 3, between R and S.
        Link3 = "link3",
    }
}

impl Bar {
    /// The three links in order.
    pub const LINKS: [Bar; 3] = [Bar::Link1, Bar::Link2, Bar::Link3];
}

named! {
    /// One of the four pins of the loop. Arrays over all pins have this order.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum Pin {
        /// Between body and link 1.
        P = "p",
        /// Between link 1 and link 2; it carries the end stops.
        Q = "q",
        /// Between link 2 and link 3.
        R = "r",
        /// Between link 3 and body.
        S = "s",
    }
}

impl Pin {
    /// The two bars that the pin joins. The pin's force acts on the first bar and is exerted by the
    /// second.
    ///
    /// P: on the body from link 1. Q: on link 1 from link 2. R: on link 3 from link 2. S: on the
    /// body from link 3.
    pub const fn bars(self) -> (Bar, Bar) {
        match self {
            Pin::P => (Bar::Body, Bar::Link1),
            Pin::Q => (Bar::Link1, Bar::Link2),
            Pin::R => (Bar::Link3, Bar::Link2),
            Pin::S => (Bar::Body, Bar::Link3),
        }
    }
}

/// How the body hangs on links 1 and 2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Suspension {
    /// Link 3 joins the body to link 2: pins P, Q, R and S, as in ROBHAZ-6WHEEL.
    #[default]
    FourBar,
    /// The body is fixed to a link, and Q is the only pin: a rocker-bogie, whose rocker is that
    /// link, or a triple bogie.
    ///
    /// It is a four-bar with one side of no length. Where R lies on Q, the triangle PRS, which body
    /// and link 3 close, moves with link 1 alone: body and link 3 turn as link 1 does. So all that
    /// is derived for the four-bar holds; link 3 has no mass, and P, R and S carry no meaning of
    /// their own. A body on link 2 has P on Q.
    Bogie {
        /// The link that the body is fixed to.
        body: Carrier,
    },
}

impl Suspension {
    /// The pins that the robot has.
    pub fn pins(self) -> &'static [Pin] {
        match self {
            Self::FourBar => &Pin::ALL,
            Self::Bogie { .. } => &[Pin::Q],
        }
    }

    /// The bars that the robot has: all, or body, link 1 and link 2.
    pub fn bars(self) -> &'static [Bar] {
        match self {
            Self::FourBar => &Bar::ALL,
            Self::Bogie { .. } => &Bar::ALL[..3],
        }
    }
}

/// Positions of the four pins, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pins {
    /// Between body and link 1.
    pub p: Vec2,
    /// Between link 1 and link 2.
    pub q: Vec2,
    /// Between link 2 and link 3.
    pub r: Vec2,
    /// Between link 3 and body.
    pub s: Vec2,
}

impl Pins {
    /// Those of a [`Suspension::Bogie`] with its pin at `q` (m): an equilateral triangle with sides
    /// of `length` (m), one corner of it in Q.
    pub fn of_bogie(q: Vec2, body: Carrier, length: f64) -> Self {
        let ahead = q + Vec2::new(length, 0.0);
        let above = q + Vec2::new(0.5, crate::sqrt(0.75)) * length;
        let (p, r, s) = match body {
            Carrier::Link1 => (ahead, q, above),
            Carrier::Link2 => (q, ahead, above),
        };
        Self { p, q, r, s }
    }

    /// Position of one pin, m.
    pub fn get(&self, pin: Pin) -> Vec2 {
        [self.p, self.q, self.r, self.s][pin as usize]
    }
}

/// The link that carries a wheel; only links 1 and 2 carry wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Carrier {
    /// The wheel's axle is fixed to link 1.
    #[default]
    Link1,
    /// The wheel's axle is fixed to link 2.
    Link2,
}

impl Carrier {
    /// The carrying bar.
    pub const fn bar(self) -> Bar {
        match self {
            Carrier::Link1 => Bar::Link1,
            Carrier::Link2 => Bar::Link2,
        }
    }

    /// Index into an array over the carrying links: 0 for link 1, 1 for link 2.
    pub const fn index(self) -> usize {
        self as usize
    }
}

/// End stops of pin Q, on the relative angle theta_1 - theta_2 (the paper's "limited pin joint").
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinStop {
    /// Lower limit of theta_1 - theta_2, rad.
    pub lower: f64,
    /// Upper limit of theta_1 - theta_2, rad.
    pub upper: f64,
    /// Stiffness of the stop beyond a limit, N m/rad.
    pub stiffness: f64,
    /// Damping of the stop beyond a limit, N m s/rad.
    pub damping: f64,
}

impl PinStop {
    /// Elastic energy of the stops at `angle` = theta_1 - theta_2 (rad), J.
    pub fn energy(&self, angle: f64) -> f64 {
        let beyond = (angle - self.upper).max(self.lower - angle).max(0.0);
        0.5 * self.stiffness * beyond * beyond
    }

    /// Torque of the stops on link 1, N m counter-clockwise (its opposite acts on link 2).
    ///
    /// `angle` is theta_1 - theta_2 (rad), `rate` its rate (rad/s). The torque is zero between the
    /// limits and `-(k (angle - limit) + c rate)` beyond a limit. It never acts away from the free
    /// range: a stop cannot hold the bars back.
    pub fn torque(&self, angle: f64, rate: f64) -> f64 {
        let beyond = |limit: f64| -(self.stiffness * (angle - limit) + self.damping * rate);
        if angle > self.upper {
            beyond(self.upper).min(0.0)
        } else if angle < self.lower {
            beyond(self.lower).max(0.0)
        } else {
            0.0
        }
    }

    /// The default stops: -40 deg to +35 deg, 2000 N m/rad, 20 N m s/rad.
    pub fn standard() -> Self {
        Self {
            lower: (-40.0_f64).to_radians(),
            upper: 35.0_f64.to_radians(),
            stiffness: 2000.0,
            damping: 20.0,
        }
    }
}

/// Positions in the nominal pose, m: all wheels on level ground `y = 0`, middle axle at `x = 0`.
#[derive(Clone, Debug, PartialEq)]
pub struct Geometry {
    /// Radius of every wheel, m.
    pub wheel_radius: f64,
    /// Axles of the front, middle and rear wheel, m.
    pub axles: [Vec2; 3],
    /// The link that carries each wheel.
    pub carriers: [Carrier; 3],
    /// How the body hangs on links 1 and 2.
    pub suspension: Suspension,
    /// The four pins, m; of a bogie those of [`Pins::of_bogie`].
    pub pins: Pins,
    /// Centre of mass of the body, m.
    pub body_cg: Vec2,
    /// Centres of mass of links 1 to 3 without wheels, m.
    pub link_cg: [Vec2; 3],
    /// End stops of pin Q.
    pub stop: PinStop,
    /// Outline of body and links.
    pub outline: Outline,
}

/// Reason why a geometry is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// The wheel's radius is not a positive number.
    #[error("the wheel radius is {0} m; it must be above 0")]
    WheelRadius(f64),
    /// A coordinate is not finite.
    #[error("a coordinate is not a finite number")]
    NotFinite,
    /// Two neighbouring pins coincide, so that a bar of the loop has no length.
    #[error("the pins of {} coincide", .0.name())]
    ZeroBar(Bar),
    /// P lies on the line RS in the nominal pose, where matrix C of eq. (6) is singular.
    #[error(
        "pin P lies on the line through R and S, where the statics of body and link3 are singular"
    )]
    POnLineRs,
    /// Wheels are not ordered from front to rear.
    #[error("axles must be ordered front, middle, rear (x decreasing)")]
    WheelOrder,
    /// Link 1 or link 2 carries no wheel.
    #[error("{} carries no wheel", .0.bar().name())]
    UnusedCarrier(Carrier),
    /// The nominal pose is not between the stops: it needs `lower < 0 < upper`.
    #[error("the stops must leave the nominal pose free: lower < 0 < upper")]
    Stop,
}

impl Geometry {
    /// Geometry A, the default: wheel 1 on link 1; wheels 2 and 3 on link 2. The dimensions are
    /// derived, not published.
    pub fn a() -> Self {
        let pins = [[0.15, 0.22], [-0.05, 0.14], [-0.25, 0.16], [-0.25, 0.26]];
        Self::with_mean_link_cgs(
            [Carrier::Link1, Carrier::Link2, Carrier::Link2],
            pins,
            [0.03, 0.30],
        )
    }

    /// Geometry B: wheels 1 and 2 on link 1; wheel 3 on link 2. The dimensions are derived, not
    /// published.
    pub fn b() -> Self {
        let pins = [[0.25, 0.22], [0.10, 0.14], [-0.10, 0.16], [-0.10, 0.26]];
        Self::with_mean_link_cgs(
            [Carrier::Link1, Carrier::Link1, Carrier::Link2],
            pins,
            [0.0, 0.30],
        )
    }

    fn with_mean_link_cgs(carriers: [Carrier; 3], pins: [[f64; 2]; 4], body_cg: [f64; 2]) -> Self {
        let ([p, q, r, s], body_cg) = (pins.map(Vec2::from), Vec2::from(body_cg));
        let axles = [0.30, 0.0, -0.30].map(|x| Vec2::new(x, 0.10));
        let mut geometry = Self {
            wheel_radius: 0.10,
            link_cg: [Vec2::zeros(); 3],
            outline: Outline::derived(&axles, body_cg),
            axles,
            carriers,
            suspension: Suspension::FourBar,
            pins: Pins { p, q, r, s },
            body_cg,
            stop: PinStop::standard(),
        };
        geometry.link_cg = geometry.mean_link_cgs();
        geometry
    }

    /// Distance of the front axle from the rear one along x, m.
    pub fn wheelbase(&self) -> f64 {
        (self.axles[0].x - self.axles[2].x).abs()
    }

    /// Wheelbase over that of geometry A, -: lengths in drawings are in proportion to it.
    pub fn size(&self) -> f64 {
        self.wheelbase() / Self::a().wheelbase()
    }

    /// Makes the geometry that of a bogie, with the pin Q that it has: pins P, R and S, and the
    /// centre of mass of link 3, which is massless, at that of the body.
    pub fn make_bogie(&mut self, body: Carrier) {
        let length = 0.5 * self.wheelbase();
        self.suspension = Suspension::Bogie { body };
        self.pins = Pins::of_bogie(self.pins.q, body, length);
        self.link_cg[2] = self.body_cg;
    }

    /// Checks that all values are finite, every bar has a length, C of eq. (6) is regular in the
    /// nominal pose, wheels are in order, links 1 and 2 both carry wheels, and the stops enclose
    /// the nominal pose.
    ///
    /// # Errors
    /// The first [`GeometryError`] found.
    pub fn check(&self) -> Result<(), GeometryError> {
        // In this form the condition refuses NaN as well.
        if !(self.wheel_radius > 0.0 && self.wheel_radius.is_finite()) {
            return Err(GeometryError::WheelRadius(self.wheel_radius));
        }
        let Pins { p, q, r, s } = self.pins;
        let (low, high) = (self.outline.body_lower, self.outline.body_upper);
        let points = [p, q, r, s, self.body_cg, low, high];
        let mut points = points.iter().chain(&self.axles).chain(&self.link_cg);
        if !points.all(|v| v.x.is_finite() && v.y.is_finite()) {
            return Err(GeometryError::NotFinite);
        }
        let four_bar = self.suspension == Suspension::FourBar;
        for (bar, length) in [
            (Bar::Link1, (p - q).norm()),
            (Bar::Link2, (q - r).norm()),
            (Bar::Link3, (r - s).norm()),
            (Bar::Body, (s - p).norm()),
        ] {
            if four_bar && length < 1e-6 {
                return Err(GeometryError::ZeroBar(bar));
            }
        }
        let sine = crate::cross(s - r, p - r) / ((s - r).norm() * (p - r).norm().max(1e-12));
        if sine.abs() < 1e-3 {
            return Err(GeometryError::POnLineRs);
        }
        if !(self.axles[0].x > self.axles[1].x && self.axles[1].x > self.axles[2].x) {
            return Err(GeometryError::WheelOrder);
        }
        for carrier in [Carrier::Link1, Carrier::Link2] {
            if !self.carriers.contains(&carrier) {
                return Err(GeometryError::UnusedCarrier(carrier));
            }
        }
        if !(self.stop.lower < 0.0 && self.stop.upper > 0.0) {
            return Err(GeometryError::Stop);
        }
        Ok(())
    }

    /// Axle of a wheel from its carrying link's centre of mass, in the nominal pose, m.
    pub fn axle_on_carrier(&self, wheel: usize) -> Vec2 {
        self.axles[wheel] - self.cg(self.carriers[wheel].bar())
    }

    /// The pins and axles of a bar, in the nominal pose, m; none of link 3 of a bogie.
    fn joints(&self, bar: Bar) -> impl Iterator<Item = Vec2> + '_ {
        let pins = self.suspension.pins().iter();
        let pins = pins.filter(move |pin| pin.bars().0 == bar || pin.bars().1 == bar);
        let axles = self.axles.iter().zip(&self.carriers);
        let axles = axles.filter(move |(_, carrier)| carrier.bar() == bar);
        let pins = pins.map(|pin| self.pins.get(*pin));
        pins.chain(axles.map(|(axle, _)| *axle))
    }

    /// Points that the outline of a bar goes through, in the nominal pose, m: for the body the
    /// corners of its box and its pins in any order (their convex hull), for a link its own pins
    /// and axles, and its further points; none of link 3 of a bogie.
    pub fn outline_points(&self, bar: Bar) -> impl Iterator<Item = Vec2> + '_ {
        let (low, high) = (self.outline.body_lower, self.outline.body_upper);
        let (front, rear) = (Vec2::new(high.x, low.y), Vec2::new(low.x, high.y));
        let corners = [low, front, high, rear]
            .into_iter()
            .filter(move |_| bar == Bar::Body);
        let links = [Bar::Link1, Bar::Link2]
            .into_iter()
            .zip(self.outline.through);
        let through = links.filter(move |(link, _)| *link == bar);
        let through = through.flat_map(|(_, points)| points).flatten();
        self.joints(bar).chain(through).chain(corners)
    }

    /// Centres of mass of links 1 to 3 if none are given, m: the mean of the link's pins and of the
    /// axles that it carries. Link 3 of a bogie, which has no mass, has that of the body.
    pub fn mean_link_cgs(&self) -> [Vec2; 3] {
        Bar::LINKS.map(|link| {
            let points = self.joints(link);
            let add = |(sum, count), point| (sum + point, count + 1.0);
            let (sum, count) = points.fold((Vec2::zeros(), 0.0), add);
            match count > 0.0 {
                true => sum / count,
                false => self.body_cg,
            }
        })
    }

    /// Centre of mass of a bar without wheels, in the nominal pose, m.
    pub fn cg(&self, bar: Bar) -> Vec2 {
        let [link1, link2, link3] = self.link_cg;
        [self.body_cg, link1, link2, link3][bar as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stops_push_towards_the_free_range_and_never_away_from_it() {
        let stop = PinStop::standard();
        assert!(stop.torque(0.0, 5.0) == 0.0);
        assert!((stop.torque(stop.upper + 0.01, 0.0) + 20.0).abs() < 1e-9);
        assert!((stop.torque(stop.lower - 0.01, 0.0) - 20.0).abs() < 1e-9);
        assert!(stop.torque(stop.upper + 0.001, -1.0) == 0.0);
        assert!(stop.torque(stop.lower - 0.001, 1.0) == 0.0);
    }
}
