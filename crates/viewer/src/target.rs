//! Where the messages of a recording go: a file or a viewer, each with a thread of its own.
//!
//! Rerun's SDK has such targets, too, in `re_sdk`: they block the run when a viewer reads nothing,
//! keep the cause of a failed write to themselves, and bring 55 crates.

use crate::error::{Cause, Result, ViewerError};
use re_build_info::CrateVersion;
use re_log_encoding::rrd::Compression;
use re_log_encoding::{Encoder, EncodingOptions, ToTransport as _};
use re_log_types::LogMsg;
use re_protos::sdk_comms::v1alpha1::WriteMessagesRequest;
use re_protos::sdk_comms::v1alpha1::message_proxy_service_client::MessageProxyServiceClient;
use std::fs::File;
use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::path::Path;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::runtime::Builder;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, channel, unbounded_channel};
use tokio_stream::wrappers::ReceiverStream;
use tonic::transport::Endpoint;

/// Time after which a viewer that reads nothing is given up.
const PATIENCE: Duration = Duration::from_secs(3);
/// Number of encoded messages that wait for a viewer.
const MOST_ENCODED: usize = 100;

/// A file or viewer. Its thread encodes and writes messages while the next are collected, so that
/// the run does not wait for it. What waits is at most the recording, whose size does not grow with
/// the length of the run.
pub(crate) struct Target {
    /// `None` after the last message.
    messages: Option<UnboundedSender<LogMsg>>,
    /// `None` when its result is known.
    thread: Option<JoinHandle<Result<(), Cause>>>,
    /// A message for each that a viewer has taken; `None` of a file.
    taken: Option<mpsc::Receiver<()>>,
}

impl Target {
    /// A new `.rrd` file. An older file of that name is replaced immediately.
    pub(crate) fn create(path: &Path) -> Result<Self> {
        let file = File::create(path).map_err(ViewerError::io("create", path.display()))?;
        let options = EncodingOptions::PROTOBUF_COMPRESSED;
        let encoder = Encoder::new_eager(CrateVersion::LOCAL, options, file);
        let mut encoder = encoder.map_err(ViewerError::io("write", path.display()))?;
        Self::start(None, move |mut messages| {
            while let Some(message) = messages.blocking_recv() {
                encoder.append(&message)?;
            }
            // The index.
            Ok(encoder.finish()?)
        })
    }

    /// The viewer that listens at `HOST:PORT` or `rerun+http://HOST:PORT/proxy`, and its address
    /// without what surrounds it.
    pub(crate) fn connect(address: &str) -> Result<(Self, String)> {
        let plain = address.strip_prefix("rerun+http://");
        let plain = plain.map_or(address, |p| p.strip_suffix("/proxy").unwrap_or(p));
        let bad = |_| ViewerError::Address(address.to_owned());
        let mut found = plain.to_socket_addrs().map_err(bad)?;
        // The client waits for a viewer without limit: test first whether one listens.
        let second = Duration::from_secs(1);
        let answers = |a: &SocketAddr| TcpStream::connect_timeout(a, second).is_ok();
        let Some(listening) = found.find(answers) else {
            return Err(ViewerError::NoViewerListens(plain.to_owned()));
        };
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(ViewerError::Thread)?;
        let (done, taken) = mpsc::channel();
        let viewer = Self::start(Some(taken), move |messages| {
            let stream = runtime.block_on(stream(listening, messages, &done));
            stream.map_err(|_| closed())
        })?;
        Ok((viewer, plain.to_owned()))
    }

    fn start(
        taken: Option<mpsc::Receiver<()>>,
        work: impl FnOnce(UnboundedReceiver<LogMsg>) -> Result<(), Cause> + Send + 'static,
    ) -> Result<Self> {
        let (messages, waiting) = unbounded_channel();
        let builder = std::thread::Builder::new().name("recording".to_owned());
        let thread = builder.spawn(|| work(waiting));
        Ok(Self {
            messages: Some(messages),
            thread: Some(thread.map_err(ViewerError::Thread)?),
            taken,
        })
    }

    /// Whether it is a viewer.
    pub(crate) fn is_live(&self) -> bool {
        self.taken.is_some()
    }

    /// Leaves a message to the thread. Fails with the error of an earlier one.
    pub(crate) fn send(&mut self, message: LogMsg) -> Result<(), Cause> {
        let send = |messages: &UnboundedSender<LogMsg>| messages.send(message).is_ok();
        match self.messages.as_ref().is_some_and(send) {
            true => Ok(()),
            // The thread receives until it fails, or until a viewer has answered too early.
            false => self.finish().and(Err(closed())),
        }
    }

    /// Waits until all messages are written, or read by the viewer. A viewer that reads nothing is
    /// abandoned with its thread, which cannot be interrupted.
    pub(crate) fn finish(&mut self) -> Result<(), Cause> {
        self.messages = None;
        let Some(thread) = self.thread.take() else {
            return Err("the recording has ended".into());
        };
        if let Some(taken) = &self.taken {
            let mut taken = std::iter::repeat_with(|| taken.recv_timeout(PATIENCE));
            if taken.find_map(Result::err) == Some(RecvTimeoutError::Timeout) {
                return Err("it takes no more data".into());
            }
        }
        let done = thread.join();
        done.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

impl Drop for Target {
    /// A recording that is given up keeps the messages that it has got.
    fn drop(&mut self) {
        // A drop cannot report an error.
        let _ = self.finish();
    }
}

fn closed() -> Cause {
    "it has closed the connection".into()
}

/// The one call of a live run: a stream of messages, which the viewer answers once, at its end.
async fn stream(
    viewer: SocketAddr,
    mut messages: UnboundedReceiver<LogMsg>,
    done: &mpsc::Sender<()>,
) -> Result<(), Cause> {
    let viewer = Endpoint::from_shared(format!("http://{viewer}"))?;
    let mut client = MessageProxyServiceClient::new(viewer.connect().await?);
    let (requests, waiting) = channel(MOST_ENCODED);
    let call =
        tokio::spawn(async move { client.write_messages(ReceiverStream::new(waiting)).await });
    while let Some(message) = messages.recv().await {
        let log_msg = Some(message.to_transport(Compression::LZ4)?.into());
        requests.send(WriteMessagesRequest { log_msg }).await?;
        // No one waits for it once the recording has been given up.
        let _ = done.send(());
    }
    drop(requests);
    call.await??;
    Ok(())
}
