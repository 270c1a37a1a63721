//! `robhaz plot`: a figure of a sweep.

use crate::output_file::{Format, OutputFile};
use crate::terminal::{shown, tell};
use clap::ValueEnum;
use miette::{IntoDiagnostic, Result, miette};
use robhaz_record::{Dataset, FigureFormat, PlotKind, PlotRequest, Spacing, plot};
use robhaz_sweep::{DATASET, JOURNAL};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `robhaz plot`.
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a finished sweep, or its dataset.
    sweep: PathBuf,
    /// The file; without it KIND.svg, KIND.pdf or KIND.png in the folder. Its extension chooses the format.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// `bands`: a score against an axis, median and quantiles of each estimator. `heat`: its median over two axes.
    /// `calibration`: error against the stated standard deviation. `histogram`: how often the score has which value.
    /// `ladder`: the estimators one below the other, each with its median and quantiles over all runs.
    #[arg(long, default_value = "bands")]
    kind: Kind,
    /// Column along the horizontal axis, such as `drive.speed` or `estimator`; of `ladder` the column whose values have
    /// points of their own. Without it the first key that varies.
    #[arg(long, value_name = "COLUMN")]
    x: Option<String>,
    /// Column along the vertical axis of `heat`, without it the next key that varies; column whose values are the
    /// rungs of `ladder`, without it the estimators.
    #[arg(long, value_name = "COLUMN")]
    x2: Option<String>,
    /// Column of the score.
    #[arg(long, value_name = "COLUMN", default_value = "nrmse")]
    y: String,
    /// Estimator that is drawn, by its label; can be given several times. Without it all.
    #[arg(long = "estimator", value_name = "NAME")]
    estimators: Vec<String>,
    /// Spacing along x; without it logarithmic where the study drew it so, or over more than two decades.
    #[arg(long, value_name = "SPACING")]
    scale_x: Option<Scale>,
    /// Spacing of the score; without it logarithmic over more than two decades.
    #[arg(long, value_name = "SPACING")]
    scale_y: Option<Scale>,
    /// Format of the file.
    #[arg(long)]
    format: Option<FileFormat>,
    /// Replaces an existing file.
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    Bands,
    Heat,
    Calibration,
    Histogram,
    Ladder,
}

#[derive(Clone, Copy, ValueEnum)]
enum Scale {
    Linear,
    Log,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FileFormat {
    Svg,
    Pdf,
    /// At 192 dots an inch; needs a font such as Liberation Sans on this machine.
    Png,
}

impl FileFormat {
    /// The asked one, else that of the file's extension, else SVG.
    fn of(args: &Args) -> Self {
        let extension = args.out.as_ref().and_then(|out| out.extension());
        let is =
            |format: &Self| extension.is_some_and(|e| e.eq_ignore_ascii_case(format.extension()));
        let named = [Self::Pdf, Self::Png].into_iter().find(is);
        args.format.or(named).unwrap_or(Self::Svg)
    }

    const fn extension(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Pdf => "pdf",
            Self::Png => "png",
        }
    }
}

impl Scale {
    const fn spacing(self) -> Spacing {
        match self {
            Self::Linear => Spacing::Linear,
            Self::Log => Spacing::Logarithmic,
        }
    }
}

/// Draws the figure.
pub fn run(args: &Args) -> Result<()> {
    let path = dataset(&args.sweep)?;
    let dataset = Dataset::read(&path).into_diagnostic()?;
    let request = PlotRequest {
        kind: match args.kind {
            Kind::Bands => PlotKind::Bands,
            Kind::Heat => PlotKind::Heat,
            Kind::Calibration => PlotKind::Calibration,
            Kind::Histogram => PlotKind::Histogram,
            Kind::Ladder => PlotKind::Ladder,
        },
        x: args.x.clone(),
        x2: args.x2.clone(),
        y: args.y.clone(),
        estimators: args.estimators.clone(),
        x_spacing: args.scale_x.map(Scale::spacing),
        y_spacing: args.scale_y.map(Scale::spacing),
    };
    let format = FileFormat::of(args);
    let drawn = match format {
        FileFormat::Svg => FigureFormat::Svg,
        FileFormat::Pdf => FigureFormat::Pdf,
        FileFormat::Png => FigureFormat::Png,
    };
    let bytes = plot(&dataset, &request, drawn).into_diagnostic()?;
    let file = format!("{}.{}", request.kind.name(), format.extension());
    let default = || path.with_file_name(file);
    let target = args.out.clone().unwrap_or_else(default);
    let kind = Format {
        what: "figures of the asked format",
        extension: format.extension(),
    };
    let file = OutputFile::create(&target, kind, &[path], args.force)?;
    std::fs::write(file.path(), bytes).into_diagnostic()?;
    let figure = shown(&file.finish()?);
    tell(&format!("Figure: {figure}"), &json!({"figure": figure}))
}

/// The dataset of a folder, or the file itself.
///
/// # Errors
/// A message that says what is missing.
pub fn dataset(sweep: &Path) -> Result<PathBuf> {
    if sweep.is_file() {
        return Ok(sweep.to_path_buf());
    }
    let path = sweep.join(DATASET);
    if path.is_file() {
        return Ok(path);
    }
    Err(match (sweep.exists(), sweep.join(JOURNAL).exists()) {
        (false, _) => miette!("there is no folder {}", sweep.display()),
        (_, true) => miette!(
            help = "robhaz sweep goes on where it stopped; robhaz merge puts shards together",
            "the sweep in {} is not complete: it has no {DATASET} yet",
            sweep.display()
        ),
        _ => miette!(
            "{} holds no {DATASET}: it is not the folder of a sweep",
            sweep.display()
        ),
    })
}
