//! The resolved scene reads back as exactly the scene that it was written from, in any folder.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at the first surprise"
)]

use proptest::prelude::*;
use robhaz_scene::Scene;
use std::path::Path;

/// The folder of the shipped scenes.
const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");

fn load(name: &str, overrides: &[String]) -> Scene {
    let file = format!("{SCENES}/{name}.toml");
    Scene::load(Path::new(&file), overrides).unwrap_or_else(|e| panic!("{e}"))
}

/// The names of the shipped scenes.
fn shipped() -> Vec<String> {
    let files = std::fs::read_dir(SCENES).unwrap();
    let paths = files.map(|file| file.unwrap().path());
    let scenes = paths.filter(|path| path.extension().is_some_and(|e| e == "toml"));
    let name = |path: std::path::PathBuf| path.file_stem().unwrap().to_string_lossy().into_owned();
    let mut names: Vec<String> = scenes.map(name).collect();
    names.sort();
    assert!(names.len() >= 12, "{names:?}");
    names
}

/// Written and read back under another name and in a folder with nothing in it but the copies of
/// tracks.
fn again(scene: &Scene) -> Scene {
    let text = scene.to_toml("robhaz 0.1.0, rapier2d 0.36.1");
    let folder = tempfile::tempdir().unwrap();
    for track in &scene.terrain.tracks {
        std::fs::write(folder.path().join(track.file_name()), &track.bytes).unwrap();
    }
    Scene::parse(&text, "runs/1/scene.toml", folder.path(), &[])
        .unwrap_or_else(|e| panic!("{e}\n{text}"))
}

#[test]
fn every_shipped_scene_comes_back() {
    for name in shipped() {
        let scene = load(&name, &[]);
        assert_eq!(again(&scene), scene);
    }
}

