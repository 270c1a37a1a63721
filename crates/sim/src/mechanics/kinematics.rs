//! Kinematics of the robot in minimal coordinates: position of Q, angles of links 1 and 2, three
//! wheel spins.
//!
//! The loop of the four-bar is closed analytically, so the pins cannot drift apart. With
//! `v = [Qx' Qy' theta_1' theta_2']` the velocity of a point is `J v`, and its acceleration is
//! `J v' + b`; `b` is called bias here.

use crate::error::NoTruth;
use crate::ground::WheelMotion;
use crate::truth::BarTruth;
use nalgebra::Vector4;
use robhaz_model::{Bar, Carrier, Dyad, Geometry, Robot, Vec2, cross, direction, perp, turned};

/// Coordinates of the robot and their rates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct State {
    /// Position of Q, m.
    pub q: Vec2,
    /// Angles of links 1 and 2, rad.
    pub angles: [f64; 2],
    /// Velocity of Q (m/s) and rates of links 1 and 2 (rad/s).
    pub rates: Vector4<f64>,
    /// Wheel spins relative to the links, rad/s.
    pub omega: [f64; 3],
}

/// Motion of a point of body or link 3 as a function of the four rates.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    /// Position relative to Q, m.
    pub arm: Vec2,
    /// Derivative of the velocity by the rate of link 1, m: the velocity is
    /// `v_Q + theta_1' j1 + theta_2' j2`.
    pub j1: Vec2,
    /// Derivative of the velocity by the rate of link 2, m.
    pub j2: Vec2,
    /// Acceleration at constant rates, m/s^2.
    pub bias: Vec2,
}

/// Motion of a point of link 1 or 2: it turns about Q with its link.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LinkPoint {
    /// Position relative to Q, m.
    pub arm: Vec2,
    /// The link.
    pub link: Carrier,
    /// Rate of the link, rad/s.
    pub rate: f64,
}

/// Rotation of a bar as a function of the rates of links 1 and 2.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turning {
    /// Derivative of the bar's rate by the rate of link 1, -.
    pub k1: f64,
    /// Derivative of the bar's rate by the rate of link 2, -.
    pub k2: f64,
    /// Angular rate, rad/s.
    pub rate: f64,
    /// Angular acceleration at constant rates, rad/s^2.
    pub bias: f64,
}

/// Positions, velocities and Jacobians at one state.
#[derive(Clone, Default)]
pub(crate) struct Kinematics {
    /// The state.
    pub state: State,
    /// Unit vectors along the turned x axis of each bar, in the order of [`Bar::ALL`].
    pub(super) axes: [Vec2; 4],
    /// Rotation of the body.
    pub(super) body: Turning,
    /// Rotation of link 3.
    pub(super) link3: Turning,
    /// Centre of mass of the body.
    pub(super) body_cg: Motion,
    /// Centre of mass of link 3.
    pub(super) link3_cg: Motion,
    /// Centres of mass of links 1 and 2.
    pub(super) link_cgs: [LinkPoint; 2],
    /// Centres of the wheels.
    pub axles: [LinkPoint; 3],
    /// P, R and S relative to Q, m.
    pub(super) pins: [Vec2; 3],
}

impl Kinematics {
    /// The kinematics at a state.
    ///
    /// # Errors
    /// [`NoTruth::LoopRange`] if the four-bar cannot close at the angles of the links.
    pub fn new(robot: &Robot, state: &State) -> Result<Self, NoTruth> {
        let mut kinematics = Self::default();
        kinematics.set(&Linkage::new(&robot.geometry), state)?;
        Ok(kinematics)
    }

