//! The columns of `estimate-NAME`.

use super::column::{Column, Table, WHEEL, of_estimate, pin_force_description, time_of_record};
use robhaz_estimator::ContactState;
use robhaz_model::Pin;
use robhaz_score::estimated_needed_friction;

impl Table {
    /// `estimate-NAME`: the estimates of the run's estimator number `index` (from 0).
    pub fn estimate(index: usize, name: &str) -> Self {
        // The time of the record: a row without an estimate has it, too.
        let mut columns = vec![time_of_record()];
        (0..3).for_each(|wheel| columns.extend(wheel_estimate(index, wheel)));
        columns.extend(linkage_estimate(index));
        columns.extend(residuals(index));
        columns.extend(stated_errors(index));
        Self {
            name: format!("estimate-{name}"),
            columns,
        }
    }
}

fn wheel_estimate(index: usize, i: usize) -> [Column; 3] {
    let (n, wheel) = (i + 1, WHEEL[i]);
    [
        of_estimate(
            index,
            format!("wheel{n}_normal_force"),
            "N",
            format!("{wheel}: normal force N"),
            move |e| Some(e.normal_force[i]),
        ),
        of_estimate(
            index,
            format!("wheel{n}_traction"),
            "N",
            format!("{wheel}: traction T, driving forward positive"),
            move |e| Some(e.traction[i]),
        ),
        of_estimate(
            index,
            format!("wheel{n}_needed_friction"),
            "1",
            format!(
                "{wheel}: needed friction mu_n = T/N, with Kalman filters also by what the ground's \
                 memory knows of the slope; empty without load"
            ),
            move |e| Some(estimated_needed_friction(e, i)?.0),
        ),
    ]
}

fn linkage_estimate(index: usize) -> Vec<Column> {
    let mut columns = vec![of_estimate(
        index,
        "body_pitch",
        "rad",
        "body's pitch from the nominal pose, nose up positive",
        |e| Some(e.posture.body),
    )];
    for i in 0..3 {
        let link = format!("link{}", i + 1);
        columns.push(of_estimate(
            index,
            format!("{link}_angle"),
            "rad",
            format!("{link}: turn from the nominal pose, counter-clockwise"),
            move |e| Some(e.posture.links[i]),
        ));
    }
    // Q from Q is zero.
    for (k, pin) in Pin::ALL.into_iter().enumerate() {
        if pin != Pin::Q {
            columns.extend(pin_from_q_estimate(index, k, pin));
        }
    }
    for (k, pin) in Pin::ALL.into_iter().enumerate() {
        columns.extend(pin_force_estimate(index, k, pin));
    }
    columns
}

fn pin_from_q_estimate(index: usize, k: usize, pin: Pin) -> [Column; 2] {
    let p = pin.name();
    let letter = p.to_uppercase();
    [
        of_estimate(
            index,
            format!("pin_{p}_from_q_x"),
            "m",
            format!("pin {letter} from pin Q, forward"),
            move |e| Some(e.pin_from_q[k].x),
        ),
        of_estimate(
            index,
            format!("pin_{p}_from_q_y"),
            "m",
            format!("pin {letter} from pin Q, up"),
            move |e| Some(e.pin_from_q[k].y),
        ),
    ]
}

fn pin_force_estimate(index: usize, k: usize, pin: Pin) -> [Column; 2] {
    let p = pin.name();
    let force = pin_force_description(pin);
    [
        of_estimate(
            index,
            format!("pin_{p}_force_x"),
            "N",
            format!("{force}, forward"),
            move |e| Some(e.pin_force[k].x),
        ),
        of_estimate(
            index,
            format!("pin_{p}_force_y"),
            "N",
            format!("{force}, up"),
            move |e| Some(e.pin_force[k].y),
        ),
    ]
}

fn residuals(index: usize) -> [Column; 4] {
    let column = |row: usize, name: &str, unit, what: &str| {
        of_estimate(
            index,
            name,
            unit,
            format!("what is left of eq. (8): {what}"),
            move |e| Some(e.residual[row]),
        )
    };
    [
        column(0, "residual_force_x", "N", "horizontal force"),
        column(1, "residual_force_y", "N", "vertical force"),
        column(2, "residual_moment_link1", "N m", "moment of link1 about Q"),
        column(3, "residual_moment_link2", "N m", "moment of link2 about Q"),
    ]
}

