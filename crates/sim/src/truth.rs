//! What truly happens at one instant.

use robhaz_model::{Bar, Pin, Robot, Vec2, perp};

/// Pose and rates of a bar. The position is that of its centre of mass (without wheels).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BarTruth {
    /// Centre of mass, m.
    pub position: Vec2,
    /// Turn from the nominal pose, rad.
    pub angle: f64,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vec2,
    /// Angular rate, rad/s.
    pub rate: f64,
}

/// State of a wheel and what acts on it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelTruth {
    /// Centre, m.
    pub position: Vec2,
    /// Spin relative to the carrying link since the start, rad, forward positive (what an encoder counts).
    pub angle: f64,
    /// Spin speed relative to the carrying link, rad/s, forward positive.
    pub omega: f64,
    /// Motor torque at the wheel, N m, forward positive.
    pub torque: f64,
    /// Normal force N >= 0, N; of two contacts, the magnitude of their normal forces' vector sum.
    pub normal_force: f64,
    /// Traction T, N, driving forward positive; of two contacts the sum.
    pub traction: f64,
    /// Contact angle gamma, rad; of two contacts, that of the normal forces' vector sum; in the air, that of the
    /// nearest ground.
    pub contact_angle: f64,
    /// Penetration, m; of two contacts the deeper; in the air the gap, negative.
    pub penetration: f64,
    /// Slip speed at that contact, m/s, positive when the rim outruns the ground.
    pub slip_speed: f64,
    /// Number of contacts.
    pub contacts: u32,
}

/// Position of a pin and the force it carries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PinTruth {
    /// Position, m.
    pub position: Vec2,
    /// Force on the first bar of [`Pin::bars`] from the second, N.
    pub force: Vec2,
}

/// Everything at one instant, SI, signs as in the crate `robhaz-model`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Time since the start, s.
    pub time: f64,
    /// The body.
    pub body: BarTruth,
    /// Links 1 to 3.
    pub links: [BarTruth; 3],
    /// Front, middle and rear wheel.
    pub wheels: [WheelTruth; 3],
    /// P, Q, R, S in the order of [`Pin::ALL`].
    pub pins: [PinTruth; 4],
    /// Torque of the end stops on link 1, N m.
    pub stop_torque: f64,
    /// Greatest distance between the two bars' images of a pin, m: how far the loop is open.
    pub loop_error: f64,
}

impl Truth {
    /// One bar.
    pub fn bar(&self, bar: Bar) -> &BarTruth {
        match bar {
            Bar::Body => &self.body,
            Bar::Link1 => &self.links[0],
            Bar::Link2 => &self.links[1],
            Bar::Link3 => &self.links[2],
        }
    }

    /// Velocity of a wheel's centre, m/s: it is fixed to its link.
    pub fn wheel_velocity(&self, robot: &Robot, wheel: usize) -> Vec2 {
        let link = self.bar(robot.geometry.carriers[wheel].bar());
        let arm = self.wheels[wheel].position - link.position;
        link.velocity + perp(arm) * link.rate
    }

    /// One pin.
    pub fn pin(&self, pin: Pin) -> &PinTruth {
        match pin {
            Pin::P => &self.pins[0],
            Pin::Q => &self.pins[1],
            Pin::R => &self.pins[2],
            Pin::S => &self.pins[3],
        }
    }
}
