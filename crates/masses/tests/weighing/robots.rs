//! Robots that differ from their nominal values, their weighing, and the error of their forces.

use robhaz_masses::{
    Accuracy, Plan, Tolerances, WeighError, Weighed, plan, plate_forces, simulate, weigh,
};
use robhaz_model::{Robot, Vec2};
use std::error::Error;

/// Draws from N(0, 1): a linear congruential generator (Knuth's MMIX) and the sum of twelve uniform
/// numbers, which differs from a Gaussian beyond three standard deviations only.
pub struct Random(pub u64);

impl Random {
    pub fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(self.0 >> 32).unwrap_or(0)) / 4_294_967_296.0
    }

    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// A robot that differs from its nominal values as `[model_error]` draws it: centre of mass by 10
/// mm, link masses by 10 %, pins by 2 mm; also the masses of body and wheels by `others` and the
/// links' centres of mass by `centres`, m.
pub fn real_robot(nominal: &Robot, random: &mut Random, others: f64, centres: f64) -> Robot {
    let mut robot = nominal.clone();
    let mut moved = |at: Vec2, by: f64| {
        let (sin, cos) = (std::f64::consts::TAU * random.uniform()).sin_cos();
        at + Vec2::new(cos, sin) * by
    };
    let geometry = &mut robot.geometry;
    geometry.body_cg = moved(geometry.body_cg, 0.010);
    let pins = &mut geometry.pins;
    for pin in [&mut pins.p, &mut pins.q, &mut pins.r, &mut pins.s] {
        *pin = moved(*pin, 0.002);
    }
    for cg in &mut geometry.link_cg {
        *cg = moved(*cg, centres);
    }
    for mass in &mut robot.mass.links {
        *mass *= 1.0 + 0.1 * random.normal();
    }
    robot.mass.body *= 1.0 + others * random.normal();
    robot.mass.wheel *= 1.0 + others * random.normal();
    robot
}

/// Heights of blocks as everybody has them, m.
pub const HEIGHTS: [f64; 3] = [0.05, 0.10, 0.15];

/// The plan of six postures.
pub fn plan_of(nominal: &Robot) -> Result<Plan, WeighError> {
    let (tolerances, accuracy) = (&Tolerances::NOMINAL, &Accuracy::TYPICAL);
    plan(nominal, tolerances, accuracy, &HEIGHTS, 6)
}

/// Weighs a robot in the six most informative postures by its nominal values.
pub fn weighed(
    nominal: &Robot,
    robot: &Robot,
    random: &mut Random,
) -> Result<Weighed, Box<dyn Error>> {
    let (tolerances, accuracy) = (Tolerances::NOMINAL, Accuracy::TYPICAL);
    let plan = plan_of(nominal)?;
    let blocks: Vec<_> = plan.postures.iter().map(|p| p.blocks).collect();
    let measurements = simulate(robot, &blocks, &accuracy, || random.normal())?;
    Ok(weigh(nominal, &measurements, &tolerances, &accuracy)?)
}

/// Postures that are none of those on the scales, rad.
pub const POSTURES: [[f64; 2]; 5] = [
    [0.0, 0.0],
    [0.12, -0.08],
    [-0.15, 0.05],
    [0.05, 0.17],
    [-0.1, -0.18],
];

/// Squared error of the forces in these postures, N^2, mean over wheels and postures, and that of
/// the nominal values.
pub fn squared_errors(
    real: &Robot,
    nominal: &Robot,
    weighed: &Robot,
) -> Result<[f64; 2], Box<dyn Error>> {
    let mut sums = [0.0; 2];
    for angles in POSTURES {
        let truth = plate_forces(real, angles, [0.0; 3])?;
        for (sum, robot) in sums.iter_mut().zip([nominal, weighed]) {
            let found = plate_forces(robot, angles, [0.0; 3])?;
            for (a, b) in found.iter().zip(truth) {
                *sum += (a - b) * (a - b) / 15.0;
            }
        }
    }
    Ok(sums)
}
