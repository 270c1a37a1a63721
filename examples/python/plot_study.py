"""Draws a study from the dataset of `robhaz study`. It needs no robhaz, only

    pip install pandas pyarrow "matplotlib>=3.10"
    python examples/python/plot_study.py runs/speed
    python examples/python/plot_study.py runs/ladder --kind ladder --out ladder.png

bands        a score against the column --x: median, 25 to 75 % and 5 to 95 % of the runs. Where --x holds words it is
             `ladder` with --x as --x2
heat         the median of a score over the columns --x and --x2, a map for each estimator
ladder       a box for each estimator over all its runs, with its median at each value of --x as points; with --x2 a box
             for each value of that column, in a chart for each estimator
calibration  nrmse against the stated standard deviation, and the share of errors within two standard deviations
histogram    number of runs over the score

Without --x and --x2 these are the keys that vary, in the order of the study file, seeds last. Quantiles are linear
between neighbours (type 7 of Hyndman and Fan). An axis is logarithmic where the study drew the logarithm of its key, or
over more than two decades.
"""

import argparse
import difflib
import textwrap
import tomllib
from pathlib import Path

import matplotlib.style
import numpy as np
import pandas as pd
import pyarrow.parquet as pq
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator
from pandas.api.types import is_bool_dtype, is_numeric_dtype

SEEDS = ("seed", "terrain.seed")
# Scores that are shares of the mean of N: drawn in percent.
OF_MEAN = ("nrmse", "nrmse_at_one_contact", "stated", "bound")
# The quantiles that are drawn, named as matplotlib names the parts of a box.
SHARES = {0.05: "whislo", 0.25: "q1", 0.5: "med", 0.75: "q3", 0.95: "whishi"}
# Text in SVG stays text, and the same dataset gives the same bytes.
STYLE = {"font.size": 9, "axes.grid": True, "axes.axisbelow": True, "grid.color": "#e0e0e0", "legend.frameon": False,
         "axes.titlelocation": "left", "figure.constrained_layout.w_pad": 0.1, "svg.fonttype": "none",
         "svg.hashsalt": "robhaz"}


class Refused(Exception):
    """Why there is no figure: what was found, and what is allowed."""


def percent(share, _=None):
    return f"{100 * share:.3g}"


def unknown(what, name, allowed):
    near = [known for known in allowed if name in known] or difflib.get_close_matches(name, allowed, cutoff=0.5)
    hint = f"nearest: {', '.join(near)}" if near else f"allowed: {', '.join(allowed)}"
    return Refused(f"the dataset has no {what} {name}; {hint}")


