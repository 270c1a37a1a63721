//! The equations of motion in minimal coordinates: Q's position, the angles of links 1 and 2, three wheel spins.
//!
//! The loop is closed analytically, so pins cannot drift. Every body's velocity is `J v` with `v = [Qx' Qy' theta_1'
//! theta_2']` and its acceleration `J v' + b`; virtual power then gives `M v' = sum J' (f - m b)`, 4 equations. The spins
//! relative to the links follow from eq. (2) and are eliminated from them. Pin forces come from Newton and Euler afterwards.

use crate::drive::wheel_acceleration;
use crate::ground::{GroundForces, WheelMotion};
use crate::stop::stop_torque;
use crate::truth::BarTruth;
use nalgebra::{Matrix4, Vector3, Vector4};
use robhaz_model::{Bar, GRAVITY, PostureError, Robot, Vec2, corner_s, cross, perp, turned};

/// Positions and rates: what the forces depend on.
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

/// Why a state has no forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NoForces {
    /// The four-bar cannot close.
    Loop(PostureError),
    /// A wheel's centre is below the ground: index and x, m.
    BelowGround(usize, f64),
    /// The mass matrix is not positive definite.
    Singular,
}

/// How a point or a bar moves with the four rates.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    /// Where, relative to Q, m.
    arm: Vec2,
    /// Velocity is `vQ + w1 j1 + w2 j2`, m.
    j1: Vec2,
    j2: Vec2,
    /// Acceleration that is there without that of the rates, m/s^2.
    bias: Vec2,
}

/// How a bar turns: rate `k1 w1 + k2 w2` and the acceleration beyond `k1 w1' + k2 w2'`.
#[derive(Clone, Copy, Debug, Default)]
struct Turning {
    k1: f64,
    k2: f64,
    rate: f64,
    bias: f64,
}

/// Everything geometric at one state.
pub(crate) struct Kinematics {
    /// Unit vectors along the turned x axis of each bar, in the order of [`Bar::ALL`].
    axes: [Vec2; 4],
    turns: [Turning; 4],
    /// Centres of mass of the bars, in the order of [`Bar::ALL`].
    centres: [Motion; 4],
    axles: [Motion; 3],
    /// P, R and S relative to Q, m.
    pins: [Vec2; 3],
}

/// Accelerations at one state, and the forces that go with them.
pub(crate) struct Forces {
    /// Rates of [`State::rates`].
    pub accelerations: Vector4<f64>,
    /// Rates of [`State::omega`], rad/s^2.
    pub omega_rates: Vector3<f64>,
    /// What the ground does to each wheel.
    pub ground: [GroundForces; 3],
    /// Torque of the end stops on link 1, N m.
    pub stop_torque: f64,
}

/// The unit vector of the turn that takes `from` into the direction of `to`.
fn turn_between(from: Vec2, to: Vec2) -> Vec2 {
    Vec2::new(from.dot(&to), cross(from, to)).normalize()
}

