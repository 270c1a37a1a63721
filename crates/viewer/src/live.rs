//! A run in a viewer while it is simulated.
//!
//! A second thread sends the messages to the viewer. If too many wait for it, because the viewer does not read or is slower
//! than the run, records are dropped and counted. The simulation does not wait.

use crate::ViewerError;
use crate::layout::Playing;
use crate::program::{DEFAULT_PORT, Started, listens};
use crate::recorder::{Destination, Recorder};
use crate::remote::{Remote, TIMEOUT};
use crate::writer::Stalled;
use rerun::external::re_uri::ProxyUri;
use rerun::grpc_server::GrpcServerSink;
use rerun::sink::GrpcSink;
use robhaz_run::{ClearanceNeed, Frame, RunDescription, RunEnd, Sink, SinkError};
use std::ffi::OsStr;
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::str::FromStr as _;
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

/// Wall-clock time of the records of one batch.
const BATCH_TIME: Duration = Duration::from_millis(50);
/// Largest number of records in a batch.
const BATCH: u64 = 500;

/// Delivery of a live run to the viewer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LiveReport {
    /// Number of records for the viewer.
    pub offered: u64,
    /// Number of records that it did not get, because it was too slow, did not read, or closed the connection.
    pub dropped: u64,
    /// The viewer closed the connection, or stopped reading, before the end.
    pub lost: bool,
}

/// Shows a run in a viewer while it is simulated. Records for which the viewer is too slow are dropped and counted. A
/// viewer that closes the connection does not stop the run.
pub struct LiveSink {
    address: String,
    /// Until the run begins.
    link: Option<Remote>,
    /// Serves viewers until the sink is dropped, also after the run.
    server: Option<Arc<GrpcServerSink>>,
    /// `None` before and after the run.
    recorder: Option<Recorder>,
    /// Whether the viewer has closed the connection.
    is_closed: bool,
    /// Records of the next batch, and the time at which it is sent.
    kept: u64,
    batch_end: Instant,
    report: LiveReport,
}

impl LiveSink {
    /// A sink for the viewer that listens at an address: `HOST:PORT` or `rerun+http://HOST:PORT/proxy`.
    ///
    /// # Errors
    /// [`ViewerError::Address`], [`ViewerError::NobodyListens`]
    pub fn connect(address: &str) -> Result<Self, ViewerError> {
        let bad = || ViewerError::Address {
            address: address.to_owned(),
        };
        let full = if address.contains("://") {
            address.to_owned()
        } else {
            format!("rerun+http://{address}/proxy")
        };
        let uri = ProxyUri::from_str(&full).map_err(|_| bad())?;
        // The client of the SDK waits for a viewer without limit: test first whether one listens.
        let host = uri.origin.host.to_string();
        let found: Vec<SocketAddr> = (host.as_str(), uri.origin.port)
            .to_socket_addrs()
            .map_err(|_| bad())?
            .collect();
        let second = Duration::from_secs(1);
        let answers = |a: &SocketAddr| TcpStream::connect_timeout(a, second).is_ok();
        if !found.iter().any(answers) {
            return Err(ViewerError::NobodyListens { address: full });
        }
        Ok(Self::new(full, Remote::Viewer(GrpcSink::new(uri)), None))
    }

    /// A sink for the viewer that listens at the default port of this machine, or else for a new one. The viewer stays
    /// open after the run.
    ///
    /// # Errors
    /// [`ViewerError::NotInstalled`], [`ViewerError::OtherVersion`], [`ViewerError::Start`],
    /// [`ViewerError::NobodyListens`]
    pub fn spawn() -> Result<Self, ViewerError> {
        if !listens(DEFAULT_PORT) {
            Started::at(DEFAULT_PORT, &[OsStr::new("--expect-data-soon")])?;
        }
        Self::connect(&format!("127.0.0.1:{DEFAULT_PORT}"))
    }

    /// A sink to which viewers can connect at a port of this machine. Viewers that connect later get all messages from
    /// the start, of which up to a gigabyte is kept.
    ///
    /// # Errors
    /// [`ViewerError::Serve`]: the port is in use.
    pub fn serve(port: u16) -> Result<Self, ViewerError> {
        const HOST: &str = "127.0.0.1";
        let address = format!("{HOST}:{port}");
        let fail = |source| ViewerError::Serve {
            address: address.clone(),
            source,
        };
        // The server itself would only print that the port is in use.
        drop(TcpListener::bind(&address).map_err(fail)?);
        let server = GrpcServerSink::new(HOST, port, Default::default()).map_err(|_| {
            ViewerError::Address {
                address: address.clone(),
            }
        })?;
        // The server starts to listen in another thread.
        let deadline = Instant::now() + TIMEOUT;
        while !listens(port) {
            if Instant::now() > deadline {
                return Err(fail(std::io::ErrorKind::TimedOut.into()));
            }
            std::thread::sleep(BATCH_TIME);
        }
        let server = Arc::new(server);
        let uri = server.uri().to_string();
        let link = Remote::Server(server.clone());
        Ok(Self::new(uri, link, Some(server)))
    }

    fn new(address: String, link: Remote, server: Option<Arc<GrpcServerSink>>) -> Self {
        Self {
            address,
            link: Some(link),
            server,
            recorder: None,
            is_closed: false,
            kept: 0,
            batch_end: Instant::now(),
            report: LiveReport::default(),
        }
    }

    /// The address of the viewer, or the address to which viewers can connect.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Whether viewers can connect to the sink, also after the run.
    pub fn is_serving(&self) -> bool {
        self.server.is_some()
    }

    /// The delivery of the run to the viewer, valid after the run.
    pub fn report(&self) -> LiveReport {
        self.report
    }
}

impl Sink for LiveSink {
    fn clearance_need(&self) -> ClearanceNeed {
        ClearanceNeed::AtChanges
    }

    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        let name = self.address.clone();
        let target = self.link.take().ok_or_else(|| ViewerError::Used {
            destination: name.clone(),
        })?;
        let to = Destination {
            name,
            target,
            patience: TIMEOUT,
            playing: Playing::AtTheEnd,
            salt: now(),
        };
        self.recorder = Some(Recorder::begin(to, run, 1.0)?);
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        let recorder = self
            .recorder
            .as_mut()
            .ok_or_else(|| ViewerError::NotBegun {
                destination: self.address.clone(),
            })?;
        let has_room = !self.is_closed && recorder.out.has_room();
        let is_kept = recorder.push(frame, has_room);
        self.report.offered += u64::from(is_kept);
        self.kept += u64::from(is_kept && has_room);
        if has_room && (self.kept >= BATCH || Instant::now() >= self.batch_end) {
            self.batch_end = Instant::now() + BATCH_TIME;
            recorder.flush()?;
            // The error needs no report of its own: the records that were not delivered are counted.
            self.is_closed = recorder.out.send(std::mem::take(&mut self.kept)).is_err();
        }
        Ok(())
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        if let Some(mut recorder) = self.recorder.take() {
            recorder.end(end)?;
            let finished = recorder.out.finish(self.kept);
            self.report.dropped = self.report.offered - recorder.out.delivered();
            self.report.lost = matches!(finished, Err(ViewerError::Write { source, .. }) if source.is::<Stalled>());
        }
        Ok(())
    }
}

/// Wall-clock time, ns. It distinguishes two runs of the same scene in one viewer.
fn now() -> u64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the lower digits distinguish two runs"
    )]
    since.map_or(0, |time| time.as_nanos() as u64)
}
