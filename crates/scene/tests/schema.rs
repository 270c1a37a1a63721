//! The JSON Schemas against every file that is shipped, and against wrong files. What a schema refuses the reader must
//! refuse, too: otherwise an editor would mark a file that runs.

use boon::{Compiler, SchemaIndex, Schemas};
use robhaz_scene::{LogChoice, Scene, SchemaKind, StudyChoice, schema};
use serde_json::Value;
use std::error::Error;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A schema that is valid itself: the library checks it against that of its draft.
struct Validator {
    schemas: Schemas,
    index: SchemaIndex,
}

fn validator(kind: SchemaKind) -> Result<Validator, Box<dyn Error>> {
    const NAME: &str = "robhaz.json";
    let (mut schemas, mut compiler) = (Schemas::new(), Compiler::new());
    compiler
        .add_resource(NAME, schema(kind))
        .map_err(|e| e.to_string())?;
    let index = compiler
        .compile(NAME, &mut schemas)
        .map_err(|e| e.to_string())?;
    Ok(Validator { schemas, index })
}

/// Problems of a text in TOML; empty where it is valid.
fn problems(validator: &Validator, text: &str) -> Result<String, Box<dyn Error>> {
    let document: Value = toml::from_str(text)?;
    let checked = validator.schemas.validate(&document, validator.index);
    Ok(checked.err().map(|e| format!("{e:#}")).unwrap_or_default())
}

/// All files of a folder with an extension.
fn files(folder: &str, start: &str) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(root().join(folder))? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with(start) && name.ends_with(".toml") {
            found.push(path);
        }
    }
    Ok(found)
}

/// Every file of each kind that is shipped is valid.
#[test]
fn shipped_files_are_valid() -> Result<(), Box<dyn Error>> {
    let kinds = [
        (SchemaKind::Scene, "scenes", "", 12),
        (SchemaKind::Study, "studies", "", 3),
        (SchemaKind::Geometry, "robots", "geometry", 2),
        (SchemaKind::Mass, "robots", "mass", 2),
        (SchemaKind::Sensors, "examples/logs", "", 2),
    ];
    for (kind, folder, start, least) in kinds {
        let validator = validator(kind)?;
        let files = files(folder, start)?;
        assert!(files.len() >= least, "{folder}: {}", files.len());
        for file in files {
            let text = std::fs::read_to_string(&file)?;
            let found = problems(&validator, &text)?;
            assert!(found.is_empty(), "{}: {found}", file.display());
        }
    }
    Ok(())
}

/// A scene with everything that no shipped one has, a resolved scene, a resolved log description.
#[test]
fn written_files_are_valid() -> Result<(), Box<dyn Error>> {
    let validator = validator(SchemaKind::Scene)?;
    for kind in [
        "flat", "smooth", "cosbump", "ramp", "step", "stairs", "sine", "ditch", "rough",
    ] {
        let set = [
            format!("terrain.kind={kind}"),
            "drive.kind=friction-test".to_owned(),
            "drive.friction_test.start=2".to_owned(),
            "sensors.grade=poor".to_owned(),
        ];
        let scene = Scene::parse("", "written", Path::new(""), &set)?;
        let found = problems(&validator, &scene.to_toml("a test"))?;
        assert!(found.is_empty(), "{kind}: {found}");
    }
    let robot = std::fs::read_to_string(root().join("examples/weigh/real.toml"))?;
    let found = problems(&validator, &robot)?;
    assert!(found.is_empty(), "{found}");
    let log = LogChoice::parse(&robot, "real.toml", Path::new(""), LogChoice::default())?;
    let validator = self::validator(SchemaKind::Sensors)?;
    let found = problems(&validator, &log.to_toml("a test"))?;
    assert!(found.is_empty(), "{found}");
    Ok(())
}

/// Texts with units, booleans for switches, and lists are as valid as for the reader.
#[test]
fn what_the_reader_takes_is_valid() -> Result<(), Box<dyn Error>> {
    let validator = validator(SchemaKind::Scene)?;
    let right = [
        "[drive]\nspeed = \"20 cm/s\"",
        "[drive]\nspeed = \" -1.5e-1   m/s \"",
        "[drive]\nviscous_damping = \"150 mN  m s\"",
        "[robot.mass]\nbody = \"5000 g\"\nlinks = [1.8, 2.2, \"500 g\"]\nwheel = 1.5\nbody_inertia = 0.076\n\
         link_inertias = [0.018, \"225 kg cm^2\", 0.0004]\nwheel_inertia = 0.0075\nrotor_inertia = 0.0864",
        "[terrain]\nkind = \"sine\"\namplitude = \"5 mm\"\nperiods = 3",
        "[terrain]\nkind = \"bumps\"\nbumps = [{ height = \"5 cm\", centre = 1, width = 0.2 }]",
        "[terrain]\nkind = \"heights\"\npoints = [[-1, 0], [1, \"5 cm\"], [2, 0]]\ninterpolation = \"corners\"",
        "[terrain]\nkind = \"parts\"\n[[terrain.part]]\nkind = \"ramp\"\nangle = \"10 deg\"\nstart = 1\nlength = 1",
        "[[terrain.stretch]]\nfrom = 0\nto = \"50 cm\"\nmu_s = 0.5\nmu_d = 0.4",
        "[[estimator]]\nname = \"best\"\nlabel = \"mine\"\nparity = false\n[[estimator]]\nname = \"best\"",
        "[drive]\nscaling = [{ wheels = [1, 3], from = 2, to = \"3 s\", factor = 0 }]",
        "estimator = []\nseed = 7\nname = \"a-b_c\"",
    ];
    for text in right {
        Scene::parse(text, "right.toml", Path::new(""), &[])?;
        let found = problems(&validator, text)?;
        assert!(found.is_empty(), "{text}\n{found}");
    }
    Ok(())
}

