//! Runs of the real loop.

use crate::testing::scene;
use robhaz_record::{FigureSink, SummarySink, TableFormat, TableSink};
use robhaz_run::RunError;

/// A robot that drives leaves the ground in table, figure and summary. On level ground with exact
/// readings the profile is level: 1 mm is ten times what was found.
#[test]
fn a_moving_run_leaves_its_ground() -> Result<(), RunError> {
    let mut scene = scene();
    scene.record.duration = 4.0;
    let folder = tempfile::tempdir().expect("a folder");
    let mut tables = TableSink::new(folder.path(), TableFormat::Csv);
    let mut figures = FigureSink::new(folder.path());
    let mut summary = SummarySink::new();
    robhaz_run::run(&scene, &mut [&mut tables, &mut figures, &mut summary])?;
    let summary = summary.summary().expect("a finished run");
    let ground = |k: usize| summary.estimators[k].ground;
    assert_eq!((ground(0), ground(1)), (None, None));
    let errors = ground(2).expect("the last one finds ground");
    assert!(
        errors.points > 80 && errors.height_rmse_m < 1e-3,
        "{errors:?}"
    );

    let mut table = csv::Reader::from_path(folder.path().join("ground-mine.csv")).expect("a table");
    let names = table.headers().expect("names").clone();
    let rows: Vec<Vec<f64>> = table
        .records()
        .map(|row| {
            // An upper bound of the friction is empty where no wheel has slipped.
            let number = |cell: &str| match cell {
                "" => f64::NAN,
                cell => cell.parse().expect("a number"),
            };
            row.expect("a row").iter().map(number).collect()
        })
        .collect();
    assert_eq!(rows.len() as u64, errors.points);
    let column = |name: &str| names.iter().position(|n| n == name).expect("a column");
    let (y, sigma, truth) = (column("y"), column("sigma_y"), column("true_y"));
    assert!(
        rows.iter()
            .all(|row| row[truth] == 0.0 && row[y].abs() < 2.0 * row[sigma] + 1e-3)
    );
    let columns = std::fs::read_to_string(folder.path().join("columns.csv")).expect("columns");
    assert!(
        columns.contains("ground-mine,sigma_slope,rad,"),
        "{columns}"
    );
    Ok(())
}

/// All sinks on a run of the real loop: everything is there, and twice the same.
#[test]
fn a_real_run_leaves_its_tables_figures_and_summary() -> Result<(), RunError> {
    let mut scene = scene();
    scene.record.duration = 0.3;
    scene.record.compare_from = 0.1;
    let folders = [(); 2].map(|()| tempfile::tempdir().expect("a folder"));
    for folder in &folders {
        let mut tables = TableSink::new(folder.path(), TableFormat::Parquet);
        let mut figures = FigureSink::new(folder.path());
        let mut summary = SummarySink::new();
        robhaz_run::run(&scene, &mut [&mut tables, &mut figures, &mut summary])?;
        let summary = summary.summary().expect("a finished run");
        let estimator = &summary.estimators[1];
        assert_eq!((estimator.samples, estimator.missing), (21, 0));
        // At rest on level ground true masses leave no error but that of the settling.
        assert!(estimator.normal_force.expect("errors").rmse_all < 0.5);
    }
    let mut names: Vec<_> = std::fs::read_dir(folders[0].path())
        .expect("files")
        .map(|entry| entry.expect("a file").file_name())
        .collect();
    names.sort();
    // Six tables; six figures.
    assert_eq!(names.len(), 6 + 6, "{names:?}");
    for name in names {
        let [a, b] = [0, 1].map(|i| std::fs::read(folders[i].path().join(&name)));
        assert_eq!(a.expect("first"), b.expect("second"), "{name:?}");
    }
    Ok(())
}