class Study:
    """A dataset, and those of its rows that have the score and belong to the chosen estimators."""

    def __init__(self, asked):
        self.asked, self.score = asked, "nrmse" if asked.kind == "calibration" else asked.y
        file = asked.study / "study.parquet" if asked.study.is_dir() else asked.study
        if not file.is_file():
            stopped = any(asked.study.glob("runs*.jsonl"))
            raise Refused(f"there is no {file}" + "; the study is not complete, robhaz study continues it" * stopped)
        try:
            parquet = pq.ParquetFile(file)
            self.notes = {key.decode(): value.decode() for key, value in (parquet.metadata.metadata or {}).items()}
            self.file = tomllib.loads(self.notes["robhaz.study"])
        except (ValueError, KeyError) as error:
            raise Refused(f"{file} is not the dataset of a study: {error!r}") from error
        self.fields = {field.name: field.metadata for field in parquet.schema_arrow}
        self.all = parquet.read().to_pandas()
        for name, values in self.all.items():
            if not is_numeric_dtype(values) or is_bool_dtype(values):
                words = values.map(str, na_action="ignore")
                self.all[name] = pd.Categorical(words, words.dropna().unique())
        labels = list(self.all.estimator.cat.categories)
        for name in asked.estimator:
            if name not in labels:
                raise unknown("estimator", name, labels)
        self.colours = {name: f"C{place}" for place, name in enumerate(labels)}
        if not is_numeric_dtype(self.column(self.score)):
            raise Refused(f"the column {self.score} holds words; a score needs numbers")
        chosen = self.all[self.all.estimator.isin(asked.estimator or labels)]
        has = np.isfinite(chosen[self.score])
        self.without, self.failed = chosen.estimator[~has].value_counts(sort=False), self.all.error.count()
        if not has.any():
            reason = f", such as: {self.all.error.cat.categories[0]}" if self.failed else ""
            raise Refused(f"no row has a value of {self.score}; {self.failed} runs failed{reason}")
        self.rows = chosen[has].assign(estimator=chosen.estimator[has].cat.remove_unused_categories())
        self.parts = dict(list(self.rows.groupby("estimator", observed=True)))
        # The axis of each key; the keys that vary, of those that vary together the first one.
        self.axes = {key: axis for axis in self.file["axis"] for key in axis.get("keys", [axis.get("key")])}
        first = {id(self.axes[key]): key for key in reversed(self.axes) if self.rows[key].nunique() > 1}
        self.varies = sorted(reversed(first.values()), key=lambda key: key in SEEDS)

    def column(self, name):
        if name not in self.all:
            raise unknown("column", name, list(self.all))
        return self.all[name]

    def along(self, name):
        """The values of the rows in a column: at least two different ones."""
        values = self.rows[self.column(name).name]
        if values.nunique() < 2:
            found = ", ".join(map(str, values.dropna().unique())) or "empty"
            raise Refused(f"{name} is {found} in all rows; these keys vary: {', '.join(self.varies) or 'none'}")
        return values

    def is_drawn(self, name):
        """Whether the study draws the values of a key from a distribution, in place of listing them."""
        return name in self.axes and not {"values", "count"} & set(self.axes[name])

    def spacing(self, name, values):
        asked = self.asked.scale_y if name == self.score else self.asked.scale_x
        low, high = np.nanmin(values), np.nanmax(values)
        if asked == "log" and low <= 0:
            raise Refused(f"{name} has the value {low:g}; a logarithmic axis needs values above zero")
        wide = low > 0 and ("log_uniform" in self.axes.get(name, []) or high > 100 * low)
        return asked or ("log" if wide else "linear")

    def label(self, name):
        unit = "% of the mean N" if name in OF_MEAN else self.fields[name][b"unit"].decode()
        return f"{name} ({unit})" if unit else name

    def text(self, value):
        """A value of the score beside a name."""
        return f"{percent(value)} %" if self.score in OF_MEAN else f"{value:.3g}"

    def scale(self, axis, way, name, values):
        """Spacing and label of the axis `x` or `y`; a linear score starts at zero where the values come near to it."""
        axis.set(**{f"{way}scale": self.spacing(name, values), f"{way}label": self.label(name)})
        ticks = getattr(axis, f"{way}axis")
        if self.spacing(name, values) == "log":
            ticks.set_major_locator(LogLocator(subs=(1, 2, 5)))
            ticks.set_minor_locator(NullLocator())
            ticks.set_major_formatter("{x:g}")
        elif name == self.score and 0 <= np.min(values) < 0.7 * np.max(values):
            axis.set(**{f"{way}lim": (0, None)})
        if name in OF_MEAN:
            ticks.set_major_formatter(percent)

    def finish(self, figure, title, drawn):
        """Title, and a caption: what is drawn, from which runs, what is left out."""
        seeds = [f"{key} {self.all[key].min()} to {self.all[key].max()}" for key in SEEDS if key in self.all]
        failed = f"{self.failed} of them failed and are not drawn" if self.failed else "none failed"
        without = [f"{name} in {count} runs" for name, count in self.without.items() if count]
        lines = [f"{self.score}: {self.fields[self.score][b'description'].decode()}.", drawn,
                 f"Study {self.notes['robhaz.name']}, scene {self.file['scene']}: {self.notes['robhaz.runs']} runs, "
                 f"{', '.join(seeds) or 'one seed'}; {failed}. Made by {self.notes['robhaz.version']}.",
                 f"Without {self.score}: {', '.join(without)}." if without else ""]
        figure.suptitle(title, x=0.01, ha="left", weight="bold")
        text = "\n".join(textwrap.fill(line, 150) for line in lines if line)
        figure.supxlabel(text, x=0.01, ha="left", fontsize=8)
        return figure


