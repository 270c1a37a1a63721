//! Files and folders that are complete or not there.

use crate::error::{StudyError, io_error};
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The name under which a file or folder is written.
pub fn partial(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".partial");
    PathBuf::from(name)
}

/// Writes a small file. It has its name only when all of it is on the disk. Several processes may
/// write the same content.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), StudyError> {
    let mut temporary = partial(path).into_os_string();
    temporary.push(format!("-{}", std::process::id()));
    let temporary = PathBuf::from(temporary);
    let mut file = File::create(&temporary).map_err(io_error("create", &temporary))?;
    file.write_all(content)
        .and_then(|()| file.sync_all())
        .map_err(io_error("write", &temporary))?;
    settle(&temporary, path)
}

/// Gives a complete file or folder its name, and waits until the disk has the name, too.
pub fn settle(temporary: &Path, path: &Path) -> Result<(), StudyError> {
    fs::rename(temporary, path).map_err(io_error("rename", temporary))?;
    sync_parent(path);
    Ok(())
}

/// Waits until the disk has the name of a file or folder. Some file systems cannot; the content is
/// there in any case.
pub fn sync_parent(path: &Path) {
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}