    /// Becomes the kinematics at a state, without a copy of the result.
    ///
    /// # Errors
    /// As [`Self::new`]. The kinematics are then those of no state.
    pub fn set(&mut self, linkage: &Linkage, state: &State) -> Result<(), NoTruth> {
        self.state = *state;
        let [w1, w2] = [state.rates[2], state.rates[3]];
        let unit = |angle: f64| {
            let (sin, cos) = libm::sincos(angle);
            Vec2::new(cos, sin)
        };
        let (axis1, axis2) = (unit(state.angles[0]), unit(state.angles[1]));
        let p = turned(axis1, linkage.p);
        let r = turned(axis2, linkage.r);
        let s = linkage.dyad.s(p, r).map_err(|_| NoTruth::LoopRange)?;
        let (c, d) = (s - p, s - r);
        // Unit vectors along the turned x axes, from vectors whose lengths are the nominal ones.
        let axis = |nominal: Vec2, v: Vec2| Vec2::new(nominal.dot(&v), cross(nominal, v));
        let (axis_body, axis3) = (axis(linkage.body, c), axis(linkage.link3, d));

        // Velocity closure, with perp(.) dropped on both sides: wb c - w3 d = w2 r - w1 p.
        let per_det = -1.0 / cross(c, d);
        let mut body = Turning {
            k1: cross(p, d) * per_det,
            k2: -cross(r, d) * per_det,
            ..Turning::default()
        };
        let mut link3 = Turning {
            k1: -cross(c, p) * per_det,
            k2: cross(c, r) * per_det,
            ..Turning::default()
        };
        body.rate = body.k1 * w1 + body.k2 * w2;
        link3.rate = link3.k1 * w1 + link3.k2 * w2;
        // Acceleration closure: the same matrix, with the centripetal terms on the right-hand side.
        let g = p * (w1 * w1) + c * (body.rate * body.rate)
            - r * (w2 * w2)
            - d * (link3.rate * link3.rate);
        let g = Vec2::new(g.y, -g.x);
        body.bias = -cross(g, d) * per_det;
        link3.bias = cross(c, g) * per_det;

        // Points of body and link 3, which are attached to P and R.
        let arm = turned(axis_body, linkage.body_cg);
        self.body_cg = Motion {
            arm: p + arm,
            j1: perp(p + arm * body.k1),
            j2: perp(arm * body.k2),
            bias: perp(arm) * body.bias - arm * (body.rate * body.rate) - p * (w1 * w1),
        };
        let arm = turned(axis3, linkage.link3_cg);
        self.link3_cg = Motion {
            arm: r + arm,
            j1: perp(arm * link3.k1),
            j2: perp(r + arm * link3.k2),
            bias: perp(arm) * link3.bias - arm * (link3.rate * link3.rate) - r * (w2 * w2),
        };
        let on_link = |link: Carrier, nominal: Vec2| LinkPoint {
            arm: turned([axis1, axis2][link.index()], nominal),
            link,
            rate: [w1, w2][link.index()],
        };
        self.link_cgs = [
            on_link(Carrier::Link1, linkage.link_cgs[0]),
            on_link(Carrier::Link2, linkage.link_cgs[1]),
        ];
        for (axle, (link, nominal)) in self.axles.iter_mut().zip(linkage.axles) {
            *axle = on_link(link, nominal);
        }
        self.axes = [axis_body, axis1, axis2, axis3];
        (self.body, self.link3) = (body, link3);
        self.pins = [p, r, s];
        Ok(())
    }

    /// Pose and rates of a bar.
    pub fn bar(&self, bar: Bar) -> BarTruth {
        let state = &self.state;
        let on_link = |link: usize| {
            let point = &self.link_cgs[link];
            let (angle, velocity) = (state.angles[link], point.velocity(state));
            (point.arm, angle, velocity, point.rate)
        };
        let free = |point: &Motion, turning: &Turning| {
            let angle = direction(self.axes[bar as usize]);
            (point.arm, angle, point.velocity(state), turning.rate)
        };
        let (arm, angle, velocity, rate) = match bar {
            Bar::Body => free(&self.body_cg, &self.body),
            Bar::Link1 => on_link(0),
            Bar::Link2 => on_link(1),
            Bar::Link3 => free(&self.link3_cg, &self.link3),
        };
        BarTruth {
            position: state.q + arm,
            angle,
            velocity,
            rate,
        }
    }

    /// The bars that do not turn about Q, with their centres of mass and their rotations.
    pub(super) fn free_bars(&self) -> [(Bar, &Motion, &Turning); 2] {
        let body = (Bar::Body, &self.body_cg, &self.body);
        [body, (Bar::Link3, &self.link3_cg, &self.link3)]
    }

    /// Centre of a wheel, m.
    pub fn axle(&self, wheel: usize) -> Vec2 {
        self.state.q + self.axles[wheel].arm
    }

    /// Motion of a wheel: centre, velocity, absolute spin.
    pub fn wheel(&self, wheel: usize) -> WheelMotion {
        let (state, axle) = (&self.state, &self.axles[wheel]);
        WheelMotion {
            wheel,
            centre: state.q + axle.arm,
            velocity: axle.velocity(state),
            spin: state.omega[wheel] - axle.rate,
        }
    }

    /// Row of the Jacobian: its product with the four rates is the speed of a wheel's centre along
    /// `direction` (unit vector), m/s.
    pub fn axle_row(&self, wheel: usize, direction: Vec2) -> Vector4<f64> {
        let mut row = Vector4::zeros();
        self.axles[wheel].add_force(direction, &mut row);
        row
    }

