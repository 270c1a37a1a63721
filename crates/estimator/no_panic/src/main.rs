//! A program without the standard library whose panic handler calls a function that does not exist:
//! it links only if the optimiser has proven that neither update nor save nor restore of the
//! estimator can panic, nor an update of the control, nor the statics of a whole rover. It prints
//! the stack that an update uses.
#![no_std]
#![no_main]

use core::hint::black_box;
use robhaz_control::{ControlInput, ControlKind, ControlSettings, Controller, FrictionTestPlan};
use robhaz_estimator::whole::{
    InputCovariance, Joints, WholeEquilibrium, WholeMotion, WholePosture,
};
use robhaz_estimator::{Estimator, EstimatorSettings, LinkReading, SensorFrame};
use robhaz_model::{Carrier, Coupling, Robot, Vec2, WholeRover};

#[link(name = "c")]
unsafe extern "C" {
    fn printf(format: *const core::ffi::c_char, ...) -> core::ffi::c_int;
}

unsafe extern "C" {
    /// Defined nowhere: "undefined reference" means that something can panic.
    fn the_estimator_can_panic() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    unsafe { the_estimator_can_panic() }
}

/// Unwinding tables of `core` name it; nothing calls it with `panic = "abort"`.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

const FILLED: usize = 256 * 1024;
const PATTERN: u8 = 0xA5;

/// Fills the stack below the caller with a pattern, or counts the bytes without it: these have been
/// used.
#[inline(never)]
fn stack(count: bool) -> usize {
    let mut area = core::mem::MaybeUninit::<[u8; FILLED]>::uninit();
    let bytes = area.as_mut_ptr().cast::<u8>();
    let (mut untouched, mut gone) = (0, 0);
    // The lowest address is the deepest. Entering this function writes one word a page (stack
    // probes); an update overwrites longer stretches.
    for i in 0..FILLED {
        // Volatile, so that neither is optimised away; the read is of old contents on purpose.
        unsafe {
            if !count {
                bytes.add(i).write_volatile(PATTERN);
            } else if bytes.add(i).read_volatile() == PATTERN {
                (untouched, gone) = (i + 1, 0);
            } else if gone < 16 {
                gone += 1;
            } else {
                break;
            }
        }
    }
    FILLED - untouched
}

fn frame(k: u32) -> SensorFrame {
    let time = 1e-3 * f64::from(k);
    let link = LinkReading {
        inclination: Some(0.01),
        rate: Some(0.0),
    };
    black_box(SensorFrame {
        time,
        wheel_angle: [Some(2.0 * time); 3],
        motor_torque: [Some(0.3); 3],
        link1: link,
        link2: link,
        contact_angle: [Some(0.0); 3],
    })
}

#[inline(never)]
fn update(estimator: &mut Estimator, k: u32) {
    let _ = black_box(estimator.update(&frame(k)));
}

/// A few samples with a control of any kind: it gets every third estimate only.
#[inline(never)]
fn control(kind: ControlKind, robot: &Robot) {
    let mut controller = Controller::new(&black_box(ControlSettings {
        kind,
        robot: robot.clone(),
        viscous_damping: 0.15,
        kp: 5.0,
        ki: 50.0,
        torque_limit: 10.0,
        tracking_time: 0.1,
        friction_test: FrictionTestPlan::default(),
    }));
    let mut estimator = Estimator::new(robot, black_box(EstimatorSettings::kalman()));
    for k in 0..10 {
        let frame = frame(k);
        let estimate = estimator.update(&frame).ok().filter(|_| k % 3 == 0);
        let commands = controller.update(&ControlInput {
            frame: &frame,
            estimate: black_box(estimate.as_ref()),
            set_speed: black_box(2.0),
        });
        let _ = black_box((commands, controller.friction_tests()));
    }
}

/// The forces of a rover of both sides, once.
#[inline(never)]
fn whole(coupling: Coupling) {
    let mut side = Robot::default_a();
    side.geometry.make_bogie(Carrier::Link2);
    let rover = black_box(WholeRover {
        side,
        coupling,
        pivot: Vec2::new(0.0, 0.3),
        half_tracks: [0.3; 3],
        link_places: [0.3; 2],
        body_place: 0.0,
        body_inertia: [0.1; 2],
        link_inertias: [[0.01; 2]; 2],
        wheel_inertia: 0.01,
    });
    let motion = black_box(WholeMotion::at_rest(9.81, 0.1, 0.1));
    let Ok(posture) = WholePosture::new(&rover, &black_box(Joints::default())) else {
        return;
    };
    let equilibrium = WholeEquilibrium::new(&rover, &posture, &motion, &black_box([0.1; 6]));
    let forces = equilibrium.and_then(|e| {
        e.solve(
            &black_box([0.1; 6]),
            &black_box(InputCovariance::identity()),
        )
    });
    let _ = black_box(forces.map(|found| (found, found.sigma_normal(black_box(7)))));
}

#[unsafe(no_mangle)]
extern "C" fn main() -> core::ffi::c_int {
    for (name, settings) in [
        (c"paper-wheels", EstimatorSettings::paper_wheels()),
        (c"kalman", EstimatorSettings::kalman()),
    ] {
        // The optimiser must not know robot and settings.
        let mut estimator = Estimator::new(&black_box(Robot::default_a()), black_box(settings));
        for k in 0..10 {
            update(&mut estimator, k);
        }
        stack(false);
        update(&mut estimator, 10);
        let used = stack(true);
        unsafe {
            printf(
                c"%s: %zu bytes of stack an update, %zu of state\n".as_ptr(),
                name.as_ptr(),
                used,
                size_of::<Estimator>(),
            );
        }
    }
    for kind in ControlKind::ALL {
        control(black_box(kind), &black_box(Robot::default_a()));
    }
    whole(black_box(Coupling::Differential));
    0
}
