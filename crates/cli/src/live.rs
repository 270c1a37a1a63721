//! `--rerun`: how a run is recorded for the viewer and shown live.

#[cfg(feature = "viewer")]
use crate::terminal::{remark, say, word};
#[cfg(feature = "viewer")]
use miette::IntoDiagnostic;
use miette::Result;
use robhaz_run::Sink;
#[cfg(feature = "viewer")]
use robhaz_viewer::{INSTALL, RecordingSink};
use std::path::Path;

/// Why there is no viewer, and what helps.
pub const WITHOUT_VIEWER: &str = "it is built without the viewer (--no-default-features); `cargo install --locked --path crates/cli` \
     installs it with the viewer";

/// Values of `--rerun`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Rerun {
    /// No output for the viewer.
    Off,
    /// `run.rrd` in the run's folder.
    Save,
    /// As `Save`, and live in the viewer that listens at an address; without one in the viewer on
    /// this machine, which is started if need be.
    Live(Option<String>),
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
        match (text, text.strip_prefix("live=")) {
            ("off", _) => Ok(Self::Off),
            ("save", _) => Ok(Self::Save),
            ("live", _) => Ok(Self::Live(None)),
            (_, Some(address)) if !address.is_empty() => Ok(Self::Live(Some(address.to_owned()))),
            _ => Err("allowed are off, save, live and live=HOST:PORT".to_owned()),
        }
    }
}

/// The viewer's sinks of a run.
#[cfg(feature = "viewer")]
pub struct Viewing {
    choice: Rerun,
    recording: Option<RecordingSink>,
    live: Option<RecordingSink>,
}

#[cfg(feature = "viewer")]
impl Viewing {
    /// Opens the connection to a viewer where the choice needs one.
    pub fn open(choice: &Rerun) -> Result<Self> {
        let live = match choice {
            Rerun::Off | Rerun::Save => None,
            Rerun::Live(None) => Some(RecordingSink::live()),
            Rerun::Live(Some(address)) => Some(RecordingSink::connect(address)),
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
            let recording = RecordingSink::save(&folder.join("run.rrd"));
            self.recording = Some(recording.into_diagnostic()?);
        }
        Ok(())
    }

    /// The sinks that receive every record.
    pub fn sinks(&mut self) -> impl Iterator<Item = &mut dyn Sink> {
        let both = self.recording.iter_mut().chain(&mut self.live);
        both.map(|sink| sink as &mut dyn Sink)
    }

    /// After the run: reports a viewer that did not get all of it, and how the run in its `folder` is
    /// seen.
    pub fn finish(self, folder: &Path) -> Result<()> {
        if let Some((address, why)) = self.live.as_ref().and_then(|live| live.lost()) {
            remark(&format!(
                "The viewer at {address} did not get all of the run: {why}."
            ));
        }
        match self.recording {
            Some(_) => say(&how_to_see(folder, robhaz_viewer::is_installed())),
            None => Ok(()),
        }
    }
}

/// The command that shows a run, and what it needs.
#[cfg(feature = "viewer")]
fn how_to_see(folder: &Path, is_installed: bool) -> String {
    let command = format!("See it with `robhaz view {}`", word(folder));
    match is_installed {
        true => command,
        false => format!("{command}, after `{INSTALL}`"),
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
    pub fn finish(self, _folder: &Path) -> Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_choice_has_a_name_and_nothing_else_is_taken() {
        let live = |address: Option<&str>| Ok(Rerun::Live(address.map(str::to_owned)));
        assert_eq!(Rerun::parse("off"), Ok(Rerun::Off));
        assert_eq!(Rerun::parse("save"), Ok(Rerun::Save));
        assert_eq!(Rerun::parse("live"), live(None));
        assert_eq!(Rerun::parse("live=host:1"), live(Some("host:1")));
        for bad in ["", "on", "live=", "save=x", "SAVE", "spawn"] {
            let error = Rerun::parse(bad).unwrap_err();
            assert!(error.contains("live=HOST:PORT"), "{bad}: {error}");
        }
        assert!(Rerun::parse(Rerun::DEFAULT).is_ok());
    }

    /// The last line of a run can be copied, with and without a viewer.
    #[test]
    #[cfg(feature = "viewer")]
    fn the_way_to_see_a_run_is_a_command() {
        let folder = Path::new("runs/my run");
        let said = how_to_see(folder, true);
        assert_eq!(said, "See it with `robhaz view 'runs/my run'`");
        let said = how_to_see(folder, false);
        assert!(
            said.ends_with("after `pip install rerun-sdk==0.36.3`"),
            "{said}"
        );
    }
}
