//! `robhaz merge`: one dataset of the shards of a sweep.

use crate::terminal::{shown, tell};
use miette::Result;
use robhaz_sweep::merge_shards;
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `robhaz merge`.
#[derive(clap::Args)]
pub struct Args {
    /// Folders of the shards, each written by `robhaz sweep STUDY.toml --shard I/N --out DIR`. Each run must be in one of them.
    #[arg(required = true)]
    shards: Vec<PathBuf>,
    /// Folder of the merged sweep.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Merges the shards and says where the dataset is.
pub fn run(args: &Args) -> Result<()> {
    let (dataset, runs) = merge_shards(&args.shards, &args.out)?;
    let dataset = shown(&dataset);
    tell(
        &format!("{dataset}: {runs} runs"),
        &json!({"dataset": dataset, "runs": runs}),
    )
}
