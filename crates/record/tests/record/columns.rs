//! Names, order, units and sources of the columns, which scripts rely on.

use crate::testing::{Record, described, failed_frame, frame_of, good_estimate, scene, value_of};
use robhaz_estimator::{
    ContactEstimate, ContactState, KalmanReport, NeededFriction, WheelFriction,
};
use robhaz_model::{Vec2, WheelCommand};
use robhaz_record::Table;
use robhaz_run::Frame;
use robhaz_scene::{ControlChoice, ControlKind, Scene};
use robhaz_sim::ContactTruth;
use std::collections::HashSet;

fn names(table: &Table) -> Vec<&str> {
    table.columns.iter().map(|c| c.name.as_str()).collect()
}

/// Scripts and notebooks rely on these names and their order.
#[test]
fn names_of_the_truth_are_fixed() {
    let mut golden: Vec<String> = [
        "time",
        "body_x",
        "body_y",
        "body_pitch",
        "body_vx",
        "body_vy",
        "body_pitch_rate",
    ]
    .map(String::from)
    .to_vec();
    for n in 1..=3 {
        for part in ["angle", "x", "y", "vx", "vy", "rate"] {
            golden.push(format!("link{n}_{part}"));
        }
    }
    for n in 1..=3 {
        for part in [
            "x",
            "y",
            "angle",
            "omega",
            "torque",
            "normal_force",
            "traction",
            "contact_angle",
            "penetration",
            "slip_speed",
            "contacts",
        ] {
            golden.push(format!("wheel{n}_{part}"));
        }
    }
    for pin in ["p", "q", "r", "s"] {
        for part in ["x", "y", "force_x", "force_y"] {
            golden.push(format!("pin_{pin}_{part}"));
        }
    }
    golden.extend(["stop_torque", "loop_error", "clearance"].map(String::from));
    for n in 1..=3 {
        for part in "equivalent_normal_force equivalent_contact_angle sliding".split(' ') {
            golden.push(format!("wheel{n}_{part}"));
        }
        for contact in 1..=2 {
            for part in "x y angle normal_force traction penetration slip_speed".split(' ') {
                golden.push(format!("wheel{n}_contact{contact}_{part}"));
            }
        }
    }
    assert_eq!(names(&Table::truth()), golden);
}

#[test]
fn names_of_the_readings_are_fixed() {
    let golden = "time wheel1_angle wheel1_motor_torque wheel1_contact_angle wheel2_angle wheel2_motor_torque \
        wheel2_contact_angle wheel3_angle wheel3_motor_torque wheel3_contact_angle link1_inclination link1_rate \
        link1_rate_error link2_inclination link2_rate link2_rate_error";
    assert_eq!(
        names(&Table::sensors()),
        golden.split_whitespace().collect::<Vec<_>>()
    );
}

#[test]
fn names_of_the_commands_are_fixed() {
    let golden = "time wheel1_torque_command wheel1_speed_command wheel2_torque_command wheel2_speed_command \
        wheel3_torque_command wheel3_speed_command";
    assert_eq!(
        names(&Table::commands()),
        golden.split_whitespace().collect::<Vec<_>>()
    );
}

/// Each command is in the column of its form, and in no other. Only runs whose control takes
/// readings have the table.
#[test]
fn commands_have_one_form() {
    let record = frame_of(0.5);
    let frame = Frame {
        commands: Some([
            WheelCommand::Torque(1.5),
            WheelCommand::Speed(2.5),
            WheelCommand::Planned,
        ]),
        ..record.frame()
    };
    let values: Vec<Option<f64>> = Table::commands()
        .columns
        .iter()
        .map(|c| value_of(c, &frame))
        .collect();
    let mut expected = vec![Some(0.5)];
    let wheels = [Some(1.5), None, None, Some(2.5), None, None];
    expected.extend(wheels);
    assert_eq!(values, expected);
    let mut scene = scene();
    let has = |scene: &Scene| {
        let tables = Table::all(&described(scene));
        tables.iter().any(|t| t.name == "commands")
    };
    assert!(!has(&scene));
    scene.control = ControlChoice {
        kind: ControlKind::Shared,
        estimator: Some("mine".to_owned()),
        ..scene.control.clone()
    };
    assert!(has(&scene));
}

