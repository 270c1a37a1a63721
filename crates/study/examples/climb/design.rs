//! What is searched: the positions that make a geometry, their bounds, and the constraints of the linkage.

use crate::Outcome;
use crate::search::Plan;
use robhaz_model::{
    Geometry, MassSet, Outline, Pin, PinStop, Pins, Posture, Robot, Vec2, cross, mean_link_cgs,
};
use std::fmt::Write as _;

/// Name and bounds of each searched position, m. The wheels' radius, the masses and the end stops are those of geometry A.
///
/// Spacings: wheels are at least 20 mm apart, wheelbases up to 0.84 m. Pins: within the robot, at least 40 mm above the ground. The
/// body's centre of mass is not lower than that of geometry A: the body's box is above the wheels there.
pub const VARIABLES: [(&str, f64, f64); 12] = [
    ("front axle ahead of the middle one", 0.22, 0.42),
    ("rear axle behind the middle one", 0.22, 0.42),
    ("P, x", -0.05, 0.40),
    ("P, y", 0.10, 0.35),
    ("Q, x", -0.20, 0.25),
    ("Q, y", 0.04, 0.25),
    ("R, x", -0.42, 0.05),
    ("R, y", 0.08, 0.30),
    ("S, x", -0.42, 0.15),
    ("S, y", 0.15, 0.40),
    ("body's centre of mass, x", -0.15, 0.15),
    ("body's centre of mass, y", 0.30, 0.36),
];

/// Largest difference of the static loads of the wheels over their mean.
const LOAD_SPREAD: f64 = 0.15;
/// Height that the front wheel can be lifted inside the stops while the others stand on level ground, m.
const REACH: f64 = 0.18;
/// Least distance of two neighbouring pins, m: twice the width of a bar.
const SHORTEST_BAR: f64 = 0.06;
/// Least sine of the angle between body and link 3 at pin S: beyond it their forces grow without bound.
const LEAST_SINE: f64 = 0.26;
/// Steps of the angle of pin Q over which loop and angle are checked.
const STEPS: u32 = 15;

/// The geometry of a point of the search, on whole millimetres. Carriers, wheels and end stops are those of geometry A.
pub fn geometry(x: &[f64]) -> Geometry {
    let at = |i: usize| (1e3 * x.get(i).copied().unwrap_or(f64::NAN)).round() / 1e3;
    let point = |i: usize| Vec2::new(at(i), at(i + 1));
    let a = Geometry::a();
    let axles = [at(0), 0.0, -at(1)].map(|x| Vec2::new(x, a.wheel_radius));
    let pins = Pins {
        p: point(2),
        q: point(4),
        r: point(6),
        s: point(8),
    };
    let body_cg = point(10);
    Geometry {
        link_cg: mean_link_cgs(&axles, &a.carriers, &pins),
        outline: Outline::derived(&axles, body_cg),
        axles,
        pins,
        body_cg,
        ..a
    }
}

/// The robot of a geometry, with the masses of the captions.
pub fn robot(geometry: Geometry) -> Robot {
    Robot {
        geometry,
        mass: MassSet::caption(),
    }
}

/// How far a geometry is from meeting all constraints; 0 where it meets them. Without a unit: it only leads the search.
pub fn violation(geometry: &Geometry) -> f64 {
    let robot = robot(geometry.clone());
    let mut sum = 0.0;
    if geometry.check().is_err() {
        sum += 10.0;
    }
    match load_spread(&robot) {
        Some(spread) => sum += (spread - LOAD_SPREAD).clamp(0.0, 5.0),
        None => sum += 10.0,
    }
    if robot.check_stance().is_err() {
        sum += 1.0;
    }
    let Pins { p, q, r, s } = geometry.pins;
    for bar in [p - q, q - r, r - s, s - p] {
        sum += 10.0 * (SHORTEST_BAR - bar.norm()).max(0.0);
    }
    sum += 10.0 * (REACH - reach(geometry)).max(0.0);
    for angle in openings(geometry) {
        let sine = Posture::close(geometry, angle, 0.0).map_or(-1.0, |posture| {
            let [p, r, s] = [Pin::P, Pin::R, Pin::S].map(|pin| posture.pin_from_q(geometry, pin));
            let (body, link3) = (s - p, s - r);
            cross(body, link3).abs() / (body.norm() * link3.norm())
        });
        sum += (LEAST_SINE - sine).max(0.0);
    }
    sum
}

