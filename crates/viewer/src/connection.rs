//! Sends the messages of a live run to a viewer.

use crate::ViewerError;
use crate::error::Cause;
use re_log_encoding::ToTransport as _;
use re_log_encoding::rrd::Compression;
use re_log_types::LogMsg;
use re_protos::sdk_comms::v1alpha1::WriteMessagesRequest;
use re_protos::sdk_comms::v1alpha1::message_proxy_service_client::MessageProxyServiceClient;
use std::net::SocketAddr;
use std::thread::JoinHandle;
use tokio::runtime::Builder;
use tokio::sync::mpsc::{Sender, channel};
use tokio_stream::wrappers::ReceiverStream;
use tonic::transport::Endpoint;

/// Number of messages that wait for the viewer before [`Connection::send`] blocks.
const MOST_WAITING: usize = 100;

/// The one call of a live run: a stream of messages, which the viewer answers once, at its end.
pub(crate) struct Connection {
    /// `None` after the last message.
    messages: Option<Sender<WriteMessagesRequest>>,
    /// The thread that sends them. It ends with the viewer's answer, or with the connection.
    answer: Option<JoinHandle<Result<(), Cause>>>,
}

impl Connection {
    /// Calls the viewer that listens at an address. It does not wait for its answer.
    pub(crate) fn open(address: SocketAddr) -> Result<Self, ViewerError> {
        let (messages, waiting) = channel(MOST_WAITING);
        let call = async move {
            let viewer = Endpoint::from_shared(format!("http://{address}"))?;
            let mut client = MessageProxyServiceClient::new(viewer.connect().await?);
            client.write_messages(ReceiverStream::new(waiting)).await?;
            Ok::<_, Cause>(())
        };
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(ViewerError::Thread)?;
        let builder = std::thread::Builder::new().name("viewer".to_owned());
        let thread = builder.spawn(move || runtime.block_on(call));
        Ok(Self {
            messages: Some(messages),
            answer: Some(thread.map_err(ViewerError::Thread)?),
        })
    }

    /// Sends a message. It blocks while too many wait for the viewer.
    pub(crate) fn send(&self, message: &LogMsg) -> Result<(), Cause> {
        let log_msg = Some(message.to_transport(Compression::LZ4)?.into());
        let request = WriteMessagesRequest { log_msg };
        let send =
            |messages: &Sender<WriteMessagesRequest>| messages.blocking_send(request).is_ok();
        // The thread takes messages until the viewer closes the connection.
        match self.messages.as_ref().is_some_and(send) {
            true => Ok(()),
            false => Err("it has closed the connection".into()),
        }
    }

    /// Ends the stream and waits for the viewer's answer: it has read all of it.
    pub(crate) fn finish(&mut self) -> Result<(), Cause> {
        self.messages = None;
        let answer = self.answer.take().map(JoinHandle::join);
        match answer {
            Some(Ok(Ok(()))) => Ok(()),
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            _ => Err("it has closed the connection".into()),
        }
    }
}
