//! Tracks as measuring programs and spreadsheets write them, and the messages about those that
//! cannot be read.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at the first surprise"
)]

use robhaz_scene::Scene;
use robhaz_terrain::{Heights, Profile, Vec2};
use std::path::Path;

/// The scene with a track and more of its keys; problems without the folder's name, one line each.
fn scene(csv: &[u8], keys: &str) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.csv"), csv).unwrap();
    let text = format!("[terrain]\nkind = 'heights'\nfile = 'a.csv'\n{keys}");
    Scene::parse(&text, "x.toml", folder.path(), &[]).map_err(|error| {
        let lines: Vec<_> = error.problems.iter().map(ToString::to_string).collect();
        let folder = format!("{}/", folder.path().display());
        lines.join("\n").replace(&folder, "")
    })
}

fn heights(csv: &[u8], keys: &str) -> Result<Heights, String> {
    match scene(csv, keys)?.terrain.profile {
        Profile::Heights(heights) => Ok(heights),
        other => panic!("{other:?}"),
    }
}

/// The points of a track in mm.
#[track_caller]
fn reads(csv: &[u8], keys: &str, expected: &[[f64; 2]]) {
    let found = heights(csv, keys).unwrap_or_else(|e| panic!("{e}"));
    let expected: Vec<_> = expected.iter().map(|p| Vec2::new(p[0], p[1])).collect();
    assert_eq!(found.points(), expected);
}

#[track_caller]
fn refused(csv: &[u8], keys: &str, expected: &[&str]) {
    let found = scene(csv, keys).map(|_| ()).unwrap_err();
    for expected in expected {
        assert!(found.contains(expected), "{found}\nlacks: {expected}");
    }
}

const TWO: [[f64; 2]; 2] = [[0.0, 0.5], [1.5, -0.25]];

/// Equivalence: one track in every form is the same points to the bit.
#[test]
fn one_track_in_every_form() {
    let forms: [&[u8]; 20] = [
        b"0,0.5\n1.5,-0.25\n",
        b"0,0.5\r\n1.5,-0.25",
        b"\xef\xbb\xbfx,y\n0,0.5\n1.5,-0.25\n",
        b"x;y\n0;0.5\n1.5;-0.25\n",
        b"x;y\n0;0,5\n1,5;-0,25\n",
        b"x\ty\n0\t0,5\n1,5\t-0,25\n",
        b"\"x\",\"y\"\n\"0\",\"0,5\"\n\"1,5\",\"-0,25\"\n",
        b"x [mm],y [mm]\n0,500\n1500,-250\n",
        b"x [mm];height (cm)\n0;50\n1500;-25\n",
        b"x_cm;z / mm\n0;500\n150;-250\n",
        "Weg [m];Höhe [m]\n0;0,5\n1,5;-0,25\n".as_bytes(),
        // The same in Latin-1.
        b"Weg [m];H\xf6he [m]\n0;0,5\n1,5;-0,25\n",
        "x;h [µm]\n0;500000\n1,5;\u{2212}250000\n".as_bytes(),
        b"height,x\n0.5,0\n-0.25,1.5\n",
        b"time [s],x [m],y [m],comment\n0,0,0.5,start\n0.1,1.5,-0.25,\n",
        b"Distance;Elevation;Note\n0;0.5;\"a; b\"\n1.5;-0.25;\n",
        b"sep=;\r\nx;y;;\r\n\r\n0;0.5;;\r\n;;;\r\n# comment\r\n1.5;-0.25\r\n",
        b"0 m,50 cm\n150 cm,-250 mm\n",
        b" x , y \n  # comment\n 0 , 0.5 \n 1.5 , -2.5e-1 \n",
        b"\"x\"\t\"y\"\r0\t0.5\r1.5\t-0.25\r",
    ];
    for csv in forms {
        println!("{}", String::from_utf8_lossy(csv));
        reads(csv, "", &TWO);
    }
}

