//! A server that stands for a viewer: it keeps what it gets.

use hyper_util::rt::{TokioExecutor, TokioIo};
use hyper_util::server::conn::auto::Builder;
use hyper_util::service::TowerToHyperService;
use re_chunk::Chunk;
use re_log_encoding::{CachingApplicationIdInjector, ToApplication as _};
use re_log_types::{LogMsg, StoreKind};
use re_protos::sdk_comms::v1alpha1::message_proxy_service_server::{
    MessageProxyService, MessageProxyServiceServer,
};
use re_protos::sdk_comms::v1alpha1::{
    ReadMessagesRequest, ReadMessagesResponse, ReadTablesRequest, ReadTablesResponse,
    WriteMessagesRequest, WriteMessagesResponse, WriteTableRequest, WriteTableResponse,
};
use std::net::{SocketAddr, TcpListener};
use std::sync::{Arc, Mutex};
use tonic::{Request, Response, Status, Streaming};

/// Messages, in their order.
type Messages = Arc<Mutex<Vec<LogMsg>>>;

/// The server. It ends with the test.
pub struct Server {
    pub address: SocketAddr,
    messages: Messages,
}

impl Server {
    /// Starts to listen at a port of this machine.
    pub fn start() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let messages = Messages::default();
        let service = MessageProxyServiceServer::new(Proxy(Arc::clone(&messages)));
        std::thread::spawn(move || {
            let mut runtime = tokio::runtime::Builder::new_current_thread();
            let runtime = runtime.enable_all().build().expect("a runtime");
            runtime.block_on(async {
                listener.set_nonblocking(true).expect("a listener");
                let listener = tokio::net::TcpListener::from_std(listener).expect("a listener");
                loop {
                    let (stream, _) = listener.accept().await.expect("a connection");
                    let service = TowerToHyperService::new(service.clone());
                    tokio::spawn(async move {
                        let http = Builder::new(TokioExecutor::new());
                        // A connection that only tests whether someone listens is an error.
                        let _ = http.serve_connection(TokioIo::new(stream), service).await;
                    });
                }
            });
        });
        Self { address, messages }
    }

    /// Rows over time of an entity of the recording so far.
    pub fn rows(&self, entity: &str) -> usize {
        let messages = self.messages.lock().expect("the messages");
        let chunks = messages.iter().filter_map(|message| match message {
            LogMsg::ArrowMsg(store, message) if store.kind() == StoreKind::Recording => {
                Some(Chunk::from_arrow_msg(message).expect("a chunk"))
            }
            _ => None,
        });
        let of_entity = chunks.filter(|c| !c.is_static() && c.entity_path().to_string() == entity);
        of_entity.map(|chunk| chunk.num_rows()).sum()
    }

    /// Whether a layout was made the active one.
    pub fn has_layout(&self) -> bool {
        let messages = self.messages.lock().expect("the messages");
        let activates = |m: &LogMsg| matches!(m, LogMsg::BlueprintActivationCommand(_));
        messages.iter().any(activates)
    }
}

/// The service of a viewer that takes recordings.
struct Proxy(Messages);

#[tonic::async_trait]
impl MessageProxyService for Proxy {
    async fn write_messages(
        &self,
        request: Request<Streaming<WriteMessagesRequest>>,
    ) -> Result<Response<WriteMessagesResponse>, Status> {
        let mut stream = request.into_inner();
        let mut applications = CachingApplicationIdInjector::default();
        while let Some(request) = stream.message().await? {
            let message = request.log_msg.and_then(|m| m.msg).expect("a message");
            let message = message.to_application((&mut applications, None));
            let message = message.expect("a readable message");
            self.0.lock().expect("the messages").push(message);
        }
        Ok(Response::new(WriteMessagesResponse {}))
    }

    type ReadMessagesStream = tokio_stream::Empty<Result<ReadMessagesResponse, Status>>;

    async fn read_messages(
        &self,
        _: Request<ReadMessagesRequest>,
    ) -> Result<Response<Self::ReadMessagesStream>, Status> {
        Err(Status::unimplemented("robhaz reads no messages"))
    }

    async fn write_table(
        &self,
        _: Request<WriteTableRequest>,
    ) -> Result<Response<WriteTableResponse>, Status> {
        Err(Status::unimplemented("robhaz writes no tables"))
    }

    type ReadTablesStream = tokio_stream::Empty<Result<ReadTablesResponse, Status>>;

    async fn read_tables(
        &self,
        _: Request<ReadTablesRequest>,
    ) -> Result<Response<Self::ReadTablesStream>, Status> {
        Err(Status::unimplemented("robhaz reads no tables"))
    }
}
