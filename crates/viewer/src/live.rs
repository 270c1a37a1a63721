//! A run in a viewer while it is simulated.
//!
//! The simulation sends copies of its records to a second thread through a bounded queue. If the queue is full, because
//! the viewer does not read or is slower than the run, records are dropped and counted. The simulation does not wait.

use crate::ViewerError;
use crate::events::Found;
use crate::layout::Playing;
use crate::program::{DEFAULT_PORT, Started, listens};
use crate::recorder::{Due, Recorder, Sampler};
use crate::remote::{TIMEOUT, ToServer, ToViewer};
use crate::writer::Target;
use rerun::external::re_uri::ProxyUri;
use rerun::grpc_server::GrpcServerSink;
use rerun::sink::GrpcSink;
use robhaz_estimator::{Estimate, EstimateError, SensorFrame};
use robhaz_model::WheelCommand;
use robhaz_run::{ClearanceNeed, FeltGround, Frame, RunDescription, RunEnd, Sink, SinkError};
use robhaz_sim::Truth;
use std::ffi::OsStr;
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::str::FromStr as _;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender, TrySendError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

/// Capacity of the queue, records: ten simulated seconds, about ten megabytes.
const QUEUE: usize = 2000;
/// Largest number of events that wait for a place in the queue.
const MOST_EVENTS: usize = 1000;
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
    link: Option<Link>,
    /// Serves viewers until the sink is dropped, also after the run.
    server: Option<Arc<GrpcServerSink>>,
    feed: Option<Feed>,
    report: LiveReport,
}

/// The connection of a sink before the run begins.
enum Link {
    Viewer(ProxyUri),
    Server(Arc<GrpcServerSink>),
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
        Ok(Self::new(full, Link::Viewer(uri), None))
    }

    /// A sink for the viewer that listens at the default port of this machine, or else for a new one. The viewer stays
    /// open after the run.
    ///
    /// # Errors
    /// [`ViewerError::NotInstalled`], [`ViewerError::OtherVersion`], [`ViewerError::Start`],
    /// [`ViewerError::NobodyListens`]
    pub fn spawn() -> Result<Self, ViewerError> {
        Self::spawn_at(DEFAULT_PORT, &[])
    }

    /// As [`LiveSink::spawn`], with a port and further arguments for the viewer.
    ///
    /// # Errors
    /// As [`LiveSink::spawn`].
    pub fn spawn_at(port: u16, arguments: &[&str]) -> Result<Self, ViewerError> {
        if !listens(port) {
            let mut all = vec![OsStr::new("--expect-data-soon")];
            all.extend(arguments.iter().map(OsStr::new));
            Started::at(port, &all)?;
        }
        Self::connect(&format!("127.0.0.1:{port}"))
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
        Ok(Self::new(uri, Link::Server(server.clone()), Some(server)))
    }

    fn new(address: String, link: Link, server: Option<Arc<GrpcServerSink>>) -> Self {
        Self {
            address,
            link: Some(link),
            server,
            feed: None,
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
        let link = self.link.take().ok_or_else(|| ViewerError::Used {
            destination: self.address.clone(),
        })?;
        self.feed = Some(Feed::start(self.address.clone(), link, run)?);
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        let feed = self.feed.as_mut().ok_or_else(|| ViewerError::NotBegun {
            destination: self.address.clone(),
        })?;
        feed.frame(frame);
        Ok(())
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        if let Some(feed) = self.feed.take() {
            self.report = feed.end(end);
        }
        Ok(())
    }
}

/// A record in the queue.
struct Item {
    time: f64,
    truth: Option<Truth>,
    sensors: SensorFrame,
    estimates: Vec<Result<Estimate, EstimateError>>,
    commands: Option<[WheelCommand; 3]>,
    due: Due,
    found: Found,
}

/// Data of both threads.
#[derive(Default)]
struct Shared {
    /// Number of records that were sent to the viewer.
    delivered: AtomicU64,
    /// Events at the end of the run, for which the queue may have no place.
    finale: Mutex<Found>,
}

/// The simulation's end of the queue.
struct Feed {
    sampler: Sampler,
    /// Events that are not in the queue yet.
    pending: Found,
    /// `None`: the other end is closed.
    queue: Option<SyncSender<Item>>,
    done: Receiver<()>,
    shared: Arc<Shared>,
    offered: u64,
}