#[test]
fn names_of_an_estimate_are_fixed() {
    let golden = "time wheel1_normal_force wheel1_traction wheel1_needed_friction wheel2_normal_force \
        wheel2_traction wheel2_needed_friction wheel3_normal_force wheel3_traction \
        wheel3_needed_friction body_pitch link1_angle link2_angle link3_angle pin_p_from_q_x pin_p_from_q_y \
        pin_r_from_q_x pin_r_from_q_y pin_s_from_q_x pin_s_from_q_y pin_p_force_x pin_p_force_y pin_q_force_x \
        pin_q_force_y pin_r_force_x pin_r_force_y pin_s_force_x pin_s_force_y residual_force_x residual_force_y \
        residual_moment_link1 residual_moment_link2 parity parity_sigma flags faulty_channels weight \
        wheel1_normal_force_sigma wheel1_traction_sigma wheel1_torque_offset wheel1_contact_angle wheel1_contact_angle_sigma \
        wheel1_contact_angle_error \
        wheel2_normal_force_sigma wheel2_traction_sigma wheel2_torque_offset wheel2_contact_angle wheel2_contact_angle_sigma \
        wheel2_contact_angle_error \
        wheel3_normal_force_sigma wheel3_traction_sigma wheel3_torque_offset wheel3_contact_angle wheel3_contact_angle_sigma \
        wheel3_contact_angle_error gear_friction rolling_resistance wheel1_contacts wheel1_sliding wheel1_slip \
        wheel1_needed_friction_sigma wheel1_friction_margin \
        wheel2_contacts wheel2_sliding wheel2_slip \
        wheel2_needed_friction_sigma wheel2_friction_margin \
        wheel3_contacts wheel3_sliding wheel3_slip \
        wheel3_needed_friction_sigma wheel3_friction_margin";
    let table = Table::estimate(0, "paper-body");
    assert_eq!(table.name, "estimate-paper-body");
    assert_eq!(names(&table), golden.split_whitespace().collect::<Vec<_>>());
}

/// No name occurs twice, every column has a description, and units are those of the list.
#[test]
fn every_column_has_a_name_and_a_description_of_its_own() {
    let units = ["1", "s", "m", "m/s", "rad", "rad/s", "N", "N m"];
    for table in [Table::truth(), Table::sensors(), Table::estimate(0, "a")] {
        let mut seen = HashSet::new();
        for column in &table.columns {
            assert!(seen.insert(column.name.clone()), "{} twice", column.name);
            assert!(column.description.len() > 3, "{}", column.name);
            assert!(
                units.contains(&column.unit),
                "{}: {}",
                column.name,
                column.unit
            );
        }
    }
}

fn value(table: &Table, name: &str, frame: &Frame<'_>) -> Option<f64> {
    let column = table
        .columns
        .iter()
        .find(|c| c.name == name)
        .expect("a column of that name");
    value_of(column, frame)
}

/// Wheels, pins and axes are not swapped on their way into the table.
#[test]
fn values_come_from_the_field_that_the_name_says() {
    let record = frame_of(1.0);
    let frame = record.frame();
    let truth = Table::truth();
    let pin_s = record.truth.pins[3];
    for (name, expected) in [
        ("wheel2_normal_force", record.truth.wheels[1].normal_force),
        ("link3_vy", record.truth.links[2].velocity.y),
        ("pin_s_force_x", pin_s.force.x),
        ("pin_s_y", pin_s.position.y),
    ] {
        assert_eq!(value(&truth, name, &frame), Some(expected), "{name}");
    }
    assert_eq!(value(&truth, "wheel3_contacts", &frame), Some(1.0));
    let estimate = good_estimate(&record.truth, 2.0);
    assert_eq!(
        value(&Table::estimate(0, "a"), "wheel3_needed_friction", &frame),
        Some(estimate.traction[2] / estimate.normal_force[2])
    );
}

