//! Random paths: ramps, kerbs, waves, rough ground, level and on slopes, with a friction
//! coefficient of 0.2 to 0.9.

use robhaz_model::Units;
use robhaz_path::DriveKind;
use robhaz_scene::Scene;
use robhaz_sim::random::Stream;
use std::fmt::Write as _;
use std::path::Path;

/// Kind of ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An incline up or down, level behind it.
    Ramp,
    /// One kerb up, of 10 to 110 mm.
    Kerb,
    /// Waves of 0.25 to 1 m.
    Waves,
    /// Random ground of the classes B to F of ISO 8608.
    Rough,
    /// A kerb on an incline.
    SlopedKerb,
    /// Waves on an incline.
    SlopedWaves,
    /// Random ground on an incline.
    SlopedRough,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 7] = [
        Self::Ramp,
        Self::Kerb,
        Self::Waves,
        Self::Rough,
        Self::SlopedKerb,
        Self::SlopedWaves,
        Self::SlopedRough,
    ];

    /// Its name in the table.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ramp => "ramps",
            Self::Kerb => "kerbs",
            Self::Waves => "waves",
            Self::Rough => "rough ground",
            Self::SlopedKerb => "kerbs on slopes",
            Self::SlopedWaves => "waves on slopes",
            Self::SlopedRough => "rough ground on slopes",
        }
    }
}

/// A random path.
pub struct RandomPath {
    /// Kind of its ground.
    pub kind: Kind,
    /// What was drawn, in words.
    pub words: String,
    /// The scene with the drive.
    pub scene: Scene,
}

/// x at which the profiles start, m, and where the ground on an incline does.
const START: f64 = 0.7;
const ON_SLOPE: f64 = 1.6;
/// Spacing of the points of a ground on an incline, m.
const SPACING: f64 = 0.005;

/// The path of a number in a series of random paths: the same for the same two numbers. A robot,
/// robot A or a rover of `robots/`, drives it by `drive`, which must be a control of a scene.
/// Lengths, speed and sensors are those of robot A in the units of the rover.
pub fn random_path(
    series: u64,
    number: u64,
    drive: DriveKind,
    rover: Option<&str>,
) -> Result<RandomPath, Box<dyn std::error::Error + Send + Sync>> {
    let text = match rover {
        Some(name) => {
            let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots");
            std::fs::read_to_string(Path::new(folder).join(name).with_extension("toml"))?
        }
        None => String::new(),
    };
    let base = Scene::parse(&text, "robot", Path::new(""), &[]).map_err(|e| format!("{e:?}"))?;
    let units = Units::of(&base.robot.robot);
    let mut draw = Draw(Stream::new(series, &format!("path {number}")));
    let mut kinds = Kind::ALL.into_iter().cycle();
    let kind = kinds
        .nth(usize::try_from(number)?)
        .ok_or("no kind of ground")?;
    let mu = draw.within(0.2, 0.9);
    let (terrain, words) = ground(kind, &mut draw, number, units.length)?;
    let words = format!("{words}, mu {mu:.3}");
    let mut keys = vec![
        terrain,
        format!("contact.mu_s={mu}"),
        format!("contact.mu_d={}", 0.875 * mu),
        "engine.kind=direct".to_owned(),
        "sensors={grade=\"typical\"}".to_owned(),
        format!("drive.kind={}", drive.name()),
        format!("record.duration={}", (120.0 * units.time).ceil()),
        format!("seed={number}"),
    ];
    if rover.is_some() {
        let torque = 0.1 * units.torque();
        let rate = base.sensors.rate.max(1000.0);
        keys.extend([
            format!("sensors.rate={rate}"),
            format!("drive.speed={}", 0.2 * units.speed()),
            format!("sensors.torque_offset={torque}"),
            format!("sensors.torque_noise={torque}"),
            "record.rate=100".to_owned(),
            "estimator=[{name=\"kalman\", contact_angles=\"none\", label=\"kalman-no-angles\"}]"
                .to_owned(),
        ]);
    }
    let scene = Scene::parse(&text, "random path", Path::new(""), &keys)
        .map_err(|e| format!("{words}: {e:?}\n{keys:?}"))?;
    Ok(RandomPath { kind, words, scene })
}

struct Draw(Stream);

impl Draw {
    fn within(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.0.uniform()
    }
}