    /// Distance between S on the body and S on link 3, m: the rounding error of the closed loop.
    pub fn loop_error(&self, robot: &Robot) -> f64 {
        let pins = &robot.geometry.pins;
        let [p, r, _] = self.pins;
        let [body, _, _, link3] = self.axes;
        let on_body = p + turned(body, pins.s - pins.p);
        let on_link3 = r + turned(link3, pins.s - pins.r);
        (on_body - on_link3).norm()
    }

    /// Positions of P, Q, R, S, m.
    pub fn pins(&self) -> [Vec2; 4] {
        let ([p, r, s], q) = (self.pins, self.state.q);
        [q + p, q, q + r, q + s]
    }
}

impl Motion {
    /// Velocity of the point, m/s.
    fn velocity(&self, state: &State) -> Vec2 {
        let v = &state.rates;
        Vec2::new(v[0], v[1]) + self.j1 * v[2] + self.j2 * v[3]
    }

    /// Acceleration of the point (m/s^2) at the accelerations `a` of the four coordinates.
    pub fn acceleration(&self, a: &Vector4<f64>) -> Vec2 {
        Vec2::new(a[0], a[1]) + self.j1 * a[2] + self.j2 * a[3] + self.bias
    }

    /// Adds a force (N) at this point to the right-hand side, by virtual power.
    pub fn add_force(&self, force: Vec2, right: &mut Vector4<f64>) {
        right[0] += force.x;
        right[1] += force.y;
        right[2] += self.j1.dot(&force);
        right[3] += self.j2.dot(&force);
    }
}

impl LinkPoint {
    /// Velocity of the point, m/s.
    fn velocity(&self, state: &State) -> Vec2 {
        let v = &state.rates;
        Vec2::new(v[0], v[1]) + perp(self.arm) * self.rate
    }

    /// Acceleration of the point (m/s^2) at the accelerations `a` of the four coordinates.
    pub fn acceleration(&self, a: &Vector4<f64>) -> Vec2 {
        Vec2::new(a[0], a[1]) + perp(self.arm) * a[self.row()] - self.arm * (self.rate * self.rate)
    }

    /// Adds a force (N) at this point to the right-hand side, by virtual power.
    pub fn add_force(&self, force: Vec2, right: &mut Vector4<f64>) {
        right[0] += force.x;
        right[1] += force.y;
        right[self.row()] += cross(self.arm, force);
    }

    /// Index of the link's rate among the four rates.
    pub fn row(&self) -> usize {
        2 + self.link.index()
    }
}

impl Turning {
    /// Adds a torque (N m) on the bar to the right-hand side.
    pub fn add_torque(&self, torque: f64, right: &mut Vector4<f64>) {
        right[2] += self.k1 * torque;
        right[3] += self.k2 * torque;
    }

    /// Angular acceleration of the bar (rad/s^2) at the accelerations `a` of the four coordinates.
    pub fn acceleration(&self, a: &Vector4<f64>) -> f64 {
        self.k1 * a[2] + self.k2 * a[3] + self.bias
    }
}

/// What the kinematics need of the robot's geometry, computed once: nominal positions of points on
/// the bars, and the dyad that closes the loop.
#[derive(Clone)]
pub(crate) struct Linkage {
    /// Body and link 3.
    dyad: Dyad,
    /// P from Q, m.
    p: Vec2,
    /// R from Q, m.
    r: Vec2,
    /// Centre of mass of the body from P, m.
    body_cg: Vec2,
    /// Centre of mass of link 3 from R, m.
    link3_cg: Vec2,
    /// Centres of mass of links 1 and 2 from Q, m.
    link_cgs: [Vec2; 2],
    /// Of each wheel: the link that carries it, and the axle from Q, m.
    axles: [(Carrier, Vec2); 3],
    /// S from P and from R, over the square of its length, 1/m.
    body: Vec2,
    link3: Vec2,
}

impl Linkage {
    pub fn new(geometry: &Geometry) -> Self {
        let pins = &geometry.pins;
        let per_square = |arm: Vec2| arm / arm.norm_squared();
        Self {
            dyad: Dyad::new(geometry),
            p: pins.p - pins.q,
            r: pins.r - pins.q,
            body_cg: geometry.body_cg - pins.p,
            link3_cg: geometry.link_cg[2] - pins.r,
            link_cgs: [geometry.link_cg[0] - pins.q, geometry.link_cg[1] - pins.q],
            axles: [0, 1, 2].map(|i| (geometry.carriers[i], geometry.axles[i] - pins.q)),
            body: per_square(pins.s - pins.p),
            link3: per_square(pins.s - pins.r),
        }
    }
}