def sheet(count, columns, height, **options):
    """A figure of so many charts, in rows of `columns`."""
    rows = -(-count // columns)
    figure = Figure(figsize=(9, 1.2 + rows * height), layout="constrained")
    axes = figure.subplots(rows, min(columns, count), squeeze=False, **options).flatten()
    for axis in axes[count:]:
        axis.remove()
    # The lowest chart of each column; Matplotlib numbers those of the last row alone.
    for axis in axes[max(count - columns, 0):count]:
        axis.tick_params("x", labelbottom=True)
    return figure, axes[:count]


def span(counts):
    return " to ".join(str(count) for count in sorted({counts.min(), counts.max()}))


def bands(study):
    score, varies = study.score, [key for key in study.varies if key not in SEEDS]
    name = study.asked.x or next(iter(varies), "estimator")
    x = place = study.along(name)
    if not is_numeric_dtype(x):
        study.asked.x, study.asked.x2 = None, name
        return ladder(study)
    # Drawn values are put into groups of neighbours: at least ten values a group, at most twelve groups.
    grouped = study.is_drawn(name) and 10 <= x.nunique() and len(x) < 3 * x.nunique() * len(study.parts)
    if grouped:
        groups = pd.qcut(x, min(x.nunique() // 10, 12), duplicates="drop")
        place = x.groupby(groups, observed=True).transform("median")
    runs = study.rows.groupby(["estimator", place], observed=True)[score]
    table = runs.quantile(list(SHARES)).unstack()
    apart = len(study.parts) > 3
    figure, axes = sheet(len(study.parts) if apart else 1, 2, 2 if apart else 3.5, sharex=True, sharey=True)
    for number, estimator in enumerate(study.parts):
        axis, quantiles, colour = axes[number % len(axes)], table.loc[estimator], study.colours[estimator]
        for low, high in ((0.05, 0.95), (0.25, 0.75)):
            axis.fill_between(quantiles.index, quantiles[low], quantiles[high], color=colour, alpha=0.25, linewidth=0.5)
        axis.plot(quantiles[0.5], color=colour, marker="o", markersize=4, label=estimator)
        study.scale(axis, "x", name, x)
        study.scale(axis, "y", score, table)
        axis.legend(loc="upper left")
    each = f"group of neighbouring {name}" if grouped else name
    drawn = f"Line: median; dark band: 25 to 75 %, light band: 5 to 95 % of {span(runs.size())} runs of each {each}."
    return study.finish(figure, f"{score} against {name}", drawn)


def cells(study, name):
    """The cell of each row along an axis: its value, or where the study drew many the middle of an equal interval."""
    x, runs = study.along(name), len(study.rows) / len(study.parts)
    if not study.is_drawn(name) or 4 * x.nunique() <= runs:
        return x.astype("category")
    between = np.geomspace if study.spacing(name, x) == "log" else np.linspace
    edges = between(x.min(), x.max(), int(np.clip((runs / 4) ** 0.5, 3, 12)) + 1)
    return pd.cut(x, edges, labels=(edges[1:] + edges[:-1]) / 2, include_lowest=True)


def heat(study):
    free = [key for key in study.varies if key not in (study.asked.x, study.asked.x2)]
    names = [name or (free.pop(0) if free else None) for name in (study.asked.x, study.asked.x2)]
    if None in names:
        raise Refused(f"a map needs two keys that vary; found: {', '.join(study.varies) or 'none'}")
    x, y = cells(study, names[0]).rename("x"), cells(study, names[1]).rename("y")
    medians = study.rows.groupby(["estimator", y, x], observed=False)[study.score].median()
    norm = LogNorm if study.spacing(study.score, medians) == "log" else Normalize
    norm = norm(medians.min(), medians.max())
    figure, axes = sheet(len(study.parts), 2, 3)
    for axis, estimator in zip(axes, study.parts):
        table = medians[estimator].unstack()
        mesh = axis.pcolormesh(table, norm=norm)
        axis.set(title=estimator, xlabel=names[0], ylabel=names[1])
        for ticks, values in ((axis.xaxis, table.columns), (axis.yaxis, table.index)):
            labels = [value if isinstance(value, str) else f"{value:.3g}" for value in values]
            ticks.set_ticks(np.arange(len(values)) + 0.5, labels)
        axis.tick_params("x", rotation=90)
        axis.grid(False)
    figure.colorbar(mesh, ax=axes, label=study.label(study.score), format=percent if study.score in OF_MEAN else None)
    drawn = f"Median of the runs in each cell; white: no run, {medians.isna().sum()} of {medians.size} cells."
    return study.finish(figure, f"Median {study.score} over {names[0]} and {names[1]}", drawn)


def ladder(study):
    score, by = study.score, study.asked.x2 or "estimator"
    few = [key for key in study.varies if key not in (by, *SEEDS) and study.rows[key].nunique() <= 40]
    points = study.asked.x or next(iter(few), None)
    charts = {"": study.rows} if by == "estimator" else study.parts
    figure, axes = sheet(len(charts), 2, 0.5 + 0.3 * study.along(by).nunique(), sharex=True)
    for axis, (title, rows) in zip(axes, charts.items()):
        groups = rows.groupby(by, observed=True)[score]
        table = groups.quantile(list(SHARES)).unstack()
        axis.bxp(table.rename(columns=SHARES).to_dict("records"), range(len(table)), widths=0.6, showfliers=False,
                 orientation="horizontal", showcaps=False, patch_artist=True, boxprops={"facecolor": "#a8c8e8"},
                 medianprops={"color": "black", "linewidth": 2})
        if points:
            medians = rows.groupby([by, study.along(points).rename("at")], observed=True)[score].median()
            at = table.index.get_indexer(medians.index.get_level_values(by))
            axis.plot(medians, at, "o", color="C0", markersize=4)
        axis.set_yticks(range(len(table)), [f"{name}  {study.text(median)}" for name, median in table[0.5].items()])
        axis.invert_yaxis()
        axis.set_title(title)
        study.scale(axis, "x", score, table)
    drawn = f"Beside each name its median. Bar: median; box: 25 to 75 %; line: 5 to 95 % of {span(groups.size())} runs"
    return study.finish(figure, f"{score} by {by}", drawn + (f"; points: median at each {points}." if points else "."))


def calibration(study):
    rows = study.rows[study.rows.stated > 0]
    if rows.empty:
        raise Refused(f"no row has a value of stated: {', '.join(study.parts)} state no standard deviation")
    figure, (left, right) = sheet(2, 2, 3.5)
    both = rows[["stated", "nrmse"]].stack()
    for estimator, part in rows.groupby("estimator", observed=True):
        colour = study.colours[estimator]
        left.scatter(part.stated, part.nrmse, s=8, color=colour, label=estimator)
        right.hist(part.coverage, np.histogram_bin_edges(rows.coverage, 20), histtype="step", color=colour)
    left.axline([both.min()] * 2, [both.max()] * 2, color="#b4b4b4", zorder=0)
    study.scale(left, "x", "stated", both)
    study.scale(left, "y", "nrmse", both)
    left.legend()
    right.axvline(0.9545, color="black", linestyle="--", linewidth=1)
    right.set(xlabel="share of errors within two standard deviations", ylabel="runs")
    silent = ", ".join(name for name in study.parts if name not in set(rows.estimator)) or "none"
    drawn = ("Left: a point for each run; on the line the error is as large as stated. Right: share of each run; "
             f"dashed: 0.9545, that of a normal distribution. Estimators that state no standard deviation: {silent}.")
    return study.finish(figure, "Calibration: error and stated standard deviation", drawn)


def histogram(study):
    scores = study.rows[study.score]
    log = study.spacing(study.score, scores) == "log"
    # Equal intervals along the axis, the same for all estimators.
    edges = np.histogram_bin_edges(np.log10(scores) if log else scores, 30)
    figure, axes = sheet(len(study.parts), 1, 1.4, sharex=True, sharey=True)
    for axis, (estimator, part) in zip(axes, study.parts.items()):
        low, median, high = part[study.score].quantile([0.05, 0.5, 0.95])
        axis.hist(part[study.score], 10**edges if log else edges, color=study.colours[estimator], alpha=0.5)
        for value, line in ((low, "--"), (median, "-"), (high, "--")):
            axis.axvline(value, color="black", linestyle=line, linewidth=1)
        study.scale(axis, "x", study.score, scores)
        low, median, high = map(study.text, (low, median, high))
        axis.set(title=f"{estimator}: median {median}, 5 to 95 %: {low} to {high}", ylabel="runs")
    return study.finish(figure, f"Distribution of {study.score}", "Line: median; dashed: 5 and 95 %.")


KINDS = {kind.__name__: kind for kind in (bands, heat, ladder, calibration, histogram)}


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", type=Path, help="folder of a finished study, or its dataset")
    parser.add_argument("--kind", choices=KINDS, default="bands")
    parser.add_argument("--x", metavar="COLUMN")
    parser.add_argument("--x2", metavar="COLUMN")
    parser.add_argument("--y", metavar="COLUMN", default="nrmse", help="the score; nrmse by default")
    parser.add_argument("--estimator", action="append", default=[], help="label of one of the estimators to be drawn")
    parser.add_argument("--scale-x", choices=("linear", "log"), help="spacing along --x")
    parser.add_argument("--scale-y", choices=("linear", "log"), help="spacing of the score")
    parser.add_argument("--out", type=Path, help="the file: .svg, .png or .pdf; by default KIND.svg beside the dataset")
    asked = parser.parse_args(arguments)
    out = asked.out or (asked.study if asked.study.is_dir() else asked.study.parent) / f"{asked.kind}.svg"
    # Files without a date.
    dates = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}, ".png": None}
    try:
        if out.suffix not in dates:
            raise Refused(f"--out: found {out}; allowed: a name that ends in {', '.join(dates)}")
        with matplotlib.style.context(["petroff10", STYLE]):
            figure = KINDS[asked.kind](Study(asked))
            figure.savefig(out, dpi=160, metadata=dates[out.suffix])
    except (Refused, OSError) as error:
        parser.exit(1, f"{error}\n")
    print(f"Figure: {out}")
    return figure


if __name__ == "__main__":
    main()
