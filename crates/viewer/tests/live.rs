//! Live runs: a viewer gets all of it, and no viewer delays a run.

#![expect(clippy::expect_used, reason = "a test that cannot go on fails here")]

mod common;

use rerun::grpc_server::GrpcServerSink;
use robhaz_viewer::{RecordingSink, ViewerError};
use std::net::{TcpListener, TcpStream};
use std::time::Duration;

fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    listener.local_addr().expect("an address").port()
}

/// A viewer that reads all messages gets all of them. Here it is a server that keeps them. A sink
/// takes one run alone.
#[test]
fn everything_arrives_at_a_viewer_that_takes_it() {
    let port = free_port();
    let _server = GrpcServerSink::new("127.0.0.1", port, Default::default()).expect("a server");
    // It starts to listen in another thread.
    while TcpStream::connect(("127.0.0.1", port)).is_err() {
        std::thread::sleep(Duration::from_millis(10));
    }
    let mut sink = RecordingSink::connect(&format!("127.0.0.1:{port}")).expect("the server");
    robhaz_run::run(&common::smooth(5.0), &mut [&mut sink]).expect("a run");
    assert_eq!(sink.lost(), None);
    let error = robhaz_run::run(&common::smooth(0.1), &mut [&mut sink]).expect_err("a second run");
    assert!(error.to_string().contains("already holds a run"), "{error}");
}

/// With a viewer that accepts a connection and never answers, the run ends normally, and says so.
#[test]
fn a_stalled_viewer_does_not_hold_up_a_run() {
    let stalled = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = stalled.local_addr().expect("an address").to_string();
    let mut sink = RecordingSink::connect(&address).expect("a listener");
    robhaz_run::run(&common::smooth(5.0), &mut [&mut sink]).expect("a run");
    let (lost, why) = sink.lost().expect("it reads nothing");
    assert!(lost.contains(&address), "{lost}");
    assert_eq!(why, "it takes no more data");
}

/// An address without a viewer, and a text that is not an address, are errors that name the text.
#[test]
fn an_address_without_a_viewer_is_an_error() {
    let address = format!("127.0.0.1:{}", free_port());
    let error = RecordingSink::connect(&address)
        .err()
        .expect("no viewer listens");
    assert!(
        matches!(error, ViewerError::NobodyListens { .. }),
        "{error}"
    );
    assert!(error.to_string().contains(&address), "{error}");
    for bad in [
        "",
        "no port",
        "http://127.0.0.1:1/else",
        "127.0.0.1:99999999",
    ] {
        let error = RecordingSink::connect(bad).err().expect("no address");
        assert!(
            matches!(error, ViewerError::Address { .. }),
            "{bad}: {error}"
        );
    }
}
