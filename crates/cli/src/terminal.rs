//! Standard output of the command, and its warnings.

use miette::{IntoDiagnostic, Result};
use robhaz_scene::Scene;
use std::io::{self, Write};

/// Prints a line. A closed pipe is no error: its reader needs no more.
pub fn say(text: &str) -> Result<()> {
    match writeln!(io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error).into_diagnostic(),
        _ => Ok(()),
    }
}

/// Prints the warnings of a scene on standard error.
pub fn warn(scene: &Scene) {
    let warnings = scene.warnings();
    warnings.iter().for_each(|w| warn_of(&scene.name, w));
}

/// Prints a warning about a scene or log on standard error.
pub fn warn_of(name: &str, warning: &str) {
    // A closed or full standard error is no reason to stop.
    let _ = writeln!(io::stderr().lock(), "Warning: {name}: {warning}");
}
