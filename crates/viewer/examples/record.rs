//! Records a run of 20 s, or of another duration, on the terrain `smooth`:
//! `cargo run --release -p robhaz-viewer --example record -- run.rrd [seconds]`.

#[path = "../tests/common/mod.rs"]
mod common;

use robhaz_viewer::RecordingSink;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let path = PathBuf::from(args.next().unwrap_or_else(|| "run.rrd".to_owned()));
    let seconds = args.next().map_or(Ok(20.0), |s| s.parse())?;

    let start = std::time::Instant::now();
    let mut sink = RecordingSink::save(&path)?;
    let end = robhaz_run::run(&common::smooth(seconds), &mut [&mut sink])?;
    let total = start.elapsed().as_secs_f64();
    println!(
        "{}: {:.2} MB; {seconds} s simulated in {:.2} s, recorded in {:.2} s",
        path.display(),
        std::fs::metadata(&path)?.len() as f64 * 1e-6,
        end.wall,
        total - end.wall
    );
    Ok(())
}
