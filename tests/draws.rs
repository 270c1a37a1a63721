//! Random robots and grounds for tests.

use proptest::prelude::*;
use robhaz_model::{Geometry, MassSet, Vec2};
use robhaz_terrain::{
    Bump, CosBump, Course, Ditch, Heights, Interpolation, Profile, Ramp, Rough, RoughClass,
    RoughSettings, Sine, Stairs,
};
use std::ops::Range;

/// Level ground on either side of the start, m.
const LEVEL: f64 = 0.55;

/// Robots A and B with every point moved by up to 20 mm, wheels of another size, and masses and
/// inertias times a factor from `scale`.
pub fn robots(scale: Range<f64>) -> impl Strategy<Value = (Geometry, MassSet)> {
    let moved = proptest::collection::vec(-0.02..0.02_f64, 19);
    let scaled = proptest::collection::vec(scale, 10);
    let robot = (any::<bool>(), 0.07..0.13_f64, moved, scaled);
    robot.prop_map(|(a, radius, moved, scaled)| {
        let mut g = if a { Geometry::a() } else { Geometry::b() };
        g.wheel_radius = radius;
        let mut moved = moved.into_iter();
        let mut next = || moved.next().unwrap_or_default();
        for axle in &mut g.axles {
            // All wheels stand on the level ground.
            *axle = Vec2::new(axle.x + next(), radius);
        }
        let pins = [&mut g.pins.p, &mut g.pins.q, &mut g.pins.r, &mut g.pins.s];
        for point in g.link_cg.iter_mut().chain(pins).chain([&mut g.body_cg]) {
            *point += Vec2::new(next(), next());
        }
        let mut m = MassSet::caption();
        let [l1, l2, l3] = &mut m.links;
        let [i1, i2, i3] = &mut m.link_inertias;
        let masses = [&mut m.body, l1, l2, l3, &mut m.wheel];
        let inertias = [&mut m.body_inertia, i1, i2, i3, &mut m.wheel_inertia];
        for (value, by) in masses.into_iter().chain(inertias).zip(scaled) {
            *value *= by;
        }
        (g, m)
    })
}

/// Grounds of every kind, in front of the robot or behind it, within the ranges that a scene allows
/// but no larger than the robot. `size` multiplies heights, depths and slopes: at 1 most grounds
/// can be passed, at 4 kerbs are up to 0.24 m high.
pub fn grounds(size: f64) -> impl Strategy<Value = Profile> {
    let height = -0.06 * size..0.06 * size;
    let start = LEVEL..1.0_f64;
    let bump =
        (height.clone(), 0.1..0.4_f64, 0.0..2.0_f64).prop_map(|(height, width, more)| Bump {
            height,
            // exp(-12), 0.3 um, is left of it at the start.
            centre: LEVEL + 3.5 * width + more,
            width,
        });
    let steps = proptest::collection::vec((0.01..0.2_f64, -0.02 * size..0.02 * size), 2..12);
    let heights = (start.clone(), steps, 0..2_usize).prop_map(|(start, steps, way)| {
        let mut at = Vec2::new(start, 0.0);
        let mut points = vec![at, at + Vec2::new(0.05, 0.0)];
        at.x += 0.05;
        for (dx, dy) in steps {
            at += Vec2::new(dx, dy);
            points.push(at);
        }
        Profile::Heights(Heights::new(
            points,
            [Interpolation::Spline, Interpolation::Corners][way],
        ))
    });
    let class_seed = (0..8_usize, 0..1000_u64, start.clone());
    let one = prop_oneof![
        Just(Profile::Flat),
        proptest::collection::vec(bump, 1..5).prop_map(Profile::Bumps),
        (height.clone(), 0.1..0.5_f64, 0.0..1.0_f64).prop_map(|(height, half_width, more)| {
            Profile::CosBump(CosBump {
                height,
                centre: LEVEL + half_width + more,
                half_width,
            })
        }),
        (
            -0.45 * size.min(2.5)..0.45 * size.min(2.5),
            start.clone(),
            0.1..2.0_f64
        )
            .prop_map(|(angle, start, length)| {
                Profile::Ramp(Ramp {
                    angle,
                    start,
                    length,
                })
            }),
        (height.clone(), 0.1..0.4_f64, 1..4_u32, start.clone()).prop_map(
            |(rise, run, count, start)| {
                Profile::Stairs(Stairs {
                    // 0 is no step.
                    rise: rise + 0.001_f64.copysign(rise),
                    run,
                    count,
                    start,
                })
            }
        ),
        (height, 0.2..1.0_f64, 1..5_u32, start.clone()).prop_map(
            |(amplitude, wavelength, periods, start)| {
                Profile::Sine(Sine {
                    amplitude: 0.4 * amplitude,
                    wavelength,
                    start,
                    periods,
                })
            }
        ),
        (0.01..0.2 * size, 0.02..0.3_f64, start).prop_map(|(depth, width, start)| {
            Profile::Ditch(Ditch {
                depth,
                width,
                start,
            })
        }),
        class_seed.prop_map(|(class, seed, start)| {
            Profile::Rough(Rough::new(RoughSettings {
                class: RoughClass::ALL[class],
                shortest: 0.2,
                longest: 5.0,
                start,
                extent: 3.0,
                fade: 0.5,
                seed,
            }))
        }),
        heights,
    ];
    let behind_it_waves = |one: Profile| {
        let waves = Profile::Sine(Sine {
            amplitude: 0.008,
            wavelength: 0.4,
            start: -LEVEL - 1.2,
            periods: 3,
        });
        match one {
            Profile::Flat => waves,
            one => Profile::Course(Course::new(vec![waves, one])),
        }
    };
    prop_oneof![one.clone(), one.prop_map(behind_it_waves)]
}