/// Difference of the largest and the least static load over their mean, -; `None` where they are not determined.
pub fn load_spread(robot: &Robot) -> Option<f64> {
    let loads = robot.static_loads()?;
    let most = loads.iter().fold(f64::NEG_INFINITY, |m, n| m.max(*n));
    let least = loads.iter().fold(f64::INFINITY, |m, n| m.min(*n));
    Some((most - least) / robot.mean_wheel_load())
}

/// Angles of pin Q from one end stop to the other, rad.
fn openings(geometry: &Geometry) -> impl Iterator<Item = f64> + use<> {
    let PinStop { lower, upper, .. } = geometry.stop;
    (0..=STEPS).map(move |k| lower + (upper - lower) * f64::from(k) / f64::from(STEPS))
}

/// Height by which the front wheel can be lifted inside the stops while the others stand on level ground, m.
pub fn reach(geometry: &Geometry) -> f64 {
    let lift = |angle: f64| {
        let posture = Posture::close(geometry, angle, 0.0).ok()?;
        let height = |wheel| posture.axle_from_q(geometry, wheel).y;
        Some(height(0) - height(1))
    };
    openings(geometry).filter_map(lift).fold(0.0, f64::max)
}

/// A geometry file with its origin.
pub fn to_toml(geometry: &Geometry, plan: &Plan) -> Outcome<String> {
    let robot = robot(geometry.clone());
    let loads = robot
        .static_loads()
        .ok_or("the static loads are not determined")?;
    let [front, _, rear] = geometry.axles;
    let Plan {
        seed,
        population,
        generations,
    } = plan;
    let mut text = format!(
        "# Geometry C of ROBHAZ-6WHEEL, one side: a linkage that climbs stairs. Wheel 1 on link1, wheels 2 and 3 on link2.\n\
         #\n\
         # These values are DERIVED, not published: a design search found them (docs/climbing.md), with\n\
         #   cargo run --release -p robhaz-study --example climb -- search --seed {seed} --population {population} \\\n\
         #     --generations {generations} --out robots/geometry-c.toml\n\
         # Wheelbase {:.3} m, static wheel loads on level ground {:.2}, {:.2}, {:.2} N with the mass set `caption`, reach of the\n\
         # front wheel inside the stops {:.2} m.\n\
         #\n\
         # Positions are those of the nominal pose: all wheels on level ground y = 0, middle axle at x = 0; x forward, y up.\n\
         # A number is in SI (m, rad); a string states its unit: \"10 cm\", \"-40 deg\".\n\n",
        front.x - rear.x,
        loads[0],
        loads[1],
        loads[2],
        reach(geometry)
    );
    let pair = |v: Vec2| format!("[{:.3}, {:.3}]", v.x, v.y);
    let axles = geometry.axles.map(pair).join(", ");
    writeln!(text, "wheel_radius = {:.2} # m", geometry.wheel_radius)?;
    writeln!(text, "axles = [{axles}] # front, middle, rear; m")?;
    writeln!(
        text,
        "carriers = [\"link1\", \"link2\", \"link2\"] # the link that carries each wheel"
    )?;
    writeln!(text, "body_cg = {} # m\n", pair(geometry.body_cg))?;
    writeln!(
        text,
        "# Without link_cg, each link's centre of mass is the mean of its own pins and axles.\n"
    )?;
    writeln!(
        text,
        "# The closed loop: body --P-- link1 --Q-- link2 --R-- link3 --S-- body. m\n[pins]"
    )?;
    for pin in Pin::ALL {
        writeln!(text, "{} = {}", pin.name(), pair(geometry.pins.get(pin)))?;
    }
    text += "\n# End stops of pin Q on theta_1 - theta_2, the paper's \"limited pin joint\".\n\
             [stop]\nlower = \"-40 deg\"\nupper = \"35 deg\"\nstiffness = 2000 # N m/rad\ndamping = 20 # N m s/rad\n";
    Ok(text)
}
