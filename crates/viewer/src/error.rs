//! Errors of recording, streaming, showing and picturing a run.

use std::fmt::Display;

/// An error of a library or of the system.
pub(crate) type Cause = Box<dyn std::error::Error + Send + Sync>;

/// What a function of this crate returns: nothing, where no other type is stated.
pub(crate) type Result<T = (), E = ViewerError> = std::result::Result<T, E>;

/// Version of the Rerun viewer for which this crate writes recordings.
pub const VIEWER_VERSION: &str = "0.36.3";

/// The command that installs it.
pub const INSTALL: &str = "pip install rerun-sdk==0.36.3";

/// Why a run cannot be recorded, streamed, shown or pictured.
#[derive(Debug, thiserror::Error)]
pub enum ViewerError {
    /// A file or viewer cannot be created, written or read. Data written before stay readable.
    #[error("cannot {action} {what}")]
    Io {
        /// The action that failed.
        action: &'static str,
        /// File or address.
        what: String,
        /// The library's or the system's error.
        source: Cause,
    },
    /// A sink, for this file or address, was used for a second run.
    #[error("the recording {0} already holds a run")]
    Used(String),
    /// A thread cannot be started.
    #[error("cannot start a thread for the viewer")]
    Thread(#[source] std::io::Error),
    /// Not the address of a viewer.
    #[error(
        "{0:?} is not the address of a viewer: allowed are HOST:PORT and rerun+http://HOST:PORT/proxy"
    )]
    Address(String),
    /// No program listens at this address.
    #[error(
        "no viewer listens at {0}: start one with `rerun --bind 127.0.0.1`, or let `--rerun live` start it"
    )]
    NoViewerListens(String),
    /// No viewer is on the PATH.
    #[error("no Rerun viewer is installed (`rerun` is not on the PATH): {INSTALL}")]
    NotInstalled,
    /// The installed viewer has another minor version, which `rerun --version` prints, and may not
    /// read the recording.
    #[error("the installed Rerun viewer is {0}, but recordings need {VIEWER_VERSION}: {INSTALL}")]
    OtherVersion(String),
    /// The viewer cannot be started, or exits with an error: the system's or the viewer's words.
    #[error("the Rerun viewer does not start: {0}")]
    Start(String),
    /// A request to the viewer fails.
    #[error("the viewer does not answer the request for {request}")]
    Control {
        /// The requested object.
        request: &'static str,
        /// The connection's or the viewer's error.
        source: Cause,
    },
    /// The picture does not show the run: what it lacks.
    #[error("the viewer's picture does not show the data: {0}")]
    Picture(String),
    /// A time outside the recording.
    #[error("{at} s is not in the run: its recording goes from 0 s to {end:.3} s")]
    Time {
        /// The requested time, s.
        at: f64,
        /// Time of the newest row, s.
        end: f64,
    },
    /// The caller stopped the work, for the cause that [`robhaz_run::Stop`] returned.
    #[error("stopped by {0}")]
    Stopped(&'static str),
}

impl ViewerError {
    /// Turns a cause into [`ViewerError::Io`].
    pub(crate) fn io<E: Into<Cause>>(
        action: &'static str,
        what: impl Display,
    ) -> impl FnOnce(E) -> Self {
        let what = what.to_string();
        move |cause| Self::Io {
            action,
            what,
            source: cause.into(),
        }
    }
}
