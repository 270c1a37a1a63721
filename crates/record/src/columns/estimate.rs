//! The columns of `estimate-NAME`.

use super::{Source, Table, WHEEL, pin_force_description};
use robhaz_estimator::{Confirmation, ContactState};
use robhaz_model::Pin;
use robhaz_score::estimated_needed_friction;

impl Table {
    /// `estimate-NAME`: the estimates of the run's estimator number `index` (from 0). A row without
    /// an estimate has its time, too.
    pub fn estimate(index: usize, name: &str) -> Self {
        let mut table = Self::new(format!("estimate-{name}"));
        for (i, of) in WHEEL.into_iter().enumerate() {
            columns! { table, estimate index; wheel(i), of;
                "normal_force", "N", "normal force N" => move |e| Some(e.normal_force[i]);
                "traction", "N", "traction T, driving forward positive" => move |e| Some(e.traction[i]);
                "needed_friction", "1", "needed friction mu_n = T/N, with Kalman filters also by what the ground's memory \
                 knows of the slope; empty without load" => move |e| Some(estimated_needed_friction(e, i)?.0);
            }
        }
        columns! { table, estimate index; "", "";
            "body_pitch", "rad", "body's pitch from the nominal pose, nose up positive" => |e| Some(e.posture.body);
        }
        for i in 0..3 {
            let (start, of) = (format!("link{}_", i + 1), format!("link{}: ", i + 1));
            columns! { table, estimate index; start, of;
                "angle", "rad", "turn from the nominal pose, counter-clockwise" => move |e| Some(e.posture.links[i]);
            }
        }
        table.add_pins(index);
        columns! { table, estimate index; "residual_", "what is left of eq. (8): ";
            "force_x", "N", "horizontal force" => |e| Some(e.residual[0]);
            "force_y", "N", "vertical force" => |e| Some(e.residual[1]);
            "moment_link1", "N m", "moment of link1 about Q" => |e| Some(e.residual[2]);
            "moment_link2", "N m", "moment of link2 about Q" => |e| Some(e.residual[3]);
        }
        table.add_stated_errors(index);
        (0..3).for_each(|i| table.add_contact_state(index, i));
        table
    }

    fn add_pins(&mut self, index: usize) {
        let pins = || Pin::ALL.into_iter().enumerate();
        let start = |pin: Pin| format!("pin_{}_", pin.name());
        // Q from Q is zero.
        for (k, pin) in pins().filter(|(_, pin)| *pin != Pin::Q) {
            let of = format!("pin {} from pin Q", pin.name().to_uppercase());
            columns! { self, estimate index; start(pin), of;
                "from_q_x", "m", ", forward" => move |e| Some(e.pin_from_q[k].x);
                "from_q_y", "m", ", up" => move |e| Some(e.pin_from_q[k].y);
            }
        }
        for (k, pin) in pins() {
            columns! { self, estimate index; start(pin), pin_force_description(pin);
                "force_x", "N", ", forward" => move |e| Some(e.pin_force[k].x);
                "force_y", "N", ", up" => move |e| Some(e.pin_force[k].y);
            }
        }
    }