/// Stated standard deviations, parity and flags, and sensor errors that the estimator found.
fn stated_errors(index: usize) -> Vec<Column> {
    let mut columns = vec![
        of_estimate(
            index,
            "parity",
            "N",
            "the redundancy of eq. (8), zero for consistent forces",
            |e| e.parity.map(|p| p.value),
        ),
        of_estimate(
            index,
            "parity_sigma",
            "N",
            "standard deviation expected of the parity residual; empty without covariance",
            |e| e.parity.filter(|_| e.covariance.is_some()).map(|p| p.sigma),
        ),
        of_estimate(
            index,
            "flags",
            "1",
            "warnings, a bit each: wheels 1 to 3 unloaded 1, 2, 4; linkage at a stop 8; reading missing 16, stale 32, absurd 64; \
             out of the model's range 128; spins in place 256; readings contradict each other 512",
            |e| Some(f64::from(e.flags.bits())),
        ),
        of_estimate(
            index,
            "suspect_channels",
            "1",
            "channels whose readings contradict others, a bit each: encoders 1, 2, 4; torques 8, 16, 32; contact angles 64, 128, \
             256; gyroscopes 512, 1024; inclinometers 2048, 4096; parity 8192; torque scale or mass 16384; empty without Kalman filters",
            |e| e.health.map(|health| f64::from(health.suspect.bits())),
        ),
    ];
    for (i, wheel) in WHEEL.into_iter().enumerate() {
        let name = |what: &str| format!("wheel{}_{what}", i + 1);
        columns.push(of_estimate(
            index,
            name("normal_force_sigma"),
            "N",
            format!("{wheel}: standard deviation of N; empty without covariance"),
            move |e| e.sigma_normal(i),
        ));
        columns.push(of_estimate(
            index,
            name("traction_sigma"),
            "N",
            format!("{wheel}: standard deviation of T; empty without covariance"),
            move |e| e.sigma_traction(i),
        ));
        columns.push(of_estimate(
            index,
            name("torque_offset"),
            "N m",
            format!("{wheel}: offset found of the motor torque read; empty without Kalman filters"),
            move |e| e.reading_errors.map(|r| r.torque_offset[i].0),
        ));
        columns.push(of_estimate(
            index,
            name("contact_angle"),
            "rad",
            format!("{wheel}: contact angle gamma, given or found"),
            move |e| Some(e.contact_angle[i]),
        ));
        columns.push(of_estimate(
            index,
            name("contact_angle_sigma"),
            "rad",
            format!(
                "{wheel}: standard deviation of the contact angle; empty without Kalman filters"
            ),
            move |e| e.contact_angle_sigma.map(|sigma| sigma[i]),
        ));
        columns.push(of_estimate(
            index,
            name("contact_angle_error"),
            "rad",
            format!(
                "{wheel}: error found of the contact angle given; empty without Kalman filters or given angles"
            ),
            move |e| Some(e.reading_errors?.contact_angle?[i].0),
        ));
    }
    columns.push(of_estimate(
        index,
        "gear_friction",
        "N m",
        "dry friction found in the gears, common to all; empty without Kalman filters",
        |e| e.reading_errors.map(|r| r.gear_friction.0),
    ));
    (0..3).for_each(|i| columns.extend(contact_states(index, i)));
    columns
}

/// Estimated contact state of a wheel as small integers, its slip and its friction.
fn contact_states(index: usize, i: usize) -> [Column; 5] {
    let (n, wheel) = (i + 1, WHEEL[i]);
    [
        of_estimate(
            index,
            format!("wheel{n}_contacts"),
            "1",
            format!(
                "{wheel}: contacts found, 0 (in the air), 1 or 2; empty without Kalman filters"
            ),
            move |e| {
                Some(match e.contact?[i].state {
                    ContactState::InAir => 0.0,
                    ContactState::OneContact => 1.0,
                    ContactState::TwoContacts => 2.0,
                })
            },
        ),
        of_estimate(
            index,
            format!("wheel{n}_sliding"),
            "1",
            format!("{wheel}: 1 if it is found sliding, otherwise 0; empty without Kalman filters"),
            move |e| Some(f64::from(u8::from(e.contact?[i].sliding))),
        ),
        of_estimate(
            index,
            format!("wheel{n}_slip"),
            "m/s",
            format!(
                "{wheel}: slip speed found, rim less ground, creep included; empty without Kalman filters"
            ),
            move |e| Some(e.contact?[i].slip),
        ),
        of_estimate(
            index,
            format!("wheel{n}_needed_friction_sigma"),
            "1",
            format!(
                "{wheel}: standard deviation of the needed friction; empty without load or Kalman filters"
            ),
            move |e| estimated_needed_friction(e, i)?.1,
        ),
        of_estimate(
            index,
            format!("wheel{n}_friction_margin"),
            "1",
            format!(
                "{wheel}: upper bound of the known mu_max less |mu_n|; empty before a wheel has slipped"
            ),
            move |e| e.friction?[i].margin,
        ),
    ]
}
