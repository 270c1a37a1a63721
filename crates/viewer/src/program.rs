//! The installed Rerun viewer: found, checked, started.

use crate::{VIEWER_VERSION, ViewerError};
use robhaz_run::Stop;
use std::fs::File;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Port on which viewers listen by default.
pub(crate) const DEFAULT_PORT: u16 = 9876;
/// How long a viewer may take to start, s.
const START_TIME: Duration = Duration::from_secs(30);
/// Between two looks at whether it has.
const POLL_TIME: Duration = Duration::from_millis(50);
/// Lines of a viewer's last output that an error quotes.
const MOST_LINES: usize = 5;

/// Shows recordings on the screen, until the user closes the viewer or `stop` names a cause.
///
/// # Errors
/// [`ViewerError`]: no viewer, another version, it ends with an error, or [`ViewerError::Stopped`].
pub fn open(recordings: &[PathBuf], stop: Stop<'_>) -> Result<(), ViewerError> {
    let mut command = installed()?;
    command.args(["--bind", "127.0.0.1", "--port", "auto"]);
    command.args(recordings);
    let log = Log::new()?;
    command.stderr(log.stdio()?);
    in_a_group_of_its_own(&mut command);
    let child = command.spawn().map_err(|e| start_error(&e.to_string()))?;
    let mut viewer = Started { child, log };
    loop {
        let ended = viewer.child.try_wait();
        match ended.map_err(|e| start_error(&e.to_string()))? {
            Some(status) if status.success() => return Ok(()),
            Some(_) => return Err(start_error(&viewer.log.last_words())),
            None => {}
        }
        if let Some(cause) = stop() {
            viewer.end();
            return Err(ViewerError::Stopped { cause });
        }
        std::thread::sleep(POLL_TIME);
    }
}

/// Is somebody listening at the port?
pub(crate) fn listens(port: u16) -> bool {
    let address = SocketAddr::V4(SocketAddrV4::new(Ipv4Addr::LOCALHOST, port));
    TcpStream::connect_timeout(&address, Duration::from_secs(1)).is_ok()
}

/// A port that nobody listens at.
pub(crate) fn free_port() -> Result<u16, ViewerError> {
    let address = SocketAddrV4::new(Ipv4Addr::LOCALHOST, 0);
    let port = TcpListener::bind(address).and_then(|l| l.local_addr());
    port.map(|a| a.port()).map_err(|source| ViewerError::Serve {
        address: address.to_string(),
        source,
    })
}

/// A viewer that was started and listens at a port.
pub(crate) struct Started {
    child: Child,
    log: Log,
}

impl Started {
    /// Starts the installed viewer with some arguments and waits until it listens. The viewer outlives this process unless it
    /// is told to end.
    pub(crate) fn at(port: u16, arguments: &[&std::ffi::OsStr]) -> Result<Self, ViewerError> {
        let mut command = installed()?;
        command.args(["--bind", "127.0.0.1", "--port", &port.to_string()]);
        command.args(arguments);
        // Its output must not hold this process's own open, or a pipe to it never ends.
        let log = Log::new()?;
        command.stderr(log.stdio()?);
        in_a_group_of_its_own(&mut command);
        let child = command.spawn().map_err(|e| start_error(&e.to_string()))?;
        let mut started = Self { child, log };
        let deadline = Instant::now() + START_TIME;
        while !listens(port) {
            if let Some(words) = started.last_words() {
                return Err(start_error(&words));
            }
            if Instant::now() > deadline {
                started.end();
                let waited = START_TIME.as_secs();
                return Err(start_error(&format!("it does not listen after {waited} s")));
            }
            std::thread::sleep(POLL_TIME);
        }
        Ok(started)
    }

    /// What the viewer said before it ended. `None` while it runs.
    pub(crate) fn last_words(&mut self) -> Option<String> {
        let ended = matches!(self.child.try_wait(), Ok(Some(_)));
        ended.then(|| self.log.last_words())
    }

