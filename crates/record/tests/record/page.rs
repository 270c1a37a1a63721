//! The page of a run.

use crate::testing::scene;
use robhaz_record::{FigureSink, SummarySink, page};
use robhaz_run::RunError;

/// A page has the numbers of the summary and every figure, and refers to nothing outside of it.
/// Names are escaped.
#[test]
fn a_page_needs_no_other_file() -> Result<(), RunError> {
    let mut scene = scene();
    scene.name = "<b>steep</b>".to_owned();
    let folder = tempfile::tempdir().expect("a folder");
    let mut figures = FigureSink::new(&folder.path().join("figures"));
    let mut summary = SummarySink::new();
    robhaz_run::run(&scene, &mut [&mut figures, &mut summary])?;
    let summary = summary.summary().expect("a finished run");
    summary.write(folder.path()).expect("a summary");
    std::fs::write(folder.path().join("scene.toml"), "speed = \"<&>\"").expect("a scene");

    let page = page(folder.path()).expect("a page");
    let drawn = std::fs::read_dir(folder.path().join("figures")).expect("figures");
    let is_svg = |e: &std::fs::DirEntry| e.path().extension().is_some_and(|e| e == "svg");
    let drawn = drawn.filter(|e| e.as_ref().is_ok_and(is_svg)).count();
    assert!(drawn > 3);
    assert_eq!(page.matches("<img ").count(), drawn);
    assert_eq!(
        page.matches("src=\"data:image/svg+xml;base64,").count(),
        drawn
    );
    assert!(!page.contains("http") && !page.contains("href") && !page.contains("<script"));
    assert!(!page.contains("<b>") && page.contains("&lt;b&gt;steep"));
    assert!(page.contains("&lt;&amp;&gt;"));
    for name in summary.estimators.keys() {
        assert!(page.contains(&format!("<th>{name}</th>")));
    }
    // The numbers of the summary with four significant digits.
    for estimator in summary.estimators.values() {
        let rmse = estimator.normal_force.expect("an error").rmse_all;
        let digits = (3 - rmse.log10().floor() as i32).max(0) as usize;
        let cell = format!("<td>{rmse:.digits$}</td>");
        assert!(page.contains(&cell), "{cell}");
    }
    Ok(())
}

/// A folder without a summary has no page.
#[test]
fn a_folder_without_a_run_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let error = page(folder.path()).expect_err("no summary");
    assert!(error.to_string().contains("no summary.json"), "{error}");
}
