//! A program without the standard library whose panic handler calls a function that does not exist:
//! it links only if the optimiser has proven that neither update nor save nor restore of the
//! estimator can panic, nor an update of the control, nor an update of both sides of a rover. It prints
//! the stack that an update uses.
#![no_std]
#![no_main]

use core::hint::black_box;
use robhaz_control::{ControlInput, ControlKind, ControlSettings, Controller, FrictionTestPlan};
use robhaz_estimator::whole::{WholeEstimator, WholeFrame};
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
        rate: Some(0.0), rate_error: 0.0 };
    black_box(SensorFrame {
        time,
        wheel_angle: [Some(2.0 * time); 3],
        motor_torque: [Some(0.3); 3],
        link1: link,
        link2: link,
        contact_angle: [Some(0.0); 3],
        ..SensorFrame::default()
    })
}

#[inline(never)]
fn update(estimator: &mut Estimator, k: u32) {
    let _ = black_box(estimator.update(&frame(k)));
}

/// A few samples with a control of any kind: it gets every third estimate only.
#[inline(never)]
fn control(kind: ControlKind, robot: &Robot) {
    let Ok(mut controller) = Controller::new(&black_box(ControlSettings {
        kind,
        robot: robot.clone(),
        viscous_damping: 0.15,
        kp: 5.0,
        ki: 50.0,
        torque_limit: 10.0,
        tracking_time: 0.1,
        friction_test: FrictionTestPlan::default(),
    })) else {
        return;
    };
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

#[inline(never)]
fn update_whole(estimator: &mut WholeEstimator, k: u32) {
    let time = 1e-3 * f64::from(k);
    let frame = black_box(WholeFrame {
        time,
        wheel_angle: [Some(2.0 * time); 6],
        motor_torque: [Some(0.3); 6],
        steering: [Some(0.1); 6],
        pins: [Some(0.05); 2],
        coupling: Some(0.02),
        inclination: Some(0.01),
        roll: Some(0.1),
        rates: [Some(0.01); 3],
    });
    let found = black_box(estimator.update(&frame));
    let _ = black_box(found.map(|found| (found.sigma_normal(7), found.needed_friction(7), found)));
}

/// A rover of both sides. Returns the stack of an update, bytes.
#[inline(never)]
fn whole(coupling: Coupling) -> usize {
    let mut side = Robot::default_a();
    side.geometry.make_bogie(Carrier::Link2);
    let rover = black_box(WholeRover {
        side,
        coupling,
        pivot: Vec2::new(0.0, 0.3),
        half_tracks: [0.3; 3],
        link_places: [0.3; 2],
        body_place: 0.0,
        coupling_stop: WholeRover::NO_STOP,
        body_inertia: [0.1; 2],
        link_inertias: [[0.01; 2]; 2],
        wheel_inertia: 0.01,
    });
    let settings = black_box(EstimatorSettings::kalman());
    let Ok(mut estimator) = WholeEstimator::new(&rover, settings, black_box([1e-3; 2])) else {
        return 0;
    };
    for k in 0..10 {
        update_whole(&mut estimator, k);
    }
    stack(false);
    update_whole(&mut estimator, 10);
    stack(true)
}

/// Prints what an update needs, bytes.
fn print(name: &core::ffi::CStr, stack: usize, state: usize) {
    unsafe {
        printf(
            c"%s: %zu bytes of stack an update, %zu of state\n".as_ptr(),
            name.as_ptr(),
            stack,
            state,
        );
    }
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
        print(name, used, size_of::<Estimator>());
    }
    for kind in ControlKind::ALL {
        control(black_box(kind), &black_box(Robot::default_a()));
    }
    let used = whole(black_box(Coupling::Differential));
    print(c"both sides", used, size_of::<WholeEstimator>());
    0
}
