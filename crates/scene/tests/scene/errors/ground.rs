//! Errors of the ground.

use super::{lines, one};
use robhaz_scene::Scene;

#[test]
fn keys_of_another_kind_of_terrain() {
    one(
        "[terrain]\nkind = \"flat\"\nheight = 0.1",
        "x.toml:3: terrain.height: found height, allowed: with kind = \"flat\": kind, stretch; \
         height belongs to kind = \"cosbump\"",
    );
    one(
        "[terrain]\nbumps = []",
        "x.toml:2: terrain.bumps: found bumps, allowed: with kind = \"smooth\": kind, stretch; \
         bumps belongs to kind = \"bumps\"",
    );
    one(
        "[terrain]\nkind = 'bumps'",
        "x.toml:1: terrain.bumps: missing, and it has no default; \
         allowed: an array of 1 to 1000 tables {height, centre, width}",
    );
    let found = lines(
        "[terrain]\nkind = 'bumps'\nbumps = [{height = 1, centre = 2}, {height = 1, centre = 2, width = 0}]",
    );
    assert!(
        found[0].starts_with("x.toml:3: terrain.bumps[0].width: missing, and it has no default")
    );
    assert!(found[1].starts_with(
        "x.toml:3: terrain.bumps[1].width: found 0, allowed: a number of at least 0.005"
    ));
}

#[test]
fn points_of_the_ground() {
    one(
        "[terrain]\nkind = 'heights'\npoints = [[0, 0], [1, 0.1],\n [0.9, 0.2]]",
        "x.toml:4: terrain.points[2]: found [0.9, 0.2] (an array), allowed: x above that of the point before, 1 m, or the same with another height, a riser",
    );
    one(
        "[terrain]\nkind = 'heights'",
        "x.toml:1: terrain: found neither of file and points, allowed: one of them",
    );
    let folder = tempfile::tempdir().unwrap();
    let read = |csv: &str| {
        std::fs::write(folder.path().join("a.csv"), csv).unwrap();
        let text = "terrain = {kind = 'heights', file = 'a.csv'}";
        let scene = Scene::parse(text, "x.toml", folder.path(), &[]);
        scene.map_err(|e| {
            let lines: Vec<_> = e.problems.iter().map(ToString::to_string).collect();
            let folder = format!("{}/", folder.path().display());
            lines.join("\n").replace(&folder, "")
        })
    };
    assert!(read("x,y\r\n# a comment\r\n0,0\r\n\r\n1.5, 2e-2\r\n").is_ok());
    let number = "allowed: a number with a decimal point or comma and no thousands separators (separator comma)";
    for (line, cell) in [("1, high", "\"high\""), ("2", "nothing")] {
        let found = read(&format!("x, y\n0, 0\n{line}\n"))
            .map(|_| ())
            .unwrap_err();
        assert_eq!(
            found,
            format!("a.csv:3: terrain.file: found {cell} in column \"y\", {number}")
        );
    }
    let found = read("1,0\n0,1\n").map(|_| ()).unwrap_err();
    assert_eq!(
        found,
        "a.csv:2: terrain.file: found x = 0 m, allowed: x not below that of the point before, 1 m; or sort = \"on\""
    );
}

#[test]
fn stretches_of_the_ground() {
    let stretch = |from: f64, to: f64, mu_s: f64, mu_d: f64| {
        format!("[[terrain.stretch]]\nfrom = {from}\nto = {to}\nmu_s = {mu_s}\nmu_d = {mu_d}\n")
    };
    one(
        &(stretch(0.0, 2.0, 0.5, 0.5) + &stretch(1.0, 3.0, 0.5, 0.5)),
        "x.toml:7: terrain.stretch[1].from: found 1, allowed: not below the end of the stretch before, 2 m",
    );
    one(
        &stretch(2.0, 2.0, 0.5, 0.5),
        "x.toml:3: terrain.stretch[0].to: found 2, allowed: above from, 2 m",
    );
    one(
        &stretch(1.0, 2.0, 0.5, 0.6),
        "x.toml:5: terrain.stretch[0].mu_d: found 0.6, allowed: not above mu_s, 0.5",
    );
    assert!(lines("[[terrain.stretch]]\nfrom = 1")[0].contains("terrain.stretch[0].to: missing"));
}

#[test]
fn parts_of_the_ground() {
    let parts = |parts: &str| format!("[terrain]\nkind = 'parts'\n{parts}");
    let part = |keys: &str| format!("[[terrain.part]]\n{keys}\n");
    one(
        &parts(&(part("kind = 'step'\nstart = 2") + &part("kind = 'step'\nstart = 1"))),
        "x.toml:1: terrain: part 1 starts at 1 m, before the end of the part before, 2 m",
    );
    one(
        &parts(&part("kind = 'step'\nrise = 0.1")),
        "x.toml:5: terrain.part[0].rise: found rise, allowed: with kind = \"step\": kind, start, kerb; \
         rise belongs to kind = \"stairs\"",
    );
    for (wrong, path) in [
        ("kind = 'flat'", "kind"),
        ("kind = 'parts'", "kind"),
        ("stretch = 1", "stretch"),
    ] {
        let lines = lines(&parts(&part(wrong)));
        assert!(
            lines[0].starts_with(&format!("x.toml:4: terrain.part[0].{path}: ")),
            "{lines:?}"
        );
    }
    assert!(lines(&parts(""))[0].contains("terrain.part: missing"));
}
