//! Sends the messages of a live run over the network.

use crate::error::Cause;
use crate::writer::Target;
use rerun::grpc_server::GrpcServerSink;
use rerun::log::LogMsg;
use rerun::sink::{GrpcSink, GrpcSinkConnectionState, LogSink};
use std::sync::Arc;
use std::time::Duration;

/// A viewer that reads nothing for this time is abandoned.
pub(crate) const TIMEOUT: Duration = Duration::from_secs(3);

/// Viewers of a live run.
pub(crate) enum Remote {
    /// One that listens at an address. Sending blocks while it does not read.
    Viewer(GrpcSink),
    /// Those that connect to this process.
    Server(Arc<GrpcServerSink>),
}

impl Target for Remote {
    fn send(&mut self, message: LogMsg) -> Result<(), Cause> {
        match self {
            Self::Viewer(viewer) => match viewer.status() {
                GrpcSinkConnectionState::Disconnected(_) => {
                    return Err("the viewer has closed the connection".into());
                }
                _ => viewer.send(message),
            },
            Self::Server(server) => server.send(message),
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), Cause> {
        match self {
            Self::Viewer(viewer) => viewer.flush_blocking(TIMEOUT)?,
            Self::Server(server) => server.flush_blocking(TIMEOUT)?,
        }
        Ok(())
    }
}
