//! A run shown while it goes on.
//!
//! The simulation hands copies of its records to a thread of its own through a bounded queue. Where that is full, because the
//! viewer stalls or the run is faster than the viewer, records are dropped and counted: the simulation never waits.

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
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use robhaz_sim::Truth;
use std::ffi::OsStr;
use std::net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs};
use std::str::FromStr as _;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender, TrySendError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

/// Records that wait for the viewer at most: ten simulated seconds, some ten megabytes.
const QUEUE: usize = 2000;
/// Events that wait at most.
const MOST_EVENTS: usize = 1000;
/// Wall-clock time over which records are gathered into one batch.
const BATCH_TIME: Duration = Duration::from_millis(50);
/// Records in a batch at most.
const BATCH: u64 = 500;

/// How a live run reached the viewer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LiveReport {
    /// Records that the viewer should have got.
    pub offered: u64,
    /// Records that it did not get, because it was too slow, stalled, or went away.
    pub dropped: u64,
    /// The viewer went away or stalled before the end.
    pub lost: bool,
}

/// Shows a run in a viewer while it goes on. What the viewer cannot take is dropped and counted; a viewer that goes away never
/// stops the run.
pub struct LiveSink {
    address: String,
    link: Option<Link>,
    /// Goes on serving after the run, until the sink is dropped.
    server: Option<Arc<GrpcServerSink>>,
    feed: Option<Feed>,
    report: LiveReport,
}

/// What a sink is connected to before the run begins.
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
        // The client of the SDK waits for ever for a viewer that is not there.
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

    /// A sink for the viewer of this machine: the one that listens at the usual port, or else a new one. The viewer stays when
    /// the run has ended.
    ///
    /// # Errors
    /// [`ViewerError`]: no viewer is installed, or it does not start.
    pub fn spawn() -> Result<Self, ViewerError> {
        Self::spawn_at(DEFAULT_PORT, &[])
    }

    /// As [`LiveSink::spawn`], at a port and with further arguments of the viewer.
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

    /// A sink that viewers can connect to, at a port of this machine; what was sent waits for those that come late (up to a
    /// gigabyte).
    ///
    /// # Errors
    /// [`ViewerError::Serve`] where the port is taken.
    pub fn serve(port: u16) -> Result<Self, ViewerError> {
        const HOST: &str = "127.0.0.1";
        let address = format!("{HOST}:{port}");
        let fail = |source| ViewerError::Serve {
            address: address.clone(),
            source,
        };
        // The server itself would only print that the port is taken.
        drop(TcpListener::bind(&address).map_err(fail)?);
        let server = GrpcServerSink::new(HOST, port, Default::default()).map_err(|_| {
            ViewerError::Address {
                address: address.clone(),
            }
        })?;
        // It listens from a thread of its own.
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

    /// Where the viewer is, or where viewers can connect.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Viewers can still connect after the run, as long as the sink lives.
    pub fn is_serving(&self) -> bool {
        self.server.is_some()
    }

    /// How the run reached the viewer; complete after the run.
    pub fn report(&self) -> LiveReport {
        self.report
    }
}

impl Sink for LiveSink {
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
            self.report = feed.end(end.is_some_and(RunEnd::is_complete));
        }
        Ok(())
    }
}

/// A record on its way to the viewer.
struct Item {
    time: f64,
    truth: Option<Truth>,
    sensors: SensorFrame,
    estimates: Vec<Result<Estimate, EstimateError>>,
    due: Due,
    found: Found,
}

/// What both threads know.
#[derive(Default)]
struct Shared {
    delivered: AtomicU64,
    /// What is found at the very end, where the queue may be full.
    finale: Mutex<Found>,
}

/// The simulation's end of the queue.
struct Feed {
    sampler: Sampler,
    /// Found, and not in the queue yet.
    pending: Found,
    /// `None` when the other end has gone.
    queue: Option<SyncSender<Item>>,
    done: Receiver<()>,
    shared: Arc<Shared>,
    offered: u64,
}

impl Feed {
    fn start(address: String, link: Link, run: &RunDescription) -> Result<Self, ViewerError> {
        let (queue, items) = mpsc::sync_channel(QUEUE);
        let (tell, done) = mpsc::sync_channel(1);
        let shared = Arc::new(Shared::default());
        let (run_there, shared_there) = (run.clone(), shared.clone());
        std::thread::Builder::new()
            .name("viewer".to_owned())
            .spawn(move || {
                // A viewer that goes away is told of by what was not delivered.
                let _ = show(&address, link, &run_there, &items, &shared_there);
                let _ = tell.send(());
            })
            .map_err(ViewerError::Thread)?;
        Ok(Self {
            sampler: Sampler::new(run),
            pending: Found::default(),
            queue: Some(queue),
            done,
            shared,
            offered: 0,
        })
    }

    fn frame(&mut self, frame: &Frame<'_>) {
        let Some(due) = self.sampler.look(frame) else {
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
            due,
            found: std::mem::take(&mut self.pending),
        };
        match queue.try_send(item) {
            Ok(()) => {}
            // The record is lost; what was found waits for the next one, within reason.
            Err(TrySendError::Full(item)) if item.found.events.len() < MOST_EVENTS => {
                self.pending = item.found;
            }
            Err(TrySendError::Full(_)) => {}
            Err(TrySendError::Disconnected(_)) => self.queue = None,
        }
    }

    fn end(mut self, complete: bool) -> LiveReport {
        self.pending.append(self.sampler.end(complete));
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

    /// Waits for the viewer as long as it takes something. Its thread is left alone otherwise: nothing can wake it.
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

/// The viewer's end of the queue, until it is closed or the viewer has gone.
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
    let mut recorder = Recorder::begin(address, target, run, now(), Playing::AtTheEnd)?;
    let mut found = Found::default();
    let (mut waiting, mut batch_end) = (0, Instant::now() + BATCH_TIME);
    loop {
        let rest = batch_end.saturating_duration_since(Instant::now());
        let closed = match items.recv_timeout(rest) {
            Ok(item) => {
                let frame = Frame {
                    time: item.time,
                    truth: item.truth.as_ref(),
                    sensors: &item.sensors,
                    estimates: &item.estimates,
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

/// Two runs of the same scene are two recordings in the same viewer.
fn now() -> u64 {
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
    #[expect(
        clippy::cast_possible_truncation,
        reason = "the lower digits tell two runs apart"
    )]
    since.map_or(0, |time| time.as_nanos() as u64)
}
