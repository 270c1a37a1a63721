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

/// A viewer that listens at an address. Sending blocks while the viewer does not read.
pub(crate) struct ToViewer(pub(crate) GrpcSink);

impl Target for ToViewer {
    fn send(&mut self, message: LogMsg) -> Result<(), Cause> {
        if let GrpcSinkConnectionState::Disconnected(_) = self.0.status() {
            return Err("the viewer has closed the connection".into());
        }
        self.0.send(message);
        Ok(())
    }

    fn finish(&mut self) -> Result<(), Cause> {
        Ok(self.0.flush_blocking(TIMEOUT)?)
    }
}

/// Viewers that connect to this process.
pub(crate) struct ToServer(pub(crate) Arc<GrpcServerSink>);

impl Target for ToServer {
    fn send(&mut self, message: LogMsg) -> Result<(), Cause> {
        self.0.send(message);
        Ok(())
    }

    fn finish(&mut self) -> Result<(), Cause> {
        Ok(self.0.flush_blocking(TIMEOUT)?)
    }
}
