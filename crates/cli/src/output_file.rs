//! A result file that the user names. It appears only when it is complete, and replaces another file only with
//! `--force`.

use std::io;
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// Why a file cannot be written where the user wants it.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum OutputFileError {
    /// The name has the extension of another format.
    #[error("{path} does not end in .{extension}, the only format of {what}")]
    Format {
        /// The file.
        path: PathBuf,
        /// Its content, in the plural.
        what: &'static str,
        /// The allowed extension.
        extension: &'static str,
    },
    /// The command reads this same file, perhaps under another name or through a link.
    #[error("{path} is the same file as {input}, which is read: it is left alone")]
    #[diagnostic(help("write to another file; --force does not help here"))]
    Input {
        /// The file to be written.
        path: PathBuf,
        /// The file to be read.
        input: PathBuf,
    },
    /// The file exists already.
    #[error("{0} exists")]
    #[diagnostic(help("--force replaces it"))]
    Exists(PathBuf),
    /// The path is a folder.
    #[error("{0} is a folder: the name of a file is needed")]
    Folder(PathBuf),
    /// An error of the file system.
    #[error("cannot write {path}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
}

/// Content and extension of a file.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// In the plural, for messages.
    pub what: &'static str,
    /// Without the dot.
    pub extension: &'static str,
}

/// A file being written under a temporary name in the same folder. Dropped before [`OutputFile::finish`], it leaves
/// nothing.
pub struct OutputFile {
    target: PathBuf,
    temporary: TempPath,
    force: bool,
}

impl OutputFile {
    /// Prepares a file. `inputs` are files that the command reads: they are never replaced, not even with `force`.
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
        // A missing file is not the same file.
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
        // A broken link counts as a file.
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

    /// The temporary file to write into.
    pub fn path(&self) -> &Path {
        &self.temporary
    }

    /// Gives the complete file its name. Without `force`, a file that was created meanwhile is not replaced.
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

/// A new file in the folder of `target`, with the usual permissions.
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
        // The process's umask removes some of them.
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    Ok(builder.tempfile_in(folder)?.into_temp_path())
}