impl Feed {
    fn start(address: String, link: Link, run: &RunDescription) -> Result<Self, ViewerError> {
        let (queue, items) = mpsc::sync_channel(QUEUE);
        let (sender, done) = mpsc::sync_channel(1);
        let shared = Arc::new(Shared::default());
        let (run_there, shared_there) = (run.clone(), shared.clone());
        std::thread::Builder::new()
            .name("viewer".to_owned())
            .spawn(move || {
                // An error needs no report of its own: the records that were not delivered are counted.
                let _ = show(&address, link, &run_there, &items, &shared_there);
                let _ = sender.send(());
            })
            .map_err(ViewerError::Thread)?;
        Ok(Self {
            sampler: Sampler::new(run, 1.0),
            pending: Found::default(),
            queue: Some(queue),
            done,
            shared,
            offered: 0,
        })
    }

    fn frame(&mut self, frame: &Frame<'_>) {
        let Some(due) = self.sampler.select(frame) else {
            return;
        };
        self.offered += 1;
        let found = self.sampler.take();
        let Some(queue) = &self.queue else {
            return;
        };
        self.pending.append(found);
        let item = Item {
            time: frame.time,
            truth: frame.truth.copied(),
            sensors: *frame.sensors,
            estimates: frame.estimates.to_vec(),
            commands: frame.commands,
            due,
            found: std::mem::take(&mut self.pending),
        };
        match queue.try_send(item) {
            Ok(()) => {}
            // The record is lost. Its events wait for the next record.
            Err(TrySendError::Full(item)) if item.found.events.len() < MOST_EVENTS => {
                self.pending = item.found;
            }
            Err(TrySendError::Full(_)) => {}
            Err(TrySendError::Disconnected(_)) => self.queue = None,
        }
    }

    fn end(mut self, end: Option<&RunEnd>) -> LiveReport {
        self.pending.append(self.sampler.end(end));
        let pending = std::mem::take(&mut self.pending);
        *self
            .shared
            .finale
            .lock()
            .unwrap_or_else(PoisonError::into_inner) = pending;
        self.queue = None;
        let ended = self.wait();
        let delivered = self.shared.delivered.load(Ordering::Relaxed);
        LiveReport {
            offered: self.offered,
            dropped: self.offered - delivered.min(self.offered),
            lost: !ended,
        }
    }

    /// Waits while the viewer reads. Returns whether it has read everything. If not, its thread is abandoned, because
    /// it cannot be interrupted.
    fn wait(&self) -> bool {
        let mut before = self.shared.delivered.load(Ordering::Relaxed);
        loop {
            match self.done.recv_timeout(TIMEOUT) {
                Ok(()) => return true,
                Err(RecvTimeoutError::Disconnected) => return false,
                Err(RecvTimeoutError::Timeout) => {
                    let now = self.shared.delivered.load(Ordering::Relaxed);
                    if now == before {
                        return false;
                    }
                    before = now;
                }
            }
        }
    }
}

/// Sends the records of the queue to the viewer, until the queue or the connection is closed.
fn show(
    address: &str,
    link: Link,
    run: &RunDescription,
    items: &Receiver<Item>,
    shared: &Shared,
) -> Result<(), ViewerError> {
    let target: Box<dyn Target> = match link {
        Link::Viewer(uri) => Box::new(ToViewer(GrpcSink::new(uri))),
        Link::Server(server) => Box::new(ToServer(server)),
    };
    let mut recorder = Recorder::begin(address, target, run, now(), Playing::AtTheEnd, 1.0)?;
    let mut found = Found::default();
    let (mut waiting, mut batch_end) = (0, Instant::now() + BATCH_TIME);
    loop {
        let rest = batch_end.saturating_duration_since(Instant::now());
        let closed = match items.recv_timeout(rest) {
            Ok(item) => {
                let frame = Frame {
                    clearances: None,
                    time: item.time,
                    truth: item.truth.as_ref(),
                    sensors: &item.sensors,
                    estimates: &item.estimates,
                    commands: item.commands,
                    // The queue has the ground among what was found.
                    ground: FeltGround::default(),
                };
                recorder.push(&frame, item.due);
                found.append(item.found);
                waiting += 1;
                false
            }
            Err(RecvTimeoutError::Timeout) => false,
            Err(RecvTimeoutError::Disconnected) => true,
        };
        if closed {
            let mut finale = shared.finale.lock().unwrap_or_else(PoisonError::into_inner);
            found.append(std::mem::take(&mut finale));
        }
        let full = waiting >= BATCH || Instant::now() >= batch_end;
        if closed || (full && (waiting > 0 || !found.is_empty())) {
            recorder.flush(std::mem::take(&mut found))?;
            if closed {
                break;
            }
            shared.delivered.fetch_add(waiting, Ordering::Relaxed);
            waiting = 0;
        }
        if full {
            batch_end = Instant::now() + BATCH_TIME;
        }
    }
    recorder.finish()?;
    shared.delivered.fetch_add(waiting, Ordering::Relaxed);
    Ok(())
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