    /// Stated standard deviations, parity and flags, and sensor errors that the estimator found.
    fn add_stated_errors(&mut self, index: usize) {
        columns! { self, estimate index; "", "";
            "parity", "N", "the redundancy of eq. (8), zero for consistent forces" => |e| e.parity.map(|p| p.value);
            "parity_sigma", "N", "standard deviation expected of the parity residual; empty without covariance" =>
                |e| e.parity.filter(|_| e.kalman.is_some()).map(|p| p.sigma);
            "flags", "1", "warnings, a bit each: wheels 1 to 3 unloaded 1, 2, 4; linkage at a stop 8; reading missing 16, stale \
             32, absurd 64; out of the model's range 128; spins in place 256; readings contradict each other 512" =>
                |e| Some(f64::from(e.flags.bits()));
            "faulty_channels", "1", "channels whose readings contradict others, a bit each: encoders 1, 2, 4; torques 8, 16, \
             32; contact angles 64, 128, 256; gyroscopes 512, 1024; inclinometers 2048, 4096; parity 8192; torque scale or \
             mass 16384; empty without Kalman filters" => |e| e.kalman.map(|k| f64::from(k.health.faulty.bits()));
            "weight", "1", "the torques against the described weight: 1 confirmed, 0 unconfirmed, -1 contradicts; empty \
             without Kalman filters and for one side of two" => |e| Some(weight(e.kalman?.torque_scale?.confirmation));
        }
        for (i, of) in WHEEL.into_iter().enumerate() {
            columns! { self, estimate index; wheel(i), of;
                "normal_force_sigma", "N", "standard deviation of N; empty without covariance" =>
                    move |e| e.sigma_normal(i);
                "traction_sigma", "N", "standard deviation of T; empty without covariance" => move |e| e.sigma_traction(i);
                "torque_offset", "N m", "offset found of the motor torque read; empty without Kalman filters" =>
                    move |e| e.kalman.map(|k| k.reading_errors.torque_offset[i].0);
                "contact_angle", "rad", "contact angle gamma, given or found" => move |e| Some(e.contact_angle[i]);
                "contact_angle_sigma", "rad", "standard deviation of the contact angle; empty without Kalman filters" =>
                    move |e| e.kalman.map(|k| k.contact_angle_sigma[i]);
                "contact_angle_error", "rad", "error found of the contact angle given; empty without Kalman filters or given \
                 angles" => move |e| Some(e.kalman?.reading_errors.contact_angle?[i].0);
            }
        }
        columns! { self, estimate index; "", "";
            "gear_friction", "N m", "dry friction found in the gears, common to all; empty without Kalman filters" =>
                |e| e.kalman.map(|k| k.reading_errors.gear_friction.0);
            "rolling_resistance", "1", "coefficient found of the rolling resistance, common to all; empty without Kalman \
             filters" => |e| e.kalman.map(|k| k.reading_errors.rolling_resistance.0);
        }
    }

    /// Estimated contact state of a wheel as small integers, its slip and its friction.
    fn add_contact_state(&mut self, index: usize, i: usize) {
        columns! { self, estimate index; wheel(i), WHEEL[i];
            "contacts", "1", "contacts found, 0 (in the air), 1 or 2; empty without Kalman filters" =>
                move |e| Some(contacts(e.kalman?.contact[i].state));
            "sliding", "1", "1 if it is found sliding, otherwise 0; empty without Kalman filters" =>
                move |e| Some(f64::from(u8::from(e.kalman?.contact[i].sliding)));
            "slip", "m/s", "slip speed found, rim less ground, creep included; empty without Kalman filters" =>
                move |e| Some(e.kalman?.contact[i].slip);
            "needed_friction_sigma", "1", "standard deviation of the needed friction; empty without load or Kalman filters" =>
                move |e| estimated_needed_friction(e, i)?.1;
            "friction_margin", "1", "upper bound of the known mu_max less |mu_n|; empty before a wheel has slipped" =>
                move |e| e.kalman?.friction[i].margin;
        }
    }
}

/// Number of contacts.
pub(super) fn contacts(state: ContactState) -> f64 {
    match state {
        ContactState::InAir => 0.0,
        ContactState::OneContact => 1.0,
        ContactState::TwoContacts => 2.0,
    }
}

/// What follows from the torques' scale as a small number.
pub(super) fn weight(confirmation: Confirmation) -> f64 {
    match confirmation {
        Confirmation::Confirmed => 1.0,
        Confirmation::Unconfirmed => 0.0,
        Confirmation::Contradicts => -1.0,
    }
}

/// Start of the names of a wheel's columns.
fn wheel(i: usize) -> String {
    format!("wheel{}_", i + 1)
}
