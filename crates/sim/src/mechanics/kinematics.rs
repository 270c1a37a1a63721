//! Kinematics of the robot in minimal coordinates: position of Q, angles of links 1 and 2, three wheel spins.
//!
//! The loop of the four-bar is closed analytically, so the pins cannot drift apart. With `v = [Qx' Qy' theta_1'
//! theta_2']` the velocity of a point is `J v`, and its acceleration is `J v' + b`; `b` is called bias here.

use crate::ground::WheelMotion;
use crate::truth::BarTruth;
use nalgebra::{Matrix4, Vector4};
use robhaz_model::{Bar, GRAVITY, PostureError, Robot, Vec2, corner_s, cross, perp, turned};

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

/// Motion of a point of the robot as a function of the four rates.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    /// Position relative to Q, m.
    pub arm: Vec2,
    /// Derivative of the velocity by the rate of link 1, m: the velocity is `v_Q + theta_1' j1 + theta_2' j2`.
    j1: Vec2,
    /// Derivative of the velocity by the rate of link 2, m.
    j2: Vec2,
    /// Acceleration at constant rates, m/s^2.
    bias: Vec2,
}

/// Rotation of a bar as a function of the rates of links 1 and 2.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turning {
    /// Derivative of the bar's rate by the rate of link 1, -.
    k1: f64,
    /// Derivative of the bar's rate by the rate of link 2, -.
    k2: f64,
    /// Angular rate, rad/s.
    rate: f64,
    /// Angular acceleration at constant rates, rad/s^2.
    bias: f64,
}

/// Positions, velocities and Jacobians at one state.
#[derive(Clone, Default)]
pub(crate) struct Kinematics {
    /// Unit vectors along the turned x axis of each bar, in the order of [`Bar::ALL`].
    pub(super) axes: [Vec2; 4],
    /// Rotations of the bars, in the order of [`Bar::ALL`].
    pub(super) turns: [Turning; 4],
    /// Centres of mass of the bars, in the order of [`Bar::ALL`].
    pub(super) centres: [Motion; 4],
    /// Centres of the wheels.
    pub(super) axles: [Motion; 3],
    /// P, R and S relative to Q, m.
    pub(super) pins: [Vec2; 3],
}

/// Unit vector (cosine, sine) of the rotation that takes `from` into the direction of `to`.
fn turn_between(from: Vec2, to: Vec2) -> Vec2 {
    Vec2::new(from.dot(&to), cross(from, to)).normalize()
}

impl Kinematics {
    /// The kinematics at a state.
    ///
    /// # Errors
    /// [`PostureError`] if the four-bar cannot close at the angles of the links.
    pub fn new(robot: &Robot, state: &State) -> Result<Self, PostureError> {
        let mut kinematics = Self::default();
        kinematics.set(robot, state)?;
        Ok(kinematics)
    }

    /// Becomes the kinematics at a state, without a copy of the result.
    ///
    /// # Errors
    /// As [`Self::new`]. The kinematics are then those of no state.
    pub fn set(&mut self, robot: &Robot, state: &State) -> Result<(), PostureError> {
        let geometry = &robot.geometry;
        let pins = &geometry.pins;
        let [w1, w2] = [state.rates[2], state.rates[3]];
        let unit = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            Vec2::new(cos, sin)
        };
        let (axis1, axis2) = (unit(state.angles[0]), unit(state.angles[1]));
        let p = turned(axis1, pins.p - pins.q);
        let r = turned(axis2, pins.r - pins.q);
        let s = corner_s(geometry, p, r)?;
        let axis_body = turn_between(pins.s - pins.p, s - p);
        let axis3 = turn_between(pins.s - pins.r, s - r);

        // Velocity closure, with perp(.) dropped on both sides: wb c - w3 d = w2 r - w1 p.
        let (c, d) = (s - p, s - r);
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

