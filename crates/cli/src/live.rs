//! `--rerun`: how a run is recorded for the viewer and shown live.

#[cfg(feature = "viewer")]
use crate::terminal::{note, remark};
#[cfg(feature = "viewer")]
use miette::IntoDiagnostic;
use miette::Result;
use robhaz_run::Sink;
use std::path::Path;

/// Why there is no viewer, and what helps.
#[cfg(not(feature = "viewer"))]
pub const WITHOUT_VIEWER: &str = "it is built without the viewer; `cargo run --release --features viewer -- ...` builds it in, \
     `cargo install --path crates/cli --profile dist --features viewer` installs it so";

/// Values of `--rerun`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Rerun {
    /// No output for the viewer.
    Off,
    /// `run.rrd` in the run's folder.
    Save,
    /// As `Save`, and live in the viewer on this machine, which is started if necessary.
    Spawn,
    /// As `Save`, and live in a viewer that listens at an address.
    Connect(String),
}

impl Rerun {
    /// The value without the option.
    pub const DEFAULT: &str = if cfg!(feature = "viewer") {
        "save"
    } else {
        "off"
    };

    /// Reads the value of the option.
    pub fn parse(text: &str) -> Result<Self, String> {
        let reason = match text {
            "off" => return Ok(Self::Off),
            "save" => return Ok(Self::Save),
            "spawn" => return Ok(Self::Spawn),
            "connect" => return Ok(Self::Connect("127.0.0.1:9876".to_owned())),
            "serve" => "`rerun --serve-grpc` serves viewers, and --rerun connect sends it the run",
            _ => match text.strip_prefix("connect=") {
                Some(address) if !address.is_empty() => {
                    return Ok(Self::Connect(address.to_owned()));
                }
                _ => {
                    "allowed are off, save, spawn, connect, connect=HOST:PORT and connect=rerun+http://HOST:PORT/proxy"
                }
            },
        };
        Err(reason.to_owned())
    }
}

/// The viewer's sinks of a run.
#[cfg(feature = "viewer")]
pub struct Viewing {
    choice: Rerun,
    recording: Option<robhaz_viewer::RecordingSink>,
    live: Option<robhaz_viewer::RecordingSink>,
}

#[cfg(feature = "viewer")]
impl Viewing {
    /// Opens the connection to a viewer where the choice needs one.
    pub fn open(choice: &Rerun) -> Result<Self> {
        use robhaz_viewer::RecordingSink;
        let live = match choice {
            Rerun::Off | Rerun::Save => None,
            Rerun::Spawn => Some(RecordingSink::spawn()),
            Rerun::Connect(address) => Some(RecordingSink::connect(address)),
        };
        Ok(Self {
            choice: choice.clone(),
            recording: None,
            live: live.transpose().into_diagnostic()?,
        })
    }

    /// Starts the recording in the run's folder, unless that is off.
    pub fn record(&mut self, folder: &Path) -> Result<()> {
        if self.choice != Rerun::Off {
            let recording = robhaz_viewer::RecordingSink::save(&folder.join("run.rrd"));
            self.recording = Some(recording.into_diagnostic()?);
        }
        Ok(())
    }

    /// The sinks that receive every record.
    pub fn sinks(&mut self) -> impl Iterator<Item = &mut dyn Sink> {
        let both = self.recording.iter_mut().chain(&mut self.live);
        both.map(|sink| sink as &mut dyn Sink)
    }

    /// After the run: reports reduced rates, and a viewer that did not get all of it.
    pub fn finish(self) -> Result<()> {
        let rates = self.recording.and_then(|r| r.reduced_rates());
        if let Some([series, frames]) = rates {
            note(&format!(
                "The run is long: run.rrd has only {series:.1} Hz of its time series and {frames:.1} Hz of its animation; \
                 the tables have all records."
            ))?;
        }
        if let Some((address, why)) = self.live.as_ref().and_then(|live| live.lost()) {
            remark(&format!(
                "The viewer at {address} did not get all of the run: {why}."
            ));
        }
        Ok(())
    }
}

/// Without the viewer's libraries there are no sinks.
#[cfg(not(feature = "viewer"))]
pub struct Viewing;

#[cfg(not(feature = "viewer"))]
impl Viewing {
    /// Refuses choices that need the viewer.
    pub fn open(choice: &Rerun) -> Result<Self> {
        match choice {
            Rerun::Off => Ok(Self),
            _ => miette::bail!("this robhaz has no --rerun but off: {WITHOUT_VIEWER}"),
        }
    }

    /// Does nothing.
    pub fn record(&mut self, _folder: &Path) -> Result<()> {
        Ok(())
    }

    /// No sinks.
    pub fn sinks(&mut self) -> impl Iterator<Item = &mut dyn Sink> {
        std::iter::empty()
    }

    /// Does nothing.
    pub fn finish(self) -> Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_choice_has_a_name_and_nothing_else_is_taken() {
        let connect = |address: &str| Ok(Rerun::Connect(address.to_owned()));
        assert_eq!(Rerun::parse("off"), Ok(Rerun::Off));
        assert_eq!(Rerun::parse("save"), Ok(Rerun::Save));
        assert_eq!(Rerun::parse("spawn"), Ok(Rerun::Spawn));
        assert_eq!(Rerun::parse("connect"), connect("127.0.0.1:9876"));
        assert_eq!(Rerun::parse("connect=host:1"), connect("host:1"));
        for bad in ["", "on", "connect=", "save=x", "SAVE"] {
            let error = Rerun::parse(bad).unwrap_err();
            assert!(error.contains("connect=HOST:PORT"), "{bad}: {error}");
        }
        assert!(Rerun::parse(Rerun::DEFAULT).is_ok());
    }
}