#[test]
fn columns_are_chosen_by_name_or_number() {
    let csv = b"t,left x [cm],left z [mm],right z [mm]\n0,0,1,500\n1,150,2,-250\n";
    refused(
        csv,
        "",
        &[
            "a.csv:1: terrain.file: found the columns \"t\", \"left x [cm]\", \"left z [mm]\", \"right z [mm]\", read with the separator comma",
            "x_column and height_column choose by name or number",
        ],
    );
    reads(
        csv,
        "x_column = 'left x'\nheight_column = 'Right Z [mm]'",
        &TWO,
    );
    reads(csv, "x_column = 2\nheight_column = 4", &TWO);
    refused(
        csv,
        "x_column = 2\nheight_column = 5",
        &["found 4 columns, but height_column = 5"],
    );
    refused(
        csv,
        "x_column = 2\nheight_column = 2",
        &["found column 2 for both"],
    );
    refused(
        csv,
        "x_column = 'z'\nheight_column = 2",
        &["found no column of the name \"z\" of x_column"],
    );
    refused(
        csv,
        "x_column = 0",
        &["x.toml:4: terrain.x_column: found 0, allowed: a name"],
    );
    // Without a header columns have numbers only.
    let csv = b"7,0,0.5\n8,1.5,-0.25\n";
    refused(
        csv,
        "",
        &["a.csv:1: terrain.file: found 3 columns without names"],
    );
    reads(csv, "x_column = 2\nheight_column = 3", &TWO);
    let points = "[terrain]\nkind = 'heights'\npoints = [[0, 0], [1, 0]]\nsort = 'on'";
    let error = Scene::parse(points, "x.toml", Path::new(""), &[]).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("terrain.sort: found 'on', allowed: no such key beside points")
    );
}

/// Ambiguous tracks are refused: each message states what was found and how it was read.
#[test]
fn what_is_not_understood_is_said() {
    // Units in a comment must not be ignored: that would be a factor of 1000.
    refused(
        b"# x [mm], height [mm]\n900,0\n1000,10\n",
        "",
        &["found a header with units in a comment above"],
    );
    // A comment that is no header stays a comment.
    reads(
        b"# measured on 3 May (dry), by hand\n0.9,0\n1,0.01\n",
        "",
        &[[0.9, 0.0], [1.0, 0.01]],
    );
    refused(b"x,z\n1,0\n1,0.1\n", "", &["found one x"]);
    for (csv, expected) in [
        (
            &b"x y\n0 0\n1 1\n"[..],
            "a.csv:1: terrain.file: found one column, read with the separator comma; allowed: columns separated by",
        ),
        (
            b"x,y\n0,5,0\n1,5,1\n",
            "a.csv:2: terrain.file: found 3 columns with the separator comma, allowed: 2 as in the first line",
        ),
        (
            b"x;y\n0;1.234,5\n1;2\n",
            "found \"1.234,5\" in column \"y\"",
        ),
        (
            b"x [ft],y\n0,0\n1,1\n",
            "found the unit \"ft\" of column \"x [ft]\", allowed units: m, dm, cm, mm, um",
        ),
        (
            b"x,y\n0,nan\n1,1\n",
            "a.csv:2: terrain.file: found \"nan\" in column \"y\", allowed: a number",
        ),
        (
            b"nan,nan\n1,1\n",
            "a.csv:1: terrain.file: found \"nan\" in column 1",
        ),
        (
            b"x,y\n0,0\n1001,1\n",
            "found \"1001\" in column \"x\", allowed: from -1000 m to 1000 m: x counts from where the robot starts",
        ),
        (
            b"x [mm],y\n0,0\n1 cm,1\n",
            "found \"1 cm\" in column \"x [mm]\"",
        ),
        (b"", "a.csv: found no point"),
        (
            b"x,y\n",
            "a.csv: found no point with the separator comma, allowed: 2 to 2 000 000 points",
        ),
        (b"x,y\n0,0\n", "a.csv: found one point"),
        (
            b"\xff\xfex\0,\0",
            "a.csv: found text in UTF-16, allowed: UTF-8",
        ),
        (
            b"y,z\n0,0\n1,1\n",
            "a.csv:1: terrain.file: found the columns \"y\", \"z\"",
        ),
        (b"x,\"y\n0,0\n1,1\n", "a.csv"),
    ] {
        refused(csv, "", &[expected]);
    }
    // Two columns of other names are x and height.
    reads(b"a,b\n0,0\n1,1\n", "", &[[0.0, 0.0], [1.0, 1.0]]);
}

