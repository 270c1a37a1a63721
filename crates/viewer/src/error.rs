//! What can go wrong between a run and the eyes of a user.

use std::path::{Path, PathBuf};

/// A cause from below.
pub(crate) type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Version of the Rerun viewer that shows what this crate writes.
pub const VIEWER_VERSION: &str = "0.36.3";

/// Why a run cannot be recorded, streamed, opened or pictured.
#[derive(Debug, thiserror::Error)]
pub enum ViewerError {
    /// The file cannot be created.
    #[error("cannot create the recording {}", path.display())]
    Create {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Data cannot be encoded or written; what was written before stays readable.
    #[error("cannot write the recording {destination}")]
    Write {
        /// Which file or address.
        destination: String,
        /// What the encoder or the system says.
        source: Cause,
    },
    /// A recording cannot be read.
    #[error("cannot read the recording {}", path.display())]
    Read {
        /// Which file.
        path: PathBuf,
        /// What the decoder or the system says.
        source: Cause,
    },
    /// A record came before the run began.
    #[error("the recording {destination} was given a record before its run began")]
    NotBegun {
        /// Which file or address.
        destination: String,
    },
    /// A second run was given to the same recording.
    #[error("the recording {destination} already holds a run")]
    Used {
        /// Which file or address.
        destination: String,
    },
    /// A thread cannot be started.
    #[error("cannot start a thread for the viewer")]
    Thread(#[source] std::io::Error),
    /// An address that no viewer can have.
    #[error(
        "{address:?} is not the address of a viewer: allowed are HOST:PORT and rerun+http://HOST:PORT/proxy"
    )]
    Address {
        /// What was given.
        address: String,
    },
    /// Nobody listens at the address.
    #[error(
        "no viewer listens at {address}: start one with `rerun --bind 127.0.0.1`, or let `--rerun spawn` start it"
    )]
    NobodyListens {
        /// Where.
        address: String,
    },
    /// The port is taken.
    #[error("cannot serve at {address}")]
    Serve {
        /// Where.
        address: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// No viewer is installed.
    #[error(
        "no Rerun viewer is installed (`rerun` is not on the PATH): pip install rerun-sdk=={VIEWER_VERSION}"
    )]
    NotInstalled,
    /// The installed viewer may not understand the recording.
    #[error(
        "the installed Rerun viewer is {found}, recordings are made for {VIEWER_VERSION}: pip install rerun-sdk=={VIEWER_VERSION}"
    )]
    OtherVersion {
        /// What `rerun --version` says.
        found: String,
    },
    /// The viewer cannot be started, or has ended at once.
    #[error("the Rerun viewer does not start: {reason}")]
    Start {
        /// What the system or the viewer's last words say.
        reason: String,
    },
    /// The viewer answers, but not as it should.
    #[error("the viewer does not answer the request for {request}")]
    Control {
        /// Which request.
        request: &'static str,
        /// What came back.
        source: Cause,
    },
    /// The picture does not show the run.
    #[error("the viewer's picture does not show the data: {reason}")]
    Picture {
        /// What is missing.
        reason: String,
    },
    /// A comparison would be written over one of its recordings.
    #[error("{} is a recording to be compared: the comparison needs a file of its own", path.display())]
    Input {
        /// Which file.
        path: PathBuf,
    },
    /// A time outside the recording.
    #[error("{at} s is not in the run: its recording goes from 0 s to {end:.3} s")]
    Time {
        /// What was asked for, s.
        at: f64,
        /// Time of the newest row, s.
        end: f64,
    },
    /// The caller ended the work.
    #[error("stopped by {cause}")]
    Stopped {
        /// What [`robhaz_run::Stop`] answered.
        cause: &'static str,
    },
    /// A comparison needs at least two runs.
    #[error("a comparison needs at least two runs, not {found}")]
    TooFew {
        /// How many were given.
        found: usize,
    },
}

impl ViewerError {
    /// Turns a cause into [`ViewerError::Write`] for a file or address.
    pub(crate) fn write<E: Into<Cause>>(destination: &str) -> impl FnOnce(E) -> Self {
        move |cause| Self::Write {
            destination: destination.to_owned(),
            source: cause.into(),
        }
    }

    /// Turns a cause into [`ViewerError::Read`] for a file.
    pub(crate) fn read<E: Into<Cause>>(path: &Path) -> impl FnOnce(E) -> Self {
        move |cause| Self::Read {
            path: path.to_owned(),
            source: cause.into(),
        }
    }
}
