//! Ctrl-C and SIGTERM: the first ends a command in order, the second ends it at once.

use miette::{IntoDiagnostic, Result, WrapErr};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};
use std::time::Duration;

/// Signals that end a command, and their names for the user.
const SIGNALS: [(i32, &str); 2] = [(SIGINT, "Ctrl-C"), (SIGTERM, "SIGTERM")];
/// Time between two checks for signals while a command waits.
pub const POLL_TIME: Duration = Duration::from_millis(50);

/// Number of the last signal; 0 before the first.
static SIGNAL: LazyLock<Arc<AtomicUsize>> = LazyLock::new(Arc::default);

/// From now on the first signal is only stored, and the second ends the process at once. Before,
/// the first one ends it.
pub fn listen() -> Result<()> {
    let listening = register().into_diagnostic();
    listening.wrap_err("cannot listen for signals")
}

fn register() -> std::io::Result<()> {
    let second = Arc::new(AtomicBool::new(false));
    for (signal, _) in SIGNALS {
        // In this order: no signal is lost that comes in between, and the flag is not yet set at
        // the first signal.
        let number = usize::try_from(signal).unwrap_or(0);
        flag::register_usize(signal, Arc::clone(&SIGNAL), number)?;
        flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&second))?;
        flag::register(signal, Arc::clone(&second))?;
    }
    // So a write beyond the limit on file sizes is an error, and does not end the process.
    #[cfg(unix)]
    flag::register(signal_hook::consts::SIGXFSZ, Arc::default())?;
    Ok(())
}

/// The name of the last signal; `None` before the first.
pub fn cause() -> Option<&'static str> {
    last().map(|(_, name)| name)
}

/// The exit code of a command that a signal has ended: 128 and the signal's number, as in shells.
pub fn exit_code() -> Option<ExitCode> {
    let (signal, _) = last()?;
    Some(u8::try_from(128 + signal).map_or(ExitCode::FAILURE, ExitCode::from))
}

fn last() -> Option<(i32, &'static str)> {
    let came = SIGNAL.load(Ordering::Relaxed);
    let is_it = |(signal, _): &(i32, &str)| usize::try_from(*signal) == Ok(came);
    SIGNALS.into_iter().find(is_it)
}