#[test]
fn order_is_asked_for_or_made() {
    let csv = b"x,y\n1.5,-0.25\n0,0.5\n0,0.5\n";
    refused(
        csv,
        "",
        &[
            "a.csv:3: terrain.file: found x = 0 m, allowed: x not below that of the point before, 1.5 m; or sort = \"on\"",
        ],
    );
    reads(csv, "sort = 'on'", &TWO);
    reads(csv, "sort = true", &TWO);
    // Two heights at one place: which comes first is not known.
    refused(
        b"0,0\n1,1\n0,1\n1,-1.5\n1.5,-0.25\n",
        "sort = 'on'",
        &[
            "found the heights 0 and 1 m at x = 0 m in lines whose order does not show which comes first",
        ],
    );
    refused(
        b"1,0\n1,2\n",
        "sort = 'on'",
        &["found the heights 0 and 2 m at x = 1 m"],
    );
}

/// Points of equal x are a riser, in any order of the lines; only corners without smoothing have one. Nothing is
/// averaged, and no message says that it would be.
#[test]
fn equal_x_are_a_riser() {
    let kerb = [[0.0, 0.0], [1.5, 0.0], [1.5, 0.05], [3.0, 0.05]];
    let forward = b"x,height\n0,0\n1.5,0\n1.5,0.05\n3,0.05\n";
    let backward = b"x,height\n3,0.05\n1.5,0.05\n1.5,0\n0,0\n";
    let corners = "interpolation = 'corners'\n";
    reads(forward, corners, &kerb);
    reads(forward, &format!("{corners}sort = 'on'\n"), &kerb);
    reads(backward, &format!("{corners}sort = 'on'\n"), &kerb);
    for sort in ["", "sort = 'on'\n"] {
        let error = scene(forward, sort).map(|_| ()).unwrap_err();
        let riser = "found two points at x = 1.5 m, heights 0 and 0.05 m: a riser; allowed: interpolation = \"corners\"";
        assert!(error.contains(riser) && !error.contains("sort"), "{error}");
        let smoothed = format!("{corners}{sort}smoothing = '2 cm'\n");
        refused(
            forward,
            &smoothed,
            &["which smoothing would make a ramp of"],
        );
    }
    // Points in the scene itself.
    let scene = |points: &str| {
        let text = format!("[terrain]\nkind = 'heights'\n{corners}points = {points}\n");
        Scene::parse(&text, "x.toml", Path::new("."), &[])
    };
    assert!(scene("[[0, 0], [1.5, 0], [1.5, 0.05], [3, 0.05]]").is_ok());
    assert!(scene("[[0, 0], [1.5, 0], [1.5, 0]]").is_err());
}

/// A file has one decimal mark; thousands separators are errors with their cell.
#[test]
fn thousands_separators_are_refused() {
    let thousands = |csv: &[u8], cell: &str| refused(csv, "", &["thousands separators", cell]);
    thousands(
        b"x [mm],z\n0,0.001\n500,0.5\n\"1,000\",0.002\n",
        "a.csv:4: terrain.file: found \"1,000\"",
    );
    thousands(
        b"x [mm];z\n0;0,001\n500;0,5\n1.000;0,002\n",
        "a.csv:4: terrain.file: found \"1.000\"",
    );
    thousands(b"x [mm],z\n0,0\n1'000,0\n", "a.csv:3");
    thousands(b"x [mm],z\n0,0\n1 000,0\n", "a.csv:3");
    let mut csv = "x [mm];z [mm]\n".to_owned();
    for k in 0..30_u32 {
        let x = match 100 * k {
            x @ 0..1000 => x.to_string(),
            x => format!("{}.{:03}", x / 1000, x % 1000),
        };
        csv += &format!("{x};{}\n", k % 2);
    }
    refused(
        csv.as_bytes(),
        "sort = 'on'\n",
        &["a.csv:12: terrain.file: found \"1.000\"", "thousands"],
    );
}