/// The terrain of a scene as an override, and its words; lengths times `size`.
fn ground(kind: Kind, draw: &mut Draw, number: u64, size: f64) -> Result<(String, String), String> {
    let start = size * START;
    Ok(match kind {
        Kind::Ramp => {
            let angle = draw.within(-40.0, 40.0);
            let length = size * draw.within(0.8, 1.6);
            let keys = format!(
                "kind = \"ramp\"\nangle = \"{angle} deg\"\nlength = {length}\nstart = {start}"
            );
            (table(&keys), format!("ramp {angle:.1} deg, {length:.2} m"))
        }
        Kind::Kerb => {
            let kerb = size * draw.within(10.0, 110.0);
            let keys = format!("kind = \"step\"\nkerb = \"{kerb} mm\"\nstart = {start}");
            (table(&keys), format!("kerb {kerb:.1} mm"))
        }
        Kind::Waves => {
            let (amplitude, wavelength, periods) = waves(draw, size);
            let keys = format!(
                "kind = \"sine\"\namplitude = {amplitude}\nwavelength = {wavelength}\nperiods = {periods}\nstart = {start}"
            );
            let words = format!("waves +-{:.1} mm of {wavelength:.2} m", 1e3 * amplitude);
            (table(&keys), words)
        }
        Kind::Rough => {
            let (keys, words) = rough(draw, number, size);
            (table(&keys), words)
        }
        Kind::SlopedKerb => {
            let (slope, angle) = slope(draw);
            let kerb = size * 1e-3 * draw.within(10.0, 90.0);
            let mut points = vec![[-size, 0.0], [start, 0.0]];
            let (foot, rise) = (size * ON_SLOPE, size * slope);
            let height = slope * (foot - start);
            points.push([foot, height]);
            points.push([foot + 1e-5, height + kerb]);
            points.push([foot + size, height + kerb + rise]);
            points.push([foot + 1.5 * size, height + kerb + rise]);
            let words = format!("kerb {:.1} mm on {angle:.1} deg", 1e3 * kerb);
            (heights(&points, "corners"), words)
        }
        Kind::SlopedWaves => {
            let (slope, angle) = slope(draw);
            let (amplitude, wavelength, periods) = waves(draw, size);
            let length = wavelength * periods;
            let turn = std::f64::consts::TAU / wavelength;
            let points = inclined(slope, length, size, |x| {
                amplitude * (1.0 - (turn * x).cos())
            });
            let words = format!(
                "waves +-{:.1} mm of {wavelength:.2} m on {angle:.1} deg",
                1e3 * amplitude
            );
            (heights(&points, "monotone"), words)
        }
        Kind::SlopedRough => {
            let (slope, angle) = slope(draw);
            let (keys, words) = rough(draw, number, size);
            let level = Scene::parse("", "rough", Path::new(""), &[table(&keys)])
                .map_err(|e| format!("{e:?}"))?;
            let profile = level.terrain.profile;
            let points = inclined(slope, 2.0 * size, size, |x| profile.eval(start + x)[0]);
            (
                heights(&points, "monotone"),
                format!("{words} on {angle:.1} deg"),
            )
        }
    })
}

fn table(keys: &str) -> String {
    format!("terrain={{{}}}", keys.replace('\n', ", "))
}

/// Amplitude and wavelength (m), and number of waves; slopes of at most 45 deg.
fn waves(draw: &mut Draw, size: f64) -> (f64, f64, f64) {
    let wavelength = size * draw.within(0.25, 1.0);
    let steepest = draw.within(0.05, 1.0);
    let amplitude = steepest * wavelength / std::f64::consts::TAU;
    (amplitude, wavelength, (2.0 * size / wavelength).ceil())
}

fn rough(draw: &mut Draw, number: u64, size: f64) -> (String, String) {
    let place = draw.within(0.0, 5.0);
    let classes = ["B", "C", "D", "E", "F"].into_iter().zip(1..);
    let class = classes
        .filter(|(_, next)| place >= f64::from(*next) - 1.0)
        .last()
        .map_or("B", |(class, _)| class);
    let keys = format!(
        "kind = \"rough\"\nclass = \"{class}\"\nshortest = {}\nextent = {}\nfade = {}\nstart = {}\nseed = {number}",
        0.2 * size,
        2.0 * size,
        0.3 * size,
        START * size
    );
    (keys, format!("rough {class}"))
}

/// Slope (-) and angle (deg) of an incline, up or down.
fn slope(draw: &mut Draw) -> (f64, f64) {
    let angle = draw.within(-15.0, 15.0);
    (angle.to_radians().tan(), angle)
}

/// Points of an incline with something on it, over a length (m); level before and behind.
fn inclined(slope: f64, length: f64, size: f64, on_it: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let (start, foot, blend) = (START * size, ON_SLOPE * size, 0.15 * size);
    let (end, after) = (foot + length, 0.5 * size);
    let mut points = vec![[-size, 0.0], [start - blend, 0.0]];
    let count = ((end + after - start) / (SPACING * size)).ceil();
    let mut k = 0.0;
    while k <= count {
        let x = start + (end + after - start) * k / count;
        // The incline begins and ends over a short parabola.
        let smooth = |d: f64| {
            if d < blend {
                d.max(0.0).powi(2) / (2.0 * blend)
            } else {
                d - 0.5 * blend
            }
        };
        let feature = if x > foot && x < end {
            on_it(x - foot)
        } else {
            0.0
        };
        let base = smooth(x - start) - smooth(x - end - 0.2 * size);
        points.push([x, slope * base + feature]);
        k += 1.0;
    }
    points.push([end + 2.0 * size, points.last().map_or(0.0, |p| p[1])]);
    points
}

fn heights(points: &[[f64; 2]], interpolation: &str) -> String {
    let mut text = format!("kind = \"heights\"\ninterpolation = \"{interpolation}\"\npoints = [");
    for [x, y] in points {
        let _ = write!(text, "[{x:.6}, {y:.7}], ");
    }
    text.push(']');
    table(&text)
}
