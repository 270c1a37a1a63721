//! The paper's equations one after the other, on level ground: eq. (1), its blocks (4) to (7), eq.
//! (8), and least squares; then the same eq. (8) as the estimators write it.
//!
//! `cargo run --release -p robhaz-estimator --example full_system`

use robhaz_estimator::statics::full_system::{BlockForm, FullSystem, ReducedSystem};
use robhaz_estimator::statics::{Arms, Equilibrium, Loads};
use robhaz_model::{Posture, Robot};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = Robot::default_a();
    let (geometry, masses) = (&robot.geometry, robot.mass.true_points());
    let posture = Posture::NOMINAL;
    // The front wheel stands on a slope of 0.1 rad; tractions in N.
    let (contact_angle, traction) = ([0.1, 0.0, 0.0], [4.0, 1.0, 1.0]);

    let full = FullSystem::new(geometry, &masses, &posture, &contact_angle);
    let (rows, columns) = full.g.shape();
    println!("eq. (1): {rows} equations for {columns} forces");

    let block = BlockForm::new(&full);
    let pins = block.pin_forces()?;
    for (i, pin) in ["P", "R", "S"].iter().enumerate() {
        println!(
            "eq. (6): {pin} = ({:.2}, {:.2}) N",
            pins[2 * i],
            pins[2 * i + 1]
        );
    }

    let reduced = ReducedSystem::new(&block, &pins);
    let solution = reduced.normal_forces(&traction)?;
    let [n1, n2, n3] = solution.normal_force;
    println!("eq. (8): N = {n1:.2}, {n2:.2}, {n3:.2} N");
    let [x, y, m1, m2] = solution.residual;
    println!("residual: {x:.2} N, {y:.2} N, {m1:.3} N m, {m2:.3} N m");

    // Moments in N m, as in the paper.
    let lever = 1.0;
    let arms = Arms::new(geometry, posture.links[0], posture.links[1])?;
    let loads = Loads::at_rest(&masses);
    let (carriers, radius) = (&geometry.carriers, geometry.wheel_radius);
    let direct = Equilibrium::new(&arms, carriers, radius, &loads, &contact_angle, lever)
        .ok_or("P lies on the line RS")?;
    let inverse = direct
        .least_squares()
        .ok_or("the contacts leave a normal force undetermined")?;
    let normal = inverse.solve(&direct.right_side(&traction));
    for (i, (n, expected)) in normal.iter().zip(solution.normal_force).enumerate() {
        println!(
            "wheel {}: N differs by {:.0e} N",
            i + 1,
            (n - expected).abs()
        );
    }
    Ok(())
}
