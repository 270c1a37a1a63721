//! How errors are shown: message, place in the file, causes and help, as compilers show them.

use annotate_snippets::{Annotation, AnnotationKind, Group, Level, Renderer, Snippet};
use miette::{Diagnostic, ReportHandler};
use robhaz_scene::harmless;
use std::fmt;
use std::io::IsTerminal as _;
use std::iter::successors;

/// Columns of the lines of a file that are shown.
const WIDTH: usize = 120;
/// Lines with more bytes are not shown: that would take seconds.
const LONGEST: usize = 100_000;

/// Shows errors on standard error.
struct Shown;

impl ReportHandler for Shown {
    fn debug(&self, error: &dyn Diagnostic, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut groups = vec![group(error)];
        groups.extend(error.related().into_iter().flatten().map(group));
        let is_plain = !std::io::stderr().is_terminal() || std::env::var_os("NO_COLOR").is_some();
        let renderer = if is_plain {
            Renderer::plain()
        } else {
            Renderer::styled()
        };
        let renderer = renderer.term_width(WIDTH);
        f.write_str(&renderer.render(&groups))
    }
}

/// From now on reports are shown in this form.
pub fn install() {
    // It fails only where a form was chosen before.
    let _ = miette::set_hook(Box::new(|_| Box::new(Shown)));
}

/// An error with all that belongs to it.
fn group(error: &dyn Diagnostic) -> Group<'static> {
    let causes = successors(error.source(), |cause| (*cause).source());
    let help = error.help();
    Group::with_title(Level::ERROR.primary_title(error.to_string()))
        .elements(snippet(error))
        .elements(causes.map(|cause| Level::NOTE.message(cause.to_string())))
        .elements(help.map(|help| Level::HELP.message(help.to_string())))
}

/// The lines around the place of an error.
fn snippet(error: &dyn Diagnostic) -> Option<Snippet<'static, Annotation<'static>>> {
    let label = error.labels()?.next()?;
    let source = error.source_code()?;
    let lines = source.read_span(label.inner(), 1, 1).ok()?;
    let shown = lines.data().strip_suffix(b"\n").unwrap_or(lines.data());
    let shown = shown.strip_suffix(b"\r").unwrap_or(shown);
    if shown.len() > LONGEST {
        return None;
    }
    // The renderer replaces all control characters but these, which are as long as a middle dot.
    let is_control = |c: char| ('\u{80}'..='\u{9f}').contains(&c);
    let text = String::from_utf8_lossy(shown).replace(is_control, "\u{b7}");
    let start = label.offset().checked_sub(lines.span().offset())?;
    let place = start.min(text.len())..(start + label.len()).min(text.len());
    let snippet = Snippet::source(text).line_start(lines.line() + 1);
    let snippet = snippet.path(lines.name().map(harmless));
    Some(snippet.annotation(AnnotationKind::Primary.span(place)))
}
