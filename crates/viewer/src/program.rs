//! Finds the installed Rerun viewer, checks its version and starts it.

use crate::error::{Result, VIEWER_VERSION, ViewerError};
use robhaz_run::Stop;
use std::ffi::OsStr;
use std::io::ErrorKind;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::NamedTempFile;

/// The viewer, on the PATH.
const PROGRAM: &str = "rerun";
/// Port at which viewers listen by default.
pub(crate) const DEFAULT_PORT: u16 = 9876;
/// Longest time until a viewer listens.
const START_TIME: Duration = Duration::from_secs(30);
/// Time between two checks of a viewer.
const POLL_TIME: Duration = Duration::from_millis(50);
/// Number of lines of a viewer's output that an error quotes.
const MOST_LINES: usize = 5;

/// Shows recordings on the screen. Returns when the user closes the viewer.
///
/// # Errors
/// - [`ViewerError::NotInstalled`], [`ViewerError::OtherVersion`]: no viewer of the right version.
/// - [`ViewerError::Start`]: the viewer does not start, or exits with an error.
/// - [`ViewerError::Io`]: the file for the viewer's output cannot be created.
/// - [`ViewerError::Stopped`]: `stop` named a cause. The viewer is closed.
pub fn open(recordings: &[PathBuf], stop: Stop<'_>) -> Result {
    let mut viewer = Started::with("auto", recordings)?;
    loop {
        let ended = viewer.child.try_wait();
        match ended.map_err(start_error)? {
            Some(status) if status.success() => return Ok(()),
            Some(_) => return Err(start_error(exit_message(viewer.log.path()))),
            None => {}
        }
        if let Some(cause) = stop() {
            viewer.end();
            return Err(ViewerError::Stopped(cause));
        }
        std::thread::sleep(POLL_TIME);
    }
}

/// Whether a program listens at a port of this machine.
pub(crate) fn listens(port: u16) -> bool {
    let address = SocketAddr::V4(SocketAddrV4::new(Ipv4Addr::LOCALHOST, port));
    TcpStream::connect_timeout(&address, Duration::from_secs(1)).is_ok()
}

/// A port of this machine at which no program listens.
pub(crate) fn free_port() -> Result<u16> {
    let address = SocketAddrV4::new(Ipv4Addr::LOCALHOST, 0);
    let port = TcpListener::bind(address).and_then(|l| l.local_addr());
    let cannot = |error| start_error(format!("no port of {address} is free: {error}"));
    port.map(|a| a.port()).map_err(cannot)
}

/// A viewer that this process started.
pub(crate) struct Started {
    child: Child,
    /// Its output.
    log: NamedTempFile,
}

impl Started {
    fn with(port: &str, arguments: &[impl AsRef<OsStr>]) -> Result<Self> {
        let mut command = installed()?;
        command.args(["--bind", "127.0.0.1", "--port", port]);
        command.args(arguments);
        // A viewer that inherits this process's output would keep a pipe open after this process
        // has ended.
        let log = NamedTempFile::new()
            .map_err(ViewerError::io("create", std::env::temp_dir().display()))?;
        command.stderr(log.reopen().map_err(start_error)?);
        // Ctrl-C in the terminal then reaches the simulation alone, and `end` reaches all processes
        // that the viewer started.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let child = command.spawn().map_err(start_error)?;
        Ok(Self { child, log })
    }

    /// Starts the installed viewer with further arguments and waits until it listens at `port`. The
    /// viewer outlives this process, unless [`Started::end`] is called.
    pub(crate) fn at(port: u16, arguments: &[&OsStr]) -> Result<Self> {
        let mut started = Self::with(&port.to_string(), arguments)?;
        let deadline = Instant::now() + START_TIME;
        while !listens(port) {
            if let Some(message) = started.exit_message() {
                return Err(start_error(message));
            }
            if Instant::now() > deadline {
                started.end();
                let waited = START_TIME.as_secs();
                return Err(start_error(format!("it does not listen after {waited} s")));
            }
            std::thread::sleep(POLL_TIME);
        }
        Ok(started)
    }

    /// The output of a viewer that has exited. `None` while it runs.
    pub(crate) fn exit_message(&mut self) -> Option<String> {
        let ended = matches!(self.child.try_wait(), Ok(Some(_)));
        ended.then(|| exit_message(self.log.path()))
    }

    /// Kills the viewer.
    pub(crate) fn end(&mut self) {
        // Pip installs `rerun` as a script that starts the viewer: the whole group is killed.
        // Errors are ignored, because they mean that the processes have exited.
        #[cfg(unix)]
        let _ = Command::new("kill")
            .args(["-KILL", "--", &format!("-{}", self.child.id())])
            .stderr(Stdio::null())
            .status();
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Whether a program with the viewer's name is on the PATH. Its version is not checked: that takes
/// as long as to start it.
pub fn is_installed() -> bool {
    let name = format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX);
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(&name).is_file())
}

/// A command for the viewer on the PATH, whose version is checked. It prints warnings and errors
/// alone.
fn installed() -> Result<Command> {
    let mut version = Command::new(PROGRAM);
    let output = version.arg("--version").stdin(Stdio::null()).output();
    let output = output.map_err(|error| match error.kind() {
        ErrorKind::NotFound => ViewerError::NotInstalled,
        _ => start_error(error),
    })?;
    let output = String::from_utf8_lossy(&output.stdout);
    // For example "rerun-cli 0.36.3 [rustc ...".
    let found = output.split_whitespace().nth(1);
    let found = found.unwrap_or("of an unknown version");
    if minor(found) != minor(VIEWER_VERSION) {
        return Err(ViewerError::OtherVersion(found.to_owned()));
    }
    let mut command = Command::new(PROGRAM);
    command.stdin(Stdio::null()).stdout(Stdio::null());
    command.env("NO_COLOR", "1");
    if std::env::var_os("RUST_LOG").is_none() {
        command.env("RUST_LOG", "warn");
    }
    Ok(command)
}

/// Major and minor version. The file format and the protocol are the same within a minor version.
fn minor(version: &str) -> Option<(&str, &str)> {
    let mut parts = version.split('.');
    Some((parts.next()?, parts.next()?))
}

/// [`ViewerError::Start`] with a reason.
pub(crate) fn start_error(reason: impl ToString) -> ViewerError {
    ViewerError::Start(reason.to_string().trim().to_owned())
}

/// The first lines of the output, without warnings and stack trace: they state why the viewer
/// exited.
fn exit_message(log: &Path) -> String {
    let output = std::fs::read(log).unwrap_or_default();
    let output = String::from_utf8_lossy(&output);
    let lines = output.lines().map(str::trim);
    let first: Vec<&str> = lines
        .take_while(|line| !line.starts_with("stack backtrace"))
        .filter(|line| !line.is_empty() && !line.contains(" WARN "))
        .take(MOST_LINES)
        .collect();
    match first.is_empty() {
        true => "it exited without a message".to_owned(),
        false => first.join(" "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The command that installs the viewer names its version.
    #[test]
    fn the_installed_version_is_the_one_of_recordings() {
        assert!(crate::INSTALL.ends_with(&format!("=={VIEWER_VERSION}")));
    }

    /// Only the major and the minor version count.
    #[test]
    fn versions_agree_up_to_the_minor_one() {
        assert_eq!(minor("0.36.1"), minor(VIEWER_VERSION));
        assert_ne!(minor("0.37.0"), minor(VIEWER_VERSION));
        assert_ne!(minor("nonsense"), minor(VIEWER_VERSION));
    }
}
