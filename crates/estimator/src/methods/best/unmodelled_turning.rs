//! Loads of a linkage that turns faster than its filters follow, as on facets and corners.

use super::BestFilters;
use crate::nominal::Nominal;
use crate::statics::{Equations, Equilibrium, Forces, Sensitivity, input};

impl BestFilters {
    /// Adds what unmodelled angular accelerations of the links cost to the covariance of N:
    /// [`crate::filters::LinkAngleKalman::unmodelled_acceleration`]. Nothing on ground that the
    /// filters follow.
    ///
    /// A wheel that is thrown up turns its link, and Q moves with it unless another wheel holds the
    /// link there: no sensor shows how much. So beside the inertia of the turning linkage counts an
    /// acceleration of Q in any direction, by the longest arm from Q to an axle of that link.
    pub(super) fn consider_unmodelled_turning(
        &self,
        nominal: &Nominal,
        equations: &Equations,
        sensitivity: &Sensitivity,
        forces: &mut Forces,
    ) {
        if !self.method.inertia {
            return;
        }
        let (arms, carriers) = (&equations.arms, &nominal.robot.geometry.carriers);
        let lever = nominal.settings.moment_lever;
        let [link1, link2] = &self.links;
        let [a1, a2] = [link1.acceleration(), link2.acceleration()];
        let [s1, s2] = [
            link1.unmodelled_acceleration(),
            link2.unmodelled_acceleration(),
        ];
        for (link, sigma, accelerations) in [(0, s1, [a1 + s1, a2]), (1, s2, [a1, a2 + s2])] {
            if !(sigma > 0.0) {
                continue;
            }
            let loads = self.loads(nominal, arms, accelerations);
            let (displaced, _) = Equilibrium::load_side(arms, carriers, &loads, lever);
            forces.consider(&equations.inverse, &(displaced - equations.equilibrium.f));
            let mut arm = 0.0_f64;
            for (axle, carrier) in arms.axles.iter().zip(carriers) {
                if carrier.index() == link {
                    arm = arm.max(robhaz_model::sqrt(axle.norm_squared()));
                }
            }
            for by_acceleration in &sensitivity.columns[input::ACCELERATION..input::CONTACT_ANGLE] {
                forces.consider(&equations.inverse, &(by_acceleration * (arm * sigma)));
            }
        }
    }
}