/// Two hundred thousand points are read, copied to the folder of the resolved scene and read again;
/// the scene itself stays small.
#[test]
fn many_points() {
    let mut csv = String::from("x [mm];z [mm]\n");
    for i in 0..200_000 {
        csv += &format!("{};{},{}\n", i, i % 7, i % 10);
    }
    let scene = scene(csv.as_bytes(), "").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let [track] = scene.terrain.tracks.as_slice() else {
        panic!("one track");
    };
    assert_eq!(&*track.bytes, csv.as_bytes());
    std::fs::write(folder.path().join(track.file_name()), &track.bytes).unwrap();
    let text = scene.to_toml("x");
    assert!(
        text.len() < 20_000 && text.contains("file = \"track.csv\""),
        "{}",
        text.len()
    );
    let again = Scene::parse(&text, "x.toml", folder.path(), &[]).unwrap();
    assert!(again == scene);
    // The copy is known by its hash.
    std::fs::write(
        folder.path().join("track.csv"),
        csv.replacen("0;0,0", "0;0,1", 1),
    )
    .unwrap();
    let error = Scene::parse(&text, "x.toml", folder.path(), &[]).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("terrain.file_hash: found \"sha256:"),
        "{error}"
    );
    assert!(
        error
            .to_string()
            .ends_with("it is not the one that was meant"),
        "{error}"
    );
}

/// The default stays between its points; a spline through a kerb does not, and the scene warns.
#[test]
fn splines_that_swing_are_reported() {
    let kerb = b"x,y\n0.5,0\n0.55,0\n0.6,0\n0.65,0.05\n0.7,0.05\n0.75,0.05\n";
    let scene_of = |keys: &str| scene(kerb, keys).unwrap();
    let monotone = heights(kerb, "interpolation = 'monotone'").unwrap();
    assert_eq!(heights(kerb, "").unwrap(), monotone);
    assert!(scene_of("").warnings().is_empty());
    assert!(scene_of("interpolation = 'corners'").warnings().is_empty());
    let found = scene_of("interpolation = 'spline'").warnings();
    assert_eq!(found.len(), 1);
    assert!(
        found[0].starts_with("terrain: near x = 0.")
            && found[0].contains("the spline leaves the heights"),
        "{found:?}"
    );
    // The shipped track is sampled finely enough.
    let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/heights.toml");
    assert!(
        Scene::load(Path::new(shipped), &[])
            .unwrap()
            .warnings()
            .is_empty()
    );
}

/// Thousands of millimetres are no thousandths of them, and geographic coordinates, times and depths are neither x nor a
/// height; but where they are chosen.
#[test]
fn what_is_no_length_is_refused() {
    let grouped = b"x [mm],height [mm]\n0,0\n\"1,500\",0\n\"1,500\",50\n\"3,000\",50\n";
    refused(
        grouped,
        "",
        &[
            "found \"1,500\" in the column of x",
            "without thousands separators",
        ],
    );
    for header in ["lon,lat", "t,height", "x,depth", "Latitude;Longitude"] {
        let csv = format!("{header}\n0,0.5\n1.5,-0.25\n")
            .replace(',', if header.contains(';') { ";" } else { "," });
        refused(
            csv.as_bytes(),
            "",
            &["which is neither x nor a height in m"],
        );
    }
    reads(
        b"t,lat\n0,0.5\n1.5,-0.25\n",
        "x_column = 't'\nheight_column = 'lat'",
        &TWO,
    );
}
