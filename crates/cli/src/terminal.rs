//! Standard output of the command, and its warnings.

use miette::{IntoDiagnostic, Result};
use robhaz_scene::Scene;
use serde_json::Value;
use std::io::{self, Write};
use std::path::Path;
use std::sync::OnceLock;

/// What the command prints.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
#[command(next_help_heading = "Output")]
pub struct Output {
    /// Prints no messages, warnings and progress: errors alone, and documents that were asked for.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Prints the result as one JSON document on standard output in place of texts.
    #[arg(long, global = true)]
    pub json: bool,
    /// Tells on standard error what the command does; -vv also each file and each run. `check`
    /// lists what is right, too, on standard output.
    #[arg(long, short, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// Set once, before the command starts.
static OUTPUT: OnceLock<Output> = OnceLock::new();

impl Output {
    /// Sets what this process prints. Only the first call has an effect.
    pub fn set(self) {
        let _ = OUTPUT.set(self);
    }

    /// What this process prints.
    pub fn get() -> Self {
        OUTPUT.get().copied().unwrap_or_default()
    }
}

/// Prints a message, unless `--quiet` is given, or `--json`, whose document has what it says.
pub fn say(text: &str) -> Result<()> {
    let Output { quiet, json, .. } = Output::get();
    match quiet || json {
        true => Ok(()),
        false => print(text),
    }
}

/// Prints the result of a command: as text, or with `--json` as the document.
pub fn tell(text: &str, document: &Value) -> Result<()> {
    match Output::get().json {
        true => print_json(document),
        false => say(text),
    }
}

/// Prints the document of `--json`; nothing without that flag.
pub fn tell_json(document: impl FnOnce() -> Result<Value>) -> Result<()> {
    match Output::get().json {
        true => print_json(&document()?),
        false => Ok(()),
    }
}

/// Prints what was asked for, also with `--quiet`. A closed pipe is no error: its reader needs no
/// more.
pub fn print(text: &str) -> Result<()> {
    match writeln!(io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error).into_diagnostic(),
        _ => Ok(()),
    }
}

/// Prints a JSON document.
pub fn print_json(document: &Value) -> Result<()> {
    print(&serde_json::to_string_pretty(document).into_diagnostic()?)
}

/// A path in a document.
pub fn shown(path: &Path) -> String {
    path.display().to_string()
}

/// A path as a word of a shell's command line: quoted if need be, and never an option.
pub fn word(path: &Path) -> String {
    let mut text = shown(path);
    if text.starts_with('-') {
        text.insert_str(0, "./");
    }
    let is_plain = |c: char| c.is_alphanumeric() || "/\\._-+=:,@%".contains(c);
    match text.chars().all(is_plain) {
        true => text,
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}

/// Prints a remark on standard error, not with `--quiet`.
pub fn remark(text: &str) {
    if !Output::get().quiet {
        // A closed or full standard error is no reason to stop.
        let _ = writeln!(io::stderr().lock(), "{text}");
    }
}

/// Prints the warnings of a scene on standard error.
pub fn warn(scene: &Scene) {
    let warnings = scene.warnings();
    warnings.iter().for_each(|w| warn_of(&scene.name, w));
}

/// Prints a warning about a scene or log on standard error.
pub fn warn_of(name: &str, warning: &str) {
    remark(&format!("Warning: {name}: {warning}"));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A path that is advised in a command can be copied into a shell.
    #[test]
    fn a_path_is_one_word_of_a_command() {
        for (path, expected) in [
            ("runs/smooth", "runs/smooth"),
            ("-y.toml", "./-y.toml"),
            ("my scene.toml", "'my scene.toml'"),
            ("$HOME", "'$HOME'"),
            ("it's", r"'it'\''s'"),
        ] {
            assert_eq!(word(Path::new(path)), expected);
        }
    }
}