impl Kinematics {
    pub fn new(robot: &Robot, state: &State) -> Result<Self, NoForces> {
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
        let s = corner_s(geometry, p, r).map_err(NoForces::Loop)?;
        let axis_body = turn_between(pins.s - pins.p, s - p);
        let axis3 = turn_between(pins.s - pins.r, s - r);

        // Velocity closure, perp(.) left out: wb c - w3 d = w2 r - w1 p.
        let (c, d) = (s - p, s - r);
        let det = -cross(c, d);
        let mut body = Turning {
            k1: cross(p, d) / det,
            k2: -cross(r, d) / det,
            ..Turning::default()
        };
        let mut link3 = Turning {
            k1: -cross(c, p) / det,
            k2: cross(c, r) / det,
            ..Turning::default()
        };
        body.rate = body.k1 * w1 + body.k2 * w2;
        link3.rate = link3.k1 * w1 + link3.k2 * w2;
        // Acceleration closure: the centripetal terms take the place of the right side.
        let g = p * (w1 * w1) + c * (body.rate * body.rate)
            - r * (w2 * w2)
            - d * (link3.rate * link3.rate);
        let g = Vec2::new(g.y, -g.x);
        body.bias = -cross(g, d) / det;
        link3.bias = cross(c, g) / det;

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
        // A point on a bar that hangs on a pin of link 1 or 2.
        let beyond = |pin: Motion, turning: &Turning, arm: Vec2| Motion {
            arm: pin.arm + arm,
            j1: pin.j1 + perp(arm) * turning.k1,
            j2: pin.j2 + perp(arm) * turning.k2,
            bias: pin.bias + perp(arm) * turning.bias - arm * (turning.rate * turning.rate),
        };
        let centres = [
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
        let axles = [0, 1, 2].map(|i| match geometry.carriers[i].bar() {
            Bar::Link1 => on_link1(geometry.axles[i]),
            _ => on_link2(geometry.axles[i]),
        });
        let link = |k1: f64, k2: f64, rate| Turning {
            k1,
            k2,
            rate,
            bias: 0.0,
        };
        Ok(Self {
            axes: [axis_body, axis1, axis2, axis3],
            turns: [body, link(1.0, 0.0, w1), link(0.0, 1.0, w2), link3],
            centres,
            axles,
            pins: [p, r, s],
        })
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
                Bar::Body | Bar::Link3 => axis.y.atan2(axis.x),
            },
            velocity: self.centres[i].velocity(state),
            rate: self.turns[i].rate,
        }
    }

    /// Centre of a wheel, m.
    pub fn axle(&self, wheel: usize, state: &State) -> Vec2 {
        state.q + self.axles[wheel].arm
    }

    /// How a wheel moves.
    pub fn wheel(&self, robot: &Robot, wheel: usize, state: &State) -> WheelMotion {
        let link_rate = state.rates[2 + robot.geometry.carriers[wheel].index()];
        WheelMotion {
            centre: self.axle(wheel, state),
            velocity: self.axles[wheel].velocity(state),
            spin: state.omega[wheel] - link_rate,
        }
    }

    /// Mass matrix of the four rates, the wheels as point masses on their axles; kg, kg m, kg m^2.
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

    /// What gives the speed of a wheel's centre along `direction` from the four rates.
    pub fn axle_row(&self, wheel: usize, direction: Vec2) -> Vector4<f64> {
        let motion = &self.axles[wheel];
        let (j1, j2) = (motion.j1.dot(&direction), motion.j2.dot(&direction));
        Vector4::new(direction.x, direction.y, j1, j2)
    }

    /// Distance between S on the body and S on link 3, m: what rounding leaves of the closed loop.
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
    fn velocity(&self, state: &State) -> Vec2 {
        let v = &state.rates;
        Vec2::new(v[0], v[1]) + self.j1 * v[2] + self.j2 * v[3]
    }

    fn acceleration(&self, a: &Vector4<f64>) -> Vec2 {
        Vec2::new(a[0], a[1]) + self.j1 * a[2] + self.j2 * a[3] + self.bias
    }

    /// Adds a mass moving like this to `M` (its lower half) and its gravity and bias to the right side.
    fn add_mass(&self, mass: f64, m: &mut Matrix4<f64>, right: &mut Vector4<f64>) {
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

    /// Adds a force at this point to the right side.
    fn add_force(&self, force: Vec2, right: &mut Vector4<f64>) {
        right[0] += force.x;
        right[1] += force.y;
        right[2] += self.j1.dot(&force);
        right[3] += self.j2.dot(&force);
    }
}

impl Turning {
    /// As [`Motion::add_mass`].
    fn add_inertia(&self, inertia: f64, m: &mut Matrix4<f64>, right: &mut Vector4<f64>) {
        let (k1, k2) = (inertia * self.k1, inertia * self.k2);
        m[(2, 2)] += k1 * self.k1;
        m[(3, 2)] += k2 * self.k1;
        m[(3, 3)] += k2 * self.k2;
        right[2] -= k1 * self.bias;
        right[3] -= k2 * self.bias;
    }

    fn acceleration(&self, a: &Vector4<f64>) -> f64 {
        self.k1 * a[2] + self.k2 * a[3] + self.bias
    }
}

