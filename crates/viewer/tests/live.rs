//! Live runs: a viewer gets all records, and no viewer delays a run.

#![expect(clippy::expect_used, reason = "a test that cannot go on fails here")]

mod common;

use robhaz_viewer::{LiveSink, ViewerError};
use std::net::TcpListener;

/// Records of 5 s: 626 rows at 125 Hz and 301 frames at 60 Hz, of which 51 are both.
const RECORDS_IN_5_S: u64 = 626 + 301 - 51;

fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    listener.local_addr().expect("an address").port()
}

/// Conservation: a viewer that reads all messages gets all records. The viewer is a second sink, which serves them on.
#[test]
fn everything_arrives_at_a_viewer_that_takes_it() {
    let port = free_port();
    let server = LiveSink::serve(port).expect("a server");
    assert!(server.is_serving());
    let mut sink = LiveSink::connect(&format!("127.0.0.1:{port}")).expect("the server");
    assert!(!sink.is_serving());
    robhaz_run::run(&common::smooth(5.0), &mut [&mut sink]).expect("a run");
    let report = sink.report();
    assert_eq!(report.offered, RECORDS_IN_5_S);
    assert_eq!((report.dropped, report.lost), (0, false));
}

/// A sink serves a run without any viewer. Its port is in use until the sink is dropped, and it takes one run alone.
#[test]
fn a_run_can_be_served() {
    let port = free_port();
    let mut sink = LiveSink::serve(port).expect("a server");
    robhaz_run::run(&common::smooth(0.5), &mut [&mut sink]).expect("a run");
    assert_eq!(sink.report().dropped, 0);
    let error = LiveSink::serve(port).err().expect("the port is taken");
    assert!(matches!(error, ViewerError::Serve { .. }), "{error}");
    assert!(error.to_string().contains(&port.to_string()), "{error}");
    let error = robhaz_run::run(&common::smooth(0.1), &mut [&mut sink]).expect_err("a second run");
    assert!(error.to_string().contains("already holds a run"), "{error}");
}

/// With a viewer that accepts a connection and never answers, the run ends normally. All records are counted as
/// dropped.
#[test]
fn a_stalled_viewer_does_not_hold_up_a_run() {
    let stalled = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = stalled.local_addr().expect("an address").to_string();
    let mut sink = LiveSink::connect(&address).expect("a listener");
    robhaz_run::run(&common::smooth(5.0), &mut [&mut sink]).expect("a run");
    let report = sink.report();
    assert_eq!(report.offered, RECORDS_IN_5_S);
    assert_eq!(report.dropped, RECORDS_IN_5_S);
    assert!(report.lost);
}

/// An address without a viewer, and a text that is not an address, are errors that name the text.
#[test]
fn an_address_without_a_viewer_is_an_error() {
    let address = format!("127.0.0.1:{}", free_port());
    let error = LiveSink::connect(&address)
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
        let error = LiveSink::connect(bad).err().expect("no address");
        assert!(
            matches!(error, ViewerError::Address { .. }),
            "{bad}: {error}"
        );
    }
}