#[test]
fn choices_of_every_kind_come_back() {
    for overrides in [
        vec!["robot.geometry=B", "robot.mass=text"],
        vec![
            "robot.geometry.body_cg=[0.04, 0.3]",
            "robot.mass.links.0='1.9 kg'",
        ],
        vec!["terrain.kind=flat"],
        vec!["drive.kind=shared"],
        vec!["drive.kind=shared", "drive.estimator=true-mass"],
        vec![
            "terrain.kind=bumps",
            "terrain.bumps=[{height=0.1, centre=1, width=0.3}, {height=-0.1, centre=3, width=1}]",
        ],
        vec!["terrain.kind=cosbump", "terrain.centre=2"],
        vec![
            "terrain.kind=stairs",
            "terrain.count=1",
            "terrain.rise='-3 cm'",
        ],
        vec!["terrain.kind=step", "terrain.kerb=-0.05"],
        vec![
            "terrain.kind=sine",
            "terrain.periods=3",
            "terrain.amplitude='-1 cm'",
        ],
        vec!["terrain.kind=ditch", "terrain.width=0.2"],
        vec!["terrain.kind=rough", "terrain.class=E", "seed=5"],
        vec!["terrain.kind=rough", "terrain.seed=18446744073709551615"],
        vec![
            "terrain.kind=heights",
            "terrain.points=[[1, 0.2], ['150 cm', 0.1], [2, 0.3]]",
            "terrain.interpolation=corners",
            "terrain.smoothing='3 cm'",
        ],
        vec![
            "terrain.kind=heights",
            "terrain.file=../terrains/track.csv",
            "terrain.x_column=X",
            "terrain.height_column=2",
            "terrain.sort=true",
            "terrain.interpolation=monotone",
        ],
        vec![
            "terrain.kind=parts",
            "terrain.part=[{kind='step',start=-9},{kind='heights',file='../terrains/track.csv'}]",
        ],
        vec![
            "terrain.kind=sine",
            "terrain.stretch=[{from=1,to='200 cm',mu_s=0.2,mu_d=0.1},{from=2,to=3,mu_s=0,mu_d=0}]",
        ],
        vec![
            "terrain.kind=parts",
            "terrain.part=[{kind='step'},{kind='smooth'},{kind='rough',start=9},{kind='heights',points=[[30,0],[31,1]]}]",
            "terrain.part.0.start=-2",
            "terrain.stretch=[{from=1,to=2,mu_s=0.2,mu_d=0.1}]",
        ],
        vec!["estimator=[]"],
        vec!["estimator=[{name='true-mass'},{name='true-mass',label='slow',observer_pole=5}]"],
        vec!["seed=18446744073709551615", "name=a-b_c"],
        vec![r#"robot.mass.name="a \"b\" \\ c\n\u007f é # x""#],
        vec!["contact.damping_ramp=0", "drive.start_time=-0.0"],
        vec![
            "contact.friction=rigid",
            "contact.rolling_resistance=0.02",
            "engine.kind=direct",
            "drive.scaling=[{wheels=[1,3],from=1,to=2,factor=-0.5},{wheels=[2],from=0.1,to=2,factor=3}]",
        ],
        vec!["contact.friction=brush", "contact.slip_stiffness=5"],
        vec!["sensors.grade=typical", "sensors.dropped=0.25"],
        vec![
            "sensors.grade=poor",
            "sensors.inclination_measures=gravity",
            "sensors.rate_walk='0.1 deg/s/sqrt(s)'",
            "model_error.body_cg='10 mm'",
            "model_error.viscous_damping=-0.2",
        ],
    ] {
        let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
        let scene = load("smooth", &overrides);
        assert_eq!(again(&scene), scene);
    }
}

/// The file has numbers with units, no paths, and the version that wrote it.
#[test]
fn the_file_explains_itself() {
    let text = load("smooth", &[]).to_toml("robhaz 1.2.3");
    for line in [
        "name = \"smooth\" # name of the scene: names the default output folder",
        "[resolved] # what wrote this file; not read",
        "version = \"robhaz 1.2.3\"",
        "kp = 5.0 # N m s; proportional gain on the wheel speed",
        "wheel_radius = 0.1 # m; radius of every wheel",
        "[robot.geometry.pins] # positions of the pins",
        "q = [-0.05, 0.14] # m; between link 1 and link 2",
        "label = \"paper-body\" # unique name in tables, figures and file names",
    ] {
        assert!(text.lines().any(|l| l == line), "{line}\n{text}");
    }
}

/// A resolved scene can be changed by overrides as any other.
#[test]
fn resolved_scenes_take_overrides() {
    let text = load("smooth", &[]).to_toml("x");
    let overrides = [
        "robot.mass.body=6".to_owned(),
        "terrain.kind=flat".to_owned(),
    ];
    let scene = Scene::parse(&text, "scene.toml", Path::new(""), &overrides).unwrap();
    assert_eq!(scene.terrain.kind, "flat");
    assert_eq!(scene.robot.mass_name, "caption, changed");
}

/// Keys with the ends of their ranges here: ground that carries the robot, inertias that its parts can have.
const NUMBERS: [(&str, f64, f64); 17] = [
    ("contact.stiffness", 1e11, 1e15),
    ("contact.exponent", 1.0, 5.0),
    ("contact.mu_s", 0.7, 10.0),
    ("contact.v_s", 1e-9, 0.099),
    ("drive.speed", -10.0, 10.0),
    ("drive.ki", 0.0, 1e6),
    ("drive.gear_friction", 0.0, 1e3),
    ("sensors.inclination_bias", 0.0, 1.0),
    ("model_error.viscous_damping", -1.0, 10.0),
    ("engine.step", 1e-9, 1e-3),
    ("record.compare_from", 0.0, 3.9),
    ("estimator.0.observer_pole", 1e-9, 1e6),
    ("estimator.2.crossover_time", 1e-9, 1e6),
    ("robot.mass.wheel", 0.75, 1e3),
    ("robot.mass.link_inertias.1", 1e-9, 1.0),
    ("robot.geometry.pins.q.0", -0.2, 0.1),
    ("robot.geometry.stop.lower", -3.0, -1e-12),
];

proptest! {
    /// Any numbers come back bit for bit.
    #[test]
    fn any_numbers_come_back(
        name in proptest::sample::select(shipped()),
        seed: u64,
        parts in proptest::array::uniform17(0.0..1.0_f64),
    ) {
        // Rapier's step must fit the numbers; any numbers are direct's.
        let mut overrides = vec![format!("seed={seed}"), "engine.kind=direct".to_owned()];
        for ((key, low, high), part) in NUMBERS.iter().zip(parts) {
            overrides.push(format!("{key}={:?}", low + (high - low) * part));
        }
        let scene = load(&name, &overrides);
        prop_assert_eq!(again(&scene), scene);
    }
}