impl Forces {
    /// Solves the equations of motion. `drive_torque` is that of [`wheel_acceleration`], N m; `act` gives what the ground does
    /// to a wheel, or the x (m) of one whose centre is below it.
    pub fn new(
        robot: &Robot,
        kinematics: &Kinematics,
        state: &State,
        drive_torque: [f64; 3],
        mut act: impl FnMut(usize, &WheelMotion) -> Result<GroundForces, f64>,
    ) -> Result<Self, NoForces> {
        let (geometry, mass) = (&robot.geometry, &robot.mass);
        let (mut m, mut right) = (Matrix4::zeros(), Vector4::zeros());
        for bar in Bar::ALL {
            let ((own, inertia), i) = (mass.of(bar), bar as usize);
            kinematics.centres[i].add_mass(own, &mut m, &mut right);
            kinematics.turns[i].add_inertia(inertia, &mut m, &mut right);
        }
        let (jw, jr) = (mass.wheel_inertia, mass.rotor_inertia);
        let mut act = |i: usize| {
            act(i, &kinematics.wheel(robot, i, state)).map_err(|x| NoForces::BelowGround(i, x))
        };
        let ground = [act(0)?, act(1)?, act(2)?];
        for i in 0..3 {
            let (axle, row) = (&kinematics.axles[i], 2 + geometry.carriers[i].index());
            axle.add_mass(mass.wheel, &mut m, &mut right);
            axle.add_force(ground[i].force, &mut right);
            // Eq. (2) solved for the spin's acceleration and put into the link's equation: of the disc's inertia what the
            // rotor holds against, of the drive's torque what turns the disc.
            m[(row, row)] += jw * jr / (jw + jr);
            right[row] += ground[i].torque + jw / (jw + jr) * (drive_torque[i] - ground[i].torque);
        }
        let stop = stop_torque(
            &geometry.stop,
            state.angles[0] - state.angles[1],
            state.rates[2] - state.rates[3],
        );
        right[2] += stop;
        right[3] -= stop;
        // It reads the lower half only.
        let accelerations = m.cholesky().ok_or(NoForces::Singular)?.solve(&right);
        let mut omega_rates = Vector3::zeros();
        for i in 0..3 {
            let alpha_link = accelerations[2 + geometry.carriers[i].index()];
            omega_rates[i] =
                wheel_acceleration(drive_torque[i], ground[i].torque, alpha_link, jw, jr);
        }
        Ok(Self {
            accelerations,
            omega_rates,
            ground,
            stop_torque: stop,
        })
    }

    /// Forces in P, Q, R, S on the first bar of `Pin::bars`, N: Newton and Euler for body and link 3, then Newton for link 1.
    pub fn pin_forces(&self, robot: &Robot, kinematics: &Kinematics) -> [Vec2; 4] {
        let mass = &robot.mass;
        let a = &self.accelerations;
        let gravity = Vec2::new(0.0, -GRAVITY);
        // What the other forces on a mass must add up to.
        let needed = |m: f64, motion: &Motion| (motion.acceleration(a) - gravity) * m;
        let [p, r, s] = kinematics.pins;
        let on_body = needed(mass.body, &kinematics.centres[0]);
        let on_link3 = needed(mass.links[2], &kinematics.centres[3]);
        // Moments about P (body) and about R (link 3) hold S alone.
        let moment_body = mass.body_inertia * kinematics.turns[0].acceleration(a)
            + cross(kinematics.centres[0].arm - p, on_body);
        let moment_link3 = mass.link_inertias[2] * kinematics.turns[3].acceleration(a)
            + cross(kinematics.centres[3].arm - r, on_link3);
        // (S - P) x s = moment_body, (S - R) x (-s) = moment_link3.
        let (c, d) = (s - p, s - r);
        let force_s = (d * moment_body + c * moment_link3) / cross(c, d);
        let force_p = on_body - force_s;
        let force_r = on_link3 + force_s;
        let mut force_q = force_p + needed(mass.links[0], &kinematics.centres[1]);
        for (i, carrier) in robot.geometry.carriers.iter().enumerate() {
            if carrier.bar() == Bar::Link1 {
                force_q += needed(mass.wheel, &kinematics.axles[i]) - self.ground[i].force;
            }
        }
        [force_p, force_q, force_r, force_s]
    }
}
