//! The ground below a robot.

use crate::drawn::{lines, svg};
use plotters::style::RED;
use robhaz_record::figures::style::{SURFACE, line};
use robhaz_record::figures::{Axis, Layer, SPACING, Scale, Strip};
use robhaz_terrain::{Profile, Rough, RoughSettings, Terrain};

/// Property: the ground of a short path keeps its points, that of a long one its ends and its
/// highest point.
#[test]
fn the_ground_of_a_long_path_is_reduced() {
    let terrain = Terrain::new(Profile::Rough(Rough::new(RoughSettings {
        seed: 1,
        ..RoughSettings::default()
    })));
    for (to, is_reduced) in [(5.0, false), (40.0, true)] {
        let mut strip = Strip::new(&terrain, &(3.0..to), -1.0..1.0, 1e9);
        let ground = terrain.outline(strip.x.start, strip.x.end, SPACING);
        let highest = ground.iter().map(|p| p.y).fold(f64::MIN, f64::max);
        let (left, right) = (strip.x.start, strip.x.end);
        let level = vec![(left, highest), (right, highest)];
        strip.layers.push(Layer::line(vec![level], line(RED, 1.0)));
        let axis = Axis::of_places("x (m)", left..right);
        let svg = svg(strip.panel(), &axis, Scale::Own);
        let surface = &lines(&svg, SURFACE)[0];
        assert_eq!(
            surface.len() < ground.len(),
            is_reduced,
            "{} {}",
            surface.len(),
            ground.len()
        );
        assert!(surface.len() <= 1202 && surface.is_sorted_by(|a, b| a.0 <= b.0));
        let level = &lines(&svg, RED)[0];
        let peak = surface.iter().map(|p| p.1).min();
        assert_eq!(peak, Some(level[0].1));
        let ends = [surface.first(), surface.last()].map(|end| end.expect("a point").0);
        assert_eq!(ends, [level[0].0, level[1].0]);
    }
}
