//! Torques that are read before gears which lose a part of them.

use crate::check::judgement::{AGREE, BETTER, Judgement};
use crate::check::wiring::Wiring;
use crate::check::{Finding, Stated};
use robhaz_estimator::SensorFrame;

const TEST: &str = "efficiency of the gears";
/// Efficiencies that are tried.
const EFFICIENCIES: [f64; 5] = [1.0, 0.9, 0.8, 0.7, 0.6];

/// With another efficiency of the gears than that stated the readings agree, and fit far better.
pub fn finding(part: &[SensorFrame], stated: &Stated<'_>) -> Option<Finding> {
    let of = |efficiency: f64| {
        let mut stated = *stated;
        stated.settings.gear_efficiency = efficiency;
        let found = Judgement::of(part, &stated, &Wiring::OF_LOG);
        (efficiency, found.nis - found.of_encoders)
    };
    let (own, as_stated) = of(stated.settings.gear_efficiency);
    if as_stated <= AGREE {
        return None;
    }
    let is_other = |efficiency: &f64| (efficiency - own).abs() > f64::EPSILON;
    let tried = EFFICIENCIES.into_iter().filter(is_other).map(of);
    let (best, least) = tried.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (least < BETTER * as_stated && least < AGREE).then(|| {
        let figure = format!(
            "driving and braking torques fit gears of an efficiency of {best:.1}; stated is {own:.2} (contradiction {least:.1} in place of {as_stated:.1})"
        );
        let remedy = format!("state drive.gear_efficiency = {best:.1}, for torques before the gears: currents times torque_constant and gear_ratio");
        Finding::ok(TEST, "torques 1 to 3", figure)
            .with("efficiency", best, "-")
            .fault(remedy)
    })
}
