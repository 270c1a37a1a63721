//! Live runs: a viewer gets all of it, and no viewer delays a run.

#![expect(clippy::expect_used, reason = "a test that cannot go on fails here")]

#[path = "../common/mod.rs"]
mod common;
mod server;

use robhaz_viewer::{RecordingSink, ViewerError};
use server::Server;
use std::net::TcpListener;

fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    listener.local_addr().expect("an address").port()
}

/// A viewer that reads all messages gets all of them: here it is a server that keeps them. 5 s give
/// 626 rows of each series (125 Hz). The run is over only when the viewer has read the last one. A
/// sink takes one run alone.
#[test]
fn everything_arrives_at_a_viewer_that_takes_it() {
    let server = Server::start();
    let address = format!("rerun+http://{}/proxy", server.address);
    let mut sink = RecordingSink::connect(&address).expect("the server");
    robhaz_run::run(&common::smooth(5.0), &mut [&mut sink]).expect("a run");
    for wheel in 1..=3 {
        let entity = format!("/series/normal_force/wheel{wheel}/actual");
        assert_eq!(server.rows(&entity), 626, "{entity}");
    }
    assert!(server.has_layout());
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

/// A viewer that closes the connection during a run does not end the run: the sink says that the
/// viewer did not get all of it.
#[test]
fn a_viewer_that_goes_away_does_not_end_a_run() {
    let viewer = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = viewer.local_addr().expect("an address").to_string();
    // The first connection only tests whether someone listens.
    let closes = std::thread::spawn(move || {
        let _ = viewer.accept().expect("a test");
        let (stream, _) = viewer.accept().expect("a connection");
        drop(stream);
    });
    let mut sink = RecordingSink::connect(&address).expect("a listener");
    robhaz_run::run(&common::smooth(5.0), &mut [&mut sink]).expect("a run");
    closes.join().expect("it has closed the connection");
    let (_, why) = sink.lost().expect("it is gone");
    assert_eq!(why, "it has closed the connection");
}

/// An address without a viewer, and a text that is not an address, are errors that name the text.
#[test]
fn an_address_without_a_viewer_is_an_error() {
    let address = format!("127.0.0.1:{}", free_port());
    let error = RecordingSink::connect(&address)
        .err()
        .expect("no viewer listens");
    assert!(
        matches!(error, ViewerError::NoViewerListens { .. }),
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
