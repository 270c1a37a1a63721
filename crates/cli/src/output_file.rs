//! A file that a user names for a result: complete or not there, and never in place of another unasked.

use std::io;
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// Why a file cannot be written where the user wants it.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum OutputFileError {
    /// The name promises a format that is not written.
    #[error("{path} does not end in .{extension}, the only format of {what}")]
    Format {
        /// The file.
        path: PathBuf,
        /// What it would hold.
        what: &'static str,
        /// The name's end that is allowed.
        extension: &'static str,
    },
    /// The command reads this very file, be it under another name or by a link.
    #[error("{path} is the same file as {input}, which is read: it is left alone")]
    #[diagnostic(help("write to another file; --force does not help here"))]
    Input {
        /// The file to be written.
        path: PathBuf,
        /// The file to be read.
        input: PathBuf,
    },
    /// Something is there already.
    #[error("{0} exists")]
    #[diagnostic(help("--force replaces it"))]
    Exists(PathBuf),
    /// A folder is there.
    #[error("{0} is a folder: the name of a file is needed")]
    Folder(PathBuf),
    /// The file system says no.
    #[error("cannot write {path}")]
    Io {
        /// The file.
        path: PathBuf,
        /// What came back.
        source: io::Error,
    },
}

/// What a file is to hold, and the end of its name.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// In the plural, for messages.
    pub what: &'static str,
    /// Without the dot.
    pub extension: &'static str,
}

/// A file being written under a temporary name beside its own. Dropped before [`OutputFile::finish`], it leaves nothing.
pub struct OutputFile {
    target: PathBuf,
    temporary: TempPath,
    force: bool,
}

impl OutputFile {
    /// Prepares a file. `inputs` are files that the command reads: none of them is replaced, not even when asked (`force`).
    pub fn create(
        target: &Path,
        format: Format,
        inputs: &[PathBuf],
        force: bool,
    ) -> Result<Self, OutputFileError> {
        let path = || target.to_path_buf();
        let Format { what, extension } = format;
        if !target
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case(extension))
        {
            let path = path();
            return Err(OutputFileError::Format {
                path,
                what,
                extension,
            });
        }
        // A file that is not there is not the same.
        let same = |input: &&PathBuf| same_file::is_same_file(target, input).unwrap_or(false);
        if let Some(input) = inputs.iter().find(same) {
            return Err(OutputFileError::Input {
                path: path(),
                input: input.clone(),
            });
        }
        if target.is_dir() {
            return Err(OutputFileError::Folder(path()));
        }
        // A link to nowhere counts.
        if target.symlink_metadata().is_ok() && !force {
            return Err(OutputFileError::Exists(path()));
        }
        let temporary = temporary(target, extension).map_err(|source| OutputFileError::Io {
            path: path(),
            source,
        })?;
        Ok(Self {
            target: path(),
            temporary,
            force,
        })
    }

    /// Where to write.
    pub fn path(&self) -> &Path {
        &self.temporary
    }

    /// Gives the complete file its name. One that has come there since is not replaced unasked.
    pub fn finish(self) -> Result<PathBuf, OutputFileError> {
        let named = if self.force {
            self.temporary.persist(&self.target)
        } else {
            self.temporary.persist_noclobber(&self.target)
        };
        match named {
            Ok(()) => Ok(self.target),
            Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => {
                Err(OutputFileError::Exists(self.target))
            }
            Err(error) => Err(OutputFileError::Io {
                path: self.target,
                source: error.error,
            }),
        }
    }
}

/// A new file in the folder of `target`, with the permissions of any file.
fn temporary(target: &Path, extension: &str) -> io::Result<TempPath> {
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let suffix = format!(".{extension}");
    let mut builder = tempfile::Builder::new();
    builder.prefix(".robhaz-").suffix(&suffix);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        // Less what the user's mask takes away.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    Ok(builder.tempfile_in(folder)?.into_temp_path())
}
