//! The columns of `truth`.

use super::{Source, Table, WHEEL, pin_force_description};
use robhaz_model::Pin;
use robhaz_sim::ContactTruth;

impl Table {
    /// `truth`: motion and forces of the simulation.
    pub fn truth() -> Self {
        let mut table = Self::new("truth");
        columns! { table, Source::truth; "body_", "body's ";
            "x", "m", "centre of mass, forward" => |t| t.body.position.x;
            "y", "m", "centre of mass, up" => |t| t.body.position.y;
            "pitch", "rad", "pitch from the nominal pose, nose up positive" => |t| t.body.angle;
        }
        columns! { table, Source::truth; "body_", "";
            "vx", "m/s", "velocity of the body's centre of mass, forward" => |t| t.body.velocity.x;
            "vy", "m/s", "velocity of the body's centre of mass, up" => |t| t.body.velocity.y;
            "pitch_rate", "rad/s", "body's pitch rate" => |t| t.body.rate;
        }
        for i in 0..3 {
            let (start, of) = (format!("link{}_", i + 1), format!("link{}: ", i + 1));
            columns! { table, Source::truth; start, of;
                "angle", "rad", "turn from the nominal pose, counter-clockwise" => move |t| t.links[i].angle;
                "x", "m", "centre of mass, forward" => move |t| t.links[i].position.x;
                "y", "m", "centre of mass, up" => move |t| t.links[i].position.y;
                "vx", "m/s", "velocity of the centre of mass, forward" => move |t| t.links[i].velocity.x;
                "vy", "m/s", "velocity of the centre of mass, up" => move |t| t.links[i].velocity.y;
                "rate", "rad/s", "angular rate, counter-clockwise" => move |t| t.links[i].rate;
            }
        }
        (0..3).for_each(|i| table.add_wheel(i));
        Pin::ALL.into_iter().for_each(|pin| table.add_pin(pin));
        columns! { table, Source::truth; "", "";
            "stop_torque", "N m", "torque of the end stops in Q on link1" => |t| t.stop_torque;
            "loop_error", "m", "how far the four-bar's loop has drifted open in the simulation" => |t| t.loop_error;
        }
        columns! { table, Source::record_or_none; "", "";
            "clearance", "m", "least distance of body and links to the ground; at 0 or below one touches it, and its force is \
             not modelled" => |f| Some(f.clearances?.least.1);
        }
        (0..3).for_each(|i| table.add_contacts(i));
        table
    }

    fn add_wheel(&mut self, i: usize) {
        let start = format!("wheel{}_", i + 1);
        columns! { self, Source::truth; start, WHEEL[i];
            "x", "m", "centre, forward" => move |t| t.wheels[i].position.x;
            "y", "m", "centre, up" => move |t| t.wheels[i].position.y;
            "angle", "rad", "turn against its link since the start, forward positive" => move |t| t.wheels[i].angle;
            "omega", "rad/s", "speed against its link, forward positive" => move |t| t.wheels[i].omega;
            "torque", "N m", "motor torque at the wheel, forward positive" => move |t| t.wheels[i].torque;
            "normal_force", "N", "normal force N; two contacts: magnitude of the vector sum of their normal forces" =>
                move |t| t.wheels[i].normal_force;
            "traction", "N", "traction T, driving forward positive; two contacts: the sum" =>
                move |t| t.wheels[i].traction;
            "contact_angle", "rad", "contact angle gamma, slope of the ground at the contact; two contacts: perpendicular to \
             the vector sum of their normal forces" => move |t| t.wheels[i].contact_angle;
            "penetration", "m", "penetration into the ground, the larger one; in the air the gap, negative" =>
                move |t| t.wheels[i].penetration;
            "slip_speed", "m/s", "slip speed, positive when the rim outruns the ground; two contacts: of the deeper one" =>
                move |t| t.wheels[i].slip_speed;
        }
        columns! { self, Source::truth_count; start, WHEEL[i];
            "contacts", "1", "number of contacts" => move |t| t.wheels[i].contacts;
        }
    }

    fn add_pin(&mut self, pin: Pin) {
        let (start, of) = (
            format!("pin_{}_", pin.name()),
            format!("pin {}", pin.name().to_uppercase()),
        );
        columns! { self, Source::truth; start, of;
            "x", "m", ", forward" => move |t| t.pin(pin).position.x;
            "y", "m", ", up" => move |t| t.pin(pin).position.y;
        }
        columns! { self, Source::truth; start, pin_force_description(pin);
            "force_x", "N", ", forward" => move |t| t.pin(pin).force.x;
            "force_y", "N", ", up" => move |t| t.pin(pin).force.y;
        }
    }

    /// The equivalent contact, whether the wheel slides, and its contacts one by one.
    fn add_contacts(&mut self, i: usize) {
        let start = format!("wheel{}_", i + 1);
        columns! { self, Source::record_or_none; start, WHEEL[i];
            "equivalent_normal_force", "N", "N of the equivalent contact, which has the same force on the axle and the same T \
             as all contacts together; errors of the estimates refer to it; empty where there is none" =>
                move |f| f.truth?.wheels[i].equivalent_contact().map(|c| c.normal_force);
            "equivalent_contact_angle", "rad", "contact angle of the equivalent contact; empty where there is none" =>
                move |f| f.truth?.wheels[i].equivalent_contact().map(|c| c.angle);
        }
        columns! { self, Source::truth_count; start, WHEEL[i];
            "sliding", "1", "1 if it slides: the slip of each of its contacts is beyond the peak of the friction law; \
             otherwise 0" => move |t| u32::from(t.wheels[i].slides);
        }
        for (k, which) in ["first (rear) contact", "second (front) contact"]
            .into_iter()
            .enumerate()
        {
            let (start, of) = (
                format!("{start}contact{}_", k + 1),
                format!("{}{which}: ", WHEEL[i]),
            );
            let contact = move |get: fn(&ContactTruth) -> f64| {
                Source::record_or_none(move |f| f.truth?.wheels[i].contact_list.get(k).map(get))
            };
            columns! { self, contact; start, of;
                "x", "m", "point of the ground, forward; empty without it" => |c| c.point.x;
                "y", "m", "point of the ground, up; empty without it" => |c| c.point.y;
                "angle", "rad", "slope of its tangent; the normal is 90 deg counter-clockwise from it; empty without it" =>
                    |c| (-c.normal.x).atan2(c.normal.y);
                "normal_force", "N", "normal force; empty without it" => |c| c.normal_force;
                "traction", "N", "traction, driving forward positive; empty without it" => |c| c.traction;
                "penetration", "m", "penetration; empty without it" => |c| c.penetration;
                "slip_speed", "m/s", "slip speed, positive when the rim outruns the ground; empty without it" =>
                    |c| c.slip_speed;
            }
        }
    }
}