    /// Ends the viewer.
    pub(crate) fn end(&mut self) {
        // `rerun` as pip installs it is a script around the viewer: both are to end. Failing means that they have ended.
        #[cfg(unix)]
        let _ = Command::new("kill")
            .args(["-KILL", "--", &format!("-{}", self.child.id())])
            .stderr(Stdio::null())
            .status();
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The viewer on the PATH, silent but for warnings, checked to be of the right version.
fn installed() -> Result<Command, ViewerError> {
    let path = find().ok_or(ViewerError::NotInstalled)?;
    let output = Command::new(&path)
        .arg("--version")
        .stdin(Stdio::null())
        .output()
        .map_err(|e| start_error(&e.to_string()))?;
    let said = String::from_utf8_lossy(&output.stdout);
    // As in "rerun-cli 0.36.3 [rustc ...".
    let found = said.split_whitespace().nth(1).unwrap_or("of no version");
    if minor(found) != minor(VIEWER_VERSION) {
        return Err(ViewerError::OtherVersion {
            found: found.to_owned(),
        });
    }
    let mut command = Command::new(path);
    command.stdin(Stdio::null()).stdout(Stdio::null());
    command.env("NO_COLOR", "1");
    if std::env::var_os("RUST_LOG").is_none() {
        command.env("RUST_LOG", "warn");
    }
    Ok(command)
}

/// Files and protocol are the same within a minor version.
fn minor(version: &str) -> Option<(&str, &str)> {
    let mut parts = version.split('.');
    Some((parts.next()?, parts.next()?))
}

fn find() -> Option<PathBuf> {
    let name = format!("rerun{}", std::env::consts::EXE_SUFFIX);
    let paths = std::env::var_os("PATH")?;
    std::env::split_paths(&paths)
        .map(|folder| folder.join(&name))
        .find(|path| is_executable(path))
}

#[cfg(unix)]
fn is_executable(path: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt as _;
    path.metadata()
        .is_ok_and(|m| m.is_file() && m.permissions().mode() & 0o111 != 0)
}

#[cfg(not(unix))]
fn is_executable(path: &Path) -> bool {
    path.is_file()
}

/// Ctrl-C in the terminal is meant for the simulation, and what the viewer starts can be ended with it.
fn in_a_group_of_its_own(command: &mut Command) {
    #[cfg(unix)]
    {
        use std::os::unix::process::CommandExt as _;
        command.process_group(0);
    }
    #[cfg(not(unix))]
    let _ = command;
}

pub(crate) fn start_error(reason: &str) -> ViewerError {
    ViewerError::Start {
        reason: reason.trim().to_owned(),
    }
}

/// A file for what a viewer says, gone when it is no longer needed.
struct Log {
    path: PathBuf,
    file: File,
}

impl Log {
    fn new() -> Result<Self, ViewerError> {
        let port = free_port()?;
        let name = format!("robhaz-viewer-{}-{port}.log", std::process::id());
        let path = std::env::temp_dir().join(name);
        let file = File::create(&path).map_err(|source| ViewerError::Create {
            path: path.clone(),
            source,
        })?;
        Ok(Self { path, file })
    }

    fn stdio(&self) -> Result<Stdio, ViewerError> {
        let copy = self.file.try_clone();
        copy.map(Stdio::from)
            .map_err(|e| start_error(&e.to_string()))
    }

    /// The cause is said before the stack and after the warnings.
    fn last_words(&self) -> String {
        let said = std::fs::read(&self.path).unwrap_or_default();
        let said = String::from_utf8_lossy(&said);
        let lines = said.lines().map(str::trim);
        let words: Vec<&str> = lines
            .take_while(|line| !line.starts_with("stack backtrace"))
            .filter(|line| !line.is_empty() && !line.contains(" WARN "))
            .take(MOST_LINES)
            .collect();
        if words.is_empty() {
            "it ended without a word".to_owned()
        } else {
            words.join(" ")
        }
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_agree_up_to_the_minor_one() {
        assert_eq!(minor("0.36.1"), minor(VIEWER_VERSION));
        assert_ne!(minor("0.37.0"), minor(VIEWER_VERSION));
        assert_ne!(minor("nonsense"), minor(VIEWER_VERSION));
    }
}