/// Wrong scenes are invalid, and the reader refuses each of them.
#[test]
fn wrong_scenes_are_invalid() -> Result<(), Box<dyn Error>> {
    let validator = validator(SchemaKind::Scene)?;
    let wrong = [
        "[drive]\nsped = 0.2",
        "[drives]\nspeed = 0.2",
        "[drive]\nspeed = 11",
        "[drive]\nspeed = \"20 cm\"",
        "[drive]\nspeed = \"fast\"",
        "[drive]\nspeed = [0.2]",
        "[drive]\ntorque_limit = 0",
        "[drive]\nkind = \"torque\"",
        "[drive]\nscaling = [{ wheels = [4], from = 2, to = 3, factor = 0 }]",
        "[drive]\nscaling = [{ wheels = [1], from = 2, factor = 0 }]",
        "[sensors]\ngrade = \"good\"",
        "[terrain]\nkind = \"hill\"",
        "[terrain]\nkind = \"ramp\"\nrise = 0.1",
        "[terrain]\nangle = 0.1",
        "[terrain]\nkind = \"bumps\"",
        "[terrain]\nkind = \"sine\"\nperiods = 2.5",
        "[terrain]\nkind = \"parts\"\npart = [{ kind = \"flat\" }]",
        "[terrain]\nkind = \"heights\"\npoints = [[0, 0]]",
        "[robot]\ngeometry = \"D\"",
        "[robot.mass]\nbody = 5",
        "[[estimator]]\nlabel = \"mine\"",
        "[[estimator]]\nname = \"worst\"",
        "[estimator]\nname = \"best\"",
        "[record]\nduration = 0",
        "seed = -1",
        "name = \"My Scene\"",
    ];
    for text in wrong {
        let found = problems(&validator, text)?;
        assert!(!found.is_empty(), "valid: {text}");
        let read = Scene::parse(text, "wrong.toml", Path::new(""), &[]);
        assert!(read.is_err(), "read: {text}");
    }
    Ok(())
}

/// The same for studies.
#[test]
fn wrong_studies_are_invalid() -> Result<(), Box<dyn Error>> {
    let validator = validator(SchemaKind::Study)?;
    let start = "scene = \"a.toml\"\n";
    let right = [
        "[[axis]]\nkey = \"terrain.part.0.height\"\nvalues = [1]",
        "[[axis]]\nkey = \"estimator[0].observer_pole\"\nlog_uniform = [1, 100]\n[draw]\ncount = 3\nmethod = \"random\"",
        "[[axis]]\nkeys = [\"drive.kp\", \"drive.ki\"]\nnames = [\"soft\"]\nvalues = [[2, 0]]",
        "tables = [0]\n[[axis]]\nkey = \"sensors\"\nvalues = [{ grade = \"poor\" }]\n[[axis]]\nkey = \"seed\"\nfirst = 2\ncount = 3",
    ];
    for text in right {
        let text = format!("{start}{text}");
        StudyChoice::parse(&text, "right.toml")?;
        let found = problems(&validator, &text)?;
        assert!(found.is_empty(), "{text}\n{found}");
    }
    let wrong = [
        "",
        "axis = []\nkey = 3",
        "[[axis]]\nkey = \"seed\"",
        "[[axis]]\nkey = \"seed\"\ncount = 0",
        "[[axis]]\nkey = \"seed\"\ncount = 2\nvalues = [1]",
        "[[axis]]\nkey = \"seed\"\nkeys = [\"seed\"]\nvalues = [1]",
        "[[axis]]\ncount = 2",
        "[[axis]]\nkey = \"drive.kp\"\nuniform = [1]\n[draw]\ncount = 3",
        "[[axis]]\nkey = \"drive.kp\"\nuniform = [1, 2]\n[draw]\nmethod = \"random\"",
        "[[axis]]\nkey = \"drive.kp\"\nuniform = [1, 2]\n[draw]\ncount = 3\nmethod = \"grid\"",
        "[[axis]]\nkey = \"seed\"\ncount = 2\nnames = [\"a\", \"a\"]",
        "axes = 3\n[[axis]]\nkey = \"seed\"\ncount = 2",
        "set = \"drive.kp=2\"\n[[axis]]\nkey = \"seed\"\ncount = 2",
        "tables = \"some\"\n[[axis]]\nkey = \"seed\"\ncount = 2",
    ];
    for text in wrong {
        let text = format!("{start}{text}");
        let found = problems(&validator, &text)?;
        assert!(!found.is_empty(), "valid: {text}");
        let read = StudyChoice::parse(&text, "wrong.toml");
        assert!(read.is_err(), "read: {text}");
    }
    // A key that no scene has: the reader finds it when it reads the scenes of the study.
    let unknown = format!("{start}[[axis]]\nkey = \"drive.sped\"\nvalues = [1]");
    assert!(!problems(&validator, &unknown)?.is_empty());
    Ok(())
}
