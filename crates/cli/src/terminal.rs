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
    for warning in scene.warnings() {
        eprintln!("Warning: {}: {warning}", scene.name);
    }
}
