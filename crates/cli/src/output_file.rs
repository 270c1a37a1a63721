//! A result file that the user names. It appears only when it is complete, and replaces another
//! file only with `--force`.

use crate::interrupt;
use miette::{IntoDiagnostic, Report, Result, WrapErr, bail, miette};
use std::io;
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// Content of a file, in the plural for messages, and its extension without the dot.
pub type Format = (&'static str, &'static str);

/// A file being written under a temporary name in the same folder. Dropped before
/// [`OutputFile::finish`], it leaves nothing.
pub struct OutputFile {
    target: PathBuf,
    temporary: TempPath,
    force: bool,
}

impl OutputFile {
    /// Prepares a file. `inputs` are files that the command reads: they are never replaced, not
    /// even with `force`. From now on the first signal does not end the process, which would leave
    /// the temporary file: work that takes long has to ask `interrupt`.
    pub fn create(target: &Path, format: Format, inputs: &[PathBuf], force: bool) -> Result<Self> {
        let (path, (what, extension)) = (target.display(), format);
        if !target
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case(extension))
        {
            bail!("{path} does not end in .{extension}, the only format of {what}");
        }
        // A missing file is not the same file.
        let same = |input: &&PathBuf| same_file::is_same_file(target, input).unwrap_or(false);
        if let Some(input) = inputs.iter().find(same) {
            bail!(
                help = "write to another file; --force does not help here",
                "{path} is the same file as {}, which is read: it is left alone",
                input.display()
            );
        }
        if target.is_dir() {
            bail!("{path} is a folder: the name of a file is needed");
        }
        // A broken link counts as a file.
        if target.symlink_metadata().is_ok() && !force {
            return Err(exists(target));
        }
        if let Some(folder) = target.parent().filter(|p| !p.as_os_str().is_empty())
            && !folder.is_dir()
        {
            bail!(
                help = "create it first",
                "cannot write {path}: there is no folder {}",
                folder.display()
            );
        }
        interrupt::listen()?;
        Ok(Self {
            target: target.to_path_buf(),
            temporary: io_error("cannot write", target, temporary(target, extension))?,
            force,
        })
    }

    /// The temporary file to write into.
    pub fn path(&self) -> &Path {
        &self.temporary
    }

    /// Writes its whole content.
    pub fn write(&self, content: &str) -> Result<()> {
        let written = std::fs::write(&self.temporary, content);
        io_error("cannot write", &self.target, written)
    }

    /// Gives the complete file its name, unless a signal came. Without `force`, a file that was
    /// created meanwhile is not replaced.
    pub fn finish(self) -> Result<PathBuf> {
        if let Some(cause) = interrupt::cause() {
            bail!("stopped by {cause}");
        }
        let named = if self.force {
            self.temporary.persist(&self.target)
        } else {
            self.temporary.persist_noclobber(&self.target)
        };
        match named.map_err(|error| error.error) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(exists(&self.target)),
            named => io_error("cannot write", &self.target, named).map(|()| self.target),
        }
    }
}

/// Adds what failed, and the path.
pub fn io_error<T>(action: &str, path: &Path, done: io::Result<T>) -> Result<T> {
    done.into_diagnostic()
        .wrap_err_with(|| format!("{action} {}", path.display()))
}

fn exists(path: &Path) -> Report {
    miette!(help = "--force replaces it", "{} exists", path.display())
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
