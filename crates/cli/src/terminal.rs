//! What the command says on standard output, and its warnings.

use miette::{IntoDiagnostic, Result};
use robhaz_scene::Scene;
use std::io::{self, Write};

/// Prints a text and a line's end. A reader that has gone away is no error: it has seen what it wanted.
pub fn say(text: &str) -> Result<()> {
    match writeln!(io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error).into_diagnostic(),
        _ => Ok(()),
    }
}

/// Says on stderr what a scene allows but may not mean.
pub fn warn(scene: &Scene) {
    for warning in scene.warnings() {
        eprintln!("Warning: {}: {warning}", scene.name);
    }
}