/// The second contact has columns of its own, empty without it. The equivalent contact has the
/// force of both.
#[test]
fn both_contacts_of_a_wheel_have_columns() {
    let table = Table::truth();
    let mut record = frame_of(1.0);
    let get = |record: &Record, name: &str| value(&table, name, &record.frame());
    let one = record.truth.wheels[1].contact_list[0];
    assert_eq!(get(&record, "wheel2_contact1_x"), Some(one.point.x));
    assert_eq!(get(&record, "wheel2_contact2_x"), None);
    assert_eq!(get(&record, "wheel2_sliding"), Some(0.0));
    let n = record.truth.wheels[1].normal_force;
    assert_eq!(get(&record, "wheel2_equivalent_normal_force"), Some(n));

    // A riser ahead: its normal points backward, its tangent up.
    let wheel = &mut record.truth.wheels[1];
    wheel.contact_list.push(ContactTruth {
        point: Vec2::new(0.7, 0.02),
        normal: Vec2::new(-1.0, 0.0),
        normal_force: 12.0,
        traction: 3.0,
        penetration: 2e-4,
        slip_speed: -0.03,
        slides: true,
    });
    wheel.contacts = 2;
    wheel.traction = 4.0;
    wheel.force = Vec2::new(-3.0, 4.0);
    wheel.slides = true;
    for (part, expected) in [
        ("x", 0.7),
        ("y", 0.02),
        ("angle", std::f64::consts::FRAC_PI_2),
        ("normal_force", 12.0),
        ("traction", 3.0),
        ("penetration", 2e-4),
        ("slip_speed", -0.03),
    ] {
        let name = format!("wheel2_contact2_{part}");
        assert_eq!(get(&record, &name), Some(expected), "{name}");
    }
    assert_eq!(get(&record, "wheel2_sliding"), Some(1.0));
    // Closed form: |F| = 5 N and T = 4 N leave 3 N.
    assert_eq!(get(&record, "wheel2_equivalent_normal_force"), Some(3.0));
    record.truth.wheels[1].traction = 5.5;
    assert_eq!(get(&record, "wheel2_equivalent_contact_angle"), None);
}

/// Contact states are small integers; an estimator that states none has no value.
#[test]
fn contact_states_are_small_integers() {
    let table = Table::estimate(0, "a");
    let mut record = frame_of(1.0);
    let of = |record: &Record| {
        [
            "wheel1_contacts",
            "wheel2_contacts",
            "wheel3_contacts",
            "wheel3_sliding",
        ]
        .map(|name| value(&table, name, &record.frame()))
    };
    assert_eq!(of(&record), [None; 4]);
    let state = |state, sliding| ContactEstimate {
        state,
        sliding,
        slip: 0.0,
    };
    if let Some(Ok(estimate)) = record.estimates.first_mut() {
        estimate.kalman = Some(KalmanReport {
            contact: [
                state(ContactState::InAir, false),
                state(ContactState::OneContact, false),
                state(ContactState::TwoContacts, true),
            ],
            ..KalmanReport::default()
        });
    }
    assert_eq!(of(&record), [0.0, 1.0, 2.0, 1.0].map(Some));
}

/// An estimate that failed leaves gaps, but its row keeps the time.
#[test]
fn a_failed_estimate_is_nothing_not_a_number() {
    let record = failed_frame(1.0);
    let frame = record.frame();
    let table = Table::estimate(0, "a");
    assert_eq!(value_of(&table.columns[0], &frame), Some(1.0));
    for column in &table.columns[1..] {
        assert_eq!(value_of(column, &frame), None, "{}", column.name);
    }
}

/// A lost reading is a gap in its own column alone.
#[test]
fn a_lost_reading_is_nothing_not_a_number() {
    let mut record = frame_of(1.0);
    record.sensors.motor_torque[1] = None;
    let frame = record.frame();
    let table = Table::sensors();
    assert_eq!(value(&table, "time", &frame), Some(1.0));
    for column in &table.columns[1..] {
        let lost = value_of(column, &frame).is_none();
        assert_eq!(
            lost,
            column.name == "wheel2_motor_torque",
            "{}",
            column.name
        );
    }
}

/// T/N has no meaning without a load.
#[test]
fn a_wheel_without_load_has_no_needed_friction() {
    for load in [0.9, 0.0, -1.0] {
        let mut record = frame_of(1.0);
        if let Some(Ok(estimate)) = record.estimates.first_mut() {
            estimate.normal_force[0] = load;
        }
        assert_eq!(
            value(
                &Table::estimate(0, "a"),
                "wheel1_needed_friction",
                &record.frame()
            ),
            None
        );
    }
}

/// The needed friction that an estimator states is that of the column, in place of T/N of its
/// forces.
#[test]
fn a_stated_needed_friction_counts() {
    let mut record = frame_of(1.0);
    let wheel = WheelFriction {
        needed: Some(NeededFriction {
            value: 0.3,
            sigma: 0.02,
        }),
        ..WheelFriction::default()
    };
    if let Some(Ok(estimate)) = record.estimates.first_mut() {
        estimate.kalman = Some(KalmanReport {
            friction: [wheel; 3],
            ..KalmanReport::default()
        });
    }
    let table = Table::estimate(0, "a");
    for (column, expected) in [("", 0.3), ("_sigma", 0.02)] {
        let name = format!("wheel2_needed_friction{column}");
        let found = value(&table, &name, &record.frame());
        assert_eq!(found, Some(expected));
    }
}
