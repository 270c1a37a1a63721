//! Requests to a running viewer.

use crate::ViewerError;
use crate::error::Cause;
use crate::writer::TIMELINE;
use re_protos::common::v1alpha1::{Timeline, TimelineTime};
use re_protos::sdk_comms::v1alpha1::viewer_control_service_client::ViewerControlServiceClient;
use re_protos::sdk_comms::v1alpha1::{
    GetViewerStateRequest, SaveScreenshotRequest, SetTimeCursorRequest,
};
use std::path::Path;
use std::time::Duration;
use tokio::runtime::{Builder, Runtime};
use tonic::transport::{Channel, Endpoint};

/// Longest time for an answer. Software rendering is slow.
const TIMEOUT: Duration = Duration::from_secs(30);

/// A connection to a viewer.
pub(crate) struct Control {
    runtime: Runtime,
    client: ViewerControlServiceClient<Channel>,
}

impl Control {
    /// Connects to the viewer that listens at a port of this machine.
    ///
    /// # Errors
    /// [`ViewerError::Thread`], [`ViewerError::Control`]
    pub(crate) fn call(port: u16) -> Result<Self, ViewerError> {
        const REQUEST: &str = "a connection";
        let runtime = Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(ViewerError::Thread)?;
        let endpoint = Endpoint::from_shared(format!("http://127.0.0.1:{port}"))
            .map_err(control(REQUEST))?
            .timeout(TIMEOUT);
        let channel = runtime
            .block_on(endpoint.connect())
            .map_err(control(REQUEST))?;
        Ok(Self {
            runtime,
            client: ViewerControlServiceClient::new(channel),
        })
    }

    /// Newest simulated time of any recording in the viewer, s. `None`: the viewer has no recording
    /// yet.
    ///
    /// # Errors
    /// [`ViewerError::Control`]
    pub(crate) fn newest(&mut self) -> Result<Option<f64>, ViewerError> {
        let request = self.client.get_viewer_state(GetViewerStateRequest {});
        let state = self
            .runtime
            .block_on(request)
            .map_err(control("its state"))?
            .into_inner();
        let timelines = state.recordings.iter().flat_map(|r| &r.timelines);
        let ours = timelines.filter(|t| t.timeline.as_ref().is_some_and(|t| t.name == TIMELINE));
        let newest = ours
            .filter_map(|t| t.time_range.as_ref())
            .map(|r| r.end)
            .max();
        // Exact up to a hundred days.
        Ok(newest.map(|ns| ns as f64 * 1e-9))
    }

    /// Moves the cursor to a simulated time (s) and pauses there.
    ///
    /// # Errors
    /// [`ViewerError::Control`]
    pub(crate) fn show(&mut self, time: f64) -> Result<(), ViewerError> {
        // Times of a run.
        let time = (time * 1e9).round() as i64;
        let request = SetTimeCursorRequest {
            store_id: None,
            timeline: Some(Timeline {
                name: TIMELINE.to_owned(),
            }),
            time: Some(TimelineTime { time }),
            play: false,
        };
        let answer = self.client.set_time_cursor(request);
        self.runtime
            .block_on(answer)
            .map_err(control("another time"))?;
        Ok(())
    }

    /// Lets the viewer save a picture of its window (PNG). It answers before the file is complete.
    ///
    /// # Errors
    /// [`ViewerError::Control`]
    pub(crate) fn save_picture(&mut self, path: &Path) -> Result<(), ViewerError> {
        let request = SaveScreenshotRequest {
            view_id: None,
            file_path: path.display().to_string(),
        };
        let answer = self.client.save_screenshot(request);
        self.runtime
            .block_on(answer)
            .map_err(control("a picture"))?;
        Ok(())
    }
}

/// Turns a cause into [`ViewerError::Control`] for a request.
fn control<E: Into<Cause>>(request: &'static str) -> impl FnOnce(E) -> ViewerError {
    move |cause| ViewerError::Control {
        request,
        source: cause.into(),
    }
}