        let on_link1 = |nominal: Vec2| {
            let arm = turned(axis1, nominal - pins.q);
            Motion {
                arm,
                j1: perp(arm),
                j2: Vec2::zeros(),
                bias: -arm * (w1 * w1),
            }
        };
        let on_link2 = |nominal: Vec2| {
            let arm = turned(axis2, nominal - pins.q);
            Motion {
                arm,
                j1: Vec2::zeros(),
                j2: perp(arm),
                bias: -arm * (w2 * w2),
            }
        };
        // A point of a bar that is attached to a pin of link 1 or 2.
        let beyond = |pin: Motion, turning: &Turning, arm: Vec2| Motion {
            arm: pin.arm + arm,
            j1: pin.j1 + perp(arm) * turning.k1,
            j2: pin.j2 + perp(arm) * turning.k2,
            bias: pin.bias + perp(arm) * turning.bias - arm * (turning.rate * turning.rate),
        };
        self.centres = [
            beyond(
                on_link1(pins.p),
                &body,
                turned(axis_body, geometry.body_cg - pins.p),
            ),
            on_link1(geometry.link_cg[0]),
            on_link2(geometry.link_cg[1]),
            beyond(
                on_link2(pins.r),
                &link3,
                turned(axis3, geometry.link_cg[2] - pins.r),
            ),
        ];
        for (i, axle) in self.axles.iter_mut().enumerate() {
            *axle = match geometry.carriers[i].bar() {
                Bar::Link1 => on_link1(geometry.axles[i]),
                _ => on_link2(geometry.axles[i]),
            };
        }
        let link = |k1: f64, k2: f64, rate| Turning {
            k1,
            k2,
            rate,
            bias: 0.0,
        };
        self.axes = [axis_body, axis1, axis2, axis3];
        self.turns = [body, link(1.0, 0.0, w1), link(0.0, 1.0, w2), link3];
        self.pins = [p, r, s];
        Ok(())
    }

    /// Pose and rates of a bar.
    pub fn bar(&self, bar: Bar, state: &State) -> BarTruth {
        let i = bar as usize;
        let axis = self.axes[i];
        BarTruth {
            position: state.q + self.centres[i].arm,
            angle: match bar {
                Bar::Link1 => state.angles[0],
                Bar::Link2 => state.angles[1],
                Bar::Body | Bar::Link3 => libm::atan2(axis.y, axis.x),
            },
            velocity: self.centres[i].velocity(state),
            rate: self.turns[i].rate,
        }
    }

    /// Derivative of the position of a wheel's centre by coordinate `k` of the four, and of its velocity (m/s) by the rate
    /// of that coordinate: m/m or m/rad.
    pub(super) fn axle_column(&self, wheel: usize, k: usize) -> Vec2 {
        match k {
            0 => Vec2::x(),
            1 => Vec2::y(),
            2 => self.axles[wheel].j1,
            _ => self.axles[wheel].j2,
        }
    }

    /// Derivative of the velocity of a wheel's centre (m/s) by the angle of the link that carries it, 1/s.
    pub(super) fn axle_velocity_slope(&self, robot: &Robot, wheel: usize, state: &State) -> Vec2 {
        let rate = state.rates[2 + robot.geometry.carriers[wheel].index()];
        -self.axles[wheel].arm * rate
    }

    /// Acceleration of a wheel's centre (m/s^2) at the accelerations of the four coordinates.
    pub fn axle_acceleration(&self, wheel: usize, accelerations: &Vector4<f64>) -> Vec2 {
        self.axles[wheel].acceleration(accelerations)
    }

    /// Centre of a wheel, m.
    pub fn axle(&self, wheel: usize, state: &State) -> Vec2 {
        state.q + self.axles[wheel].arm
    }

    /// Motion of a wheel: centre, velocity, absolute spin.
    pub fn wheel(&self, robot: &Robot, wheel: usize, state: &State) -> WheelMotion {
        let link_rate = state.rates[2 + robot.geometry.carriers[wheel].index()];
        WheelMotion {
            centre: self.axle(wheel, state),
            velocity: self.axles[wheel].velocity(state),
            spin: state.omega[wheel] - link_rate,
        }
    }

    /// Mass matrix of the four rates, with the wheels as point masses on their axles; kg, kg m, kg m^2.
    pub fn mass_matrix(&self, robot: &Robot) -> Matrix4<f64> {
        let (mut m, mut unused) = (Matrix4::zeros(), Vector4::zeros());
        for bar in Bar::ALL {
            let ((own, inertia), i) = (robot.mass.of(bar), bar as usize);
            self.centres[i].add_mass(own, &mut m, &mut unused);
            self.turns[i].add_inertia(inertia, &mut m, &mut unused);
        }
        for axle in &self.axles {
            axle.add_mass(robot.mass.wheel, &mut m, &mut unused);
        }
        m.fill_upper_triangle_with_lower_triangle();
        m
    }

    /// Row of the Jacobian: its product with the four rates is the speed of a wheel's centre along `direction` (unit
    /// vector), m/s.
    pub fn axle_row(&self, wheel: usize, direction: Vec2) -> Vector4<f64> {
        let motion = &self.axles[wheel];
        let (j1, j2) = (motion.j1.dot(&direction), motion.j2.dot(&direction));
        Vector4::new(direction.x, direction.y, j1, j2)
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
    pub fn pins(&self, state: &State) -> [Vec2; 4] {
        let [p, r, s] = self.pins;
        [state.q + p, state.q, state.q + r, state.q + s]
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

    /// Adds a mass (kg) at this point to the mass matrix (lower triangle only), and its weight and bias force to the
    /// right-hand side.
    pub fn add_mass(&self, mass: f64, m: &mut Matrix4<f64>, right: &mut Vector4<f64>) {
        let (j1, j2) = (self.j1 * mass, self.j2 * mass);
        m[(0, 0)] += mass;
        m[(1, 1)] += mass;
        m[(2, 0)] += j1.x;
        m[(2, 1)] += j1.y;
        m[(2, 2)] += j1.dot(&self.j1);
        m[(3, 0)] += j2.x;
        m[(3, 1)] += j2.y;
        m[(3, 2)] += j2.dot(&self.j1);
        m[(3, 3)] += j2.dot(&self.j2);
        self.add_force((Vec2::new(0.0, -GRAVITY) - self.bias) * mass, right);
    }

    /// Adds a force (N) at this point to the right-hand side, by virtual power.
    pub fn add_force(&self, force: Vec2, right: &mut Vector4<f64>) {
        right[0] += force.x;
        right[1] += force.y;
        right[2] += self.j1.dot(&force);
        right[3] += self.j2.dot(&force);
    }
}

impl Turning {
    /// Angular rate, rad/s.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Adds the inertia (kg m^2) of a bar, as [`Motion::add_mass`] adds a mass.
    pub fn add_inertia(&self, inertia: f64, m: &mut Matrix4<f64>, right: &mut Vector4<f64>) {
        let (k1, k2) = (inertia * self.k1, inertia * self.k2);
        m[(2, 2)] += k1 * self.k1;
        m[(3, 2)] += k2 * self.k1;
        m[(3, 3)] += k2 * self.k2;
        right[2] -= k1 * self.bias;
        right[3] -= k2 * self.bias;
    }

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
