//! Files that appear whole or not at all, and several of them together.
//!
//! In: paths and functions that write the content. Out: the files. Holds: content goes to temporary files of the same
//! folders that are renamed when all are complete, so a failure leaves the old files, and no other, behind.

use crate::error::IoError;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Files that are written together: none is changed before the content of all is complete.
#[derive(Debug, Default)]
pub struct Batch {
    staged: Vec<Staged>,
}

#[derive(Debug)]
struct Staged {
    /// As it was asked for, for messages.
    path: PathBuf,
    /// With links followed.
    target: PathBuf,
    content: Content,
}

#[derive(Debug)]
enum Content {
    /// A complete file beside the target; it goes away when dropped.
    Temporary(tempfile::NamedTempFile),
    /// For devices and pipes, which cannot be replaced.
    Bytes(Vec<u8>),
}

impl Batch {
    /// No files.
    pub fn new() -> Self {
        Self::default()
    }

    /// Writes the content of a file beside its place.
    ///
    /// # Input      the path, its folder must exist; a function that writes the content
    /// # Errors     `NoFolder`, `WriteDenied` (also for a file marked read-only), `IsDirectory`, `Unwritable`
    pub fn stage(
        &mut self,
        path: &Path,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), IoError> {
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let content = staged(&target, content).map_err(|e| IoError::writing(path, e))?;
        self.staged.push(Staged { path: path.to_path_buf(), target, content });
        Ok(())
    }

    /// Puts all files in place: first what goes to devices and pipes, which may fail for its content, then the files,
    /// in the order in which they were staged.
    ///
    /// # Output     the files, with the permissions of those they replace or of any new file; links are followed
    /// # Errors     `Unwritable` while nothing was changed yet, `PartlyWritten` names the files that were
    pub fn commit(self) -> Result<(), IoError> {
        let (devices, files): (Vec<_>, Vec<_>) =
            self.staged.into_iter().partition(|s| matches!(s.content, Content::Bytes(_)));
        let mut written = Vec::new();
        for Staged { path, target, content } in devices.into_iter().chain(files) {
            let done = match content {
                Content::Temporary(file) => file.persist(&target).map(|_| ()).map_err(|e| e.error),
                Content::Bytes(bytes) => {
                    fs::OpenOptions::new().write(true).open(&target).and_then(|mut f| f.write_all(&bytes))
                }
            };
            match done {
                Ok(()) => written.push(path),
                Err(e) if written.is_empty() => return Err(IoError::writing(&path, e)),
                Err(source) => return Err(IoError::PartlyWritten { path, source, written }),
            }
        }
        Ok(())
    }
}

/// Writes a file atomically.
///
/// # Input      the path, its folder must exist; a function that writes the content
/// # Output     the file, with the permissions of the file it replaces or those of any new file; links are followed
/// # Errors     `NoFolder`, `WriteDenied` (also for a file marked read-only), `IsDirectory`, `Unwritable`
/// # Guarantees the old file survives every failure, and no temporary file is left; devices are not replaced, and named pipes are refused
pub fn write_atomically(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), IoError> {
    let mut batch = Batch::new();
    batch.stage(path, content)?;
    batch.commit()
}

/// Makes a folder, unless it is there; its parent must be.
///
/// # Errors     `NoFolder`, `WriteDenied`, `Unwritable`
pub fn ensure_folder(path: &Path) -> Result<(), IoError> {
    if path.is_dir() { Ok(()) } else { fs::create_dir(path).map_err(|e| IoError::writing(path, e)) }
}

/// Finds out whether a file can be written, before there is anything to write: a temporary file is made beside it and
/// dropped.
///
/// # Errors     as those of [`write_atomically`]
pub fn check_writable(path: &Path) -> Result<(), IoError> {
    Batch::new().stage(path, |_| Ok(()))
}

fn staged(target: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<Content> {
    let old = match fs::metadata(target) {
        Ok(old) if old.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        Ok(old) if is_named_pipe(target, &old) => {
            return Err(io::Error::other("it is a named pipe, which nobody may ever read; write to a file"));
        }
        Ok(old) if !old.is_file() => {
            let mut bytes = Vec::new();
            content(&mut bytes)?;
            return Ok(Content::Bytes(bytes));
        }
        Ok(old) if old.permissions().readonly() => return Err(io::ErrorKind::PermissionDenied.into()),
        Ok(old) => Some(old.permissions()),
        Err(e) if e.kind() == io::ErrorKind::NotFound => None,
        Err(e) => return Err(e),
    };
    let temporary = temporary_in(&folder_of(target), old)?;
    // The handle removes the file when it is dropped on the way out with an error.
    content_of(temporary.as_file(), content)?;
    temporary.as_file().sync_all()?;
    Ok(Content::Temporary(temporary))
}

/// A pipe with a name of its own: opening it waits until somebody reads. Those of the shell (`>(…)`) have a reader, and
/// are reached through `/dev`.
fn is_named_pipe(target: &Path, metadata: &fs::Metadata) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        metadata.file_type().is_fifo() && !target.starts_with("/dev")
    }
    #[cfg(not(unix))]
    {
        let _ = (target, metadata);
        false
    }
}

fn folder_of(target: &Path) -> PathBuf {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

fn temporary_in(folder: &Path, permissions: Option<fs::Permissions>) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".quadloom-").suffix(".tmp");
    #[cfg(unix)]
    {
        // As for any new file, the user's mask then takes its share.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let temporary = builder.tempfile_in(folder)?;
    if let Some(permissions) = permissions {
        temporary.as_file().set_permissions(permissions)?;
    }
    Ok(temporary)
}

fn content_of(file: impl Write, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, file);
    content(&mut out)?;
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_failure_leaves_the_old_file_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.obj");
        write_atomically(&path, |out| out.write_all(b"old")).unwrap();
        let failed = write_atomically(&path, |out| {
            out.write_all(&[b'n'; 200_000])?;
            Err(io::Error::other("disk full"))
        });
        assert!(matches!(failed, Err(IoError::Unwritable { .. })), "{failed:?}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["out.obj"]);
    }

    #[test]
    fn files_of_a_batch_appear_together() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a.obj", "b.obj"].map(|name| folder.path().join(name));
        let mut batch = Batch::new();
        batch.stage(&a, |out| out.write_all(b"a")).unwrap();
        assert!(batch.stage(&b, |_| Err(io::Error::other("disk full"))).is_err());
        drop(batch);
        assert!(names(folder.path()).is_empty());
        let mut batch = Batch::new();
        batch.stage(&a, |out| out.write_all(b"a")).unwrap();
        batch.stage(&b, |out| out.write_all(b"b")).unwrap();
        assert!(!a.exists() && !b.exists());
        batch.commit().unwrap();
        assert_eq!(names(folder.path()), ["a.obj", "b.obj"]);
    }

    #[test]
    fn a_file_that_cannot_be_put_in_place_names_those_that_were() {
        let folder = tempfile::tempdir().unwrap();
        let [a, b] = ["a.obj", "b.obj"].map(|name| folder.path().join(name));
        let mut batch = Batch::new();
        batch.stage(&a, |out| out.write_all(b"a")).unwrap();
        batch.stage(&b, |out| out.write_all(b"b")).unwrap();
        // Something else took the place meanwhile.
        fs::create_dir(&b).unwrap();
        let message = batch.commit().unwrap_err().to_string();
        assert!(message.contains("b.obj: cannot be written") && message.contains("a.obj"), "{message}");
        assert_eq!(names(folder.path()), ["a.obj", "b.obj"]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_device_leaves_the_files_beside_it_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        let mut batch = Batch::new();
        batch.stage(&path, |out| out.write_all(b"a")).unwrap();
        batch.stage(Path::new("/dev/full"), |out| out.write_all(b"b")).unwrap();
        let message = batch.commit().unwrap_err().to_string();
        assert!(message.contains("/dev/full") && message.contains("nothing was changed"), "{message}");
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn a_panic_leaves_no_temporary_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.obj");
        let run = std::panic::AssertUnwindSafe(|| write_atomically(&path, |_| panic!("in content")));
        assert!(std::panic::catch_unwind(run).is_err());
        assert!(names(folder.path()).is_empty());
    }

    #[test]
    fn missing_folders_folders_and_read_only_files_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let write = |path: &Path| write_atomically(path, |out| out.write_all(b"x"));
        assert!(matches!(write(&folder.path().join("no/out.obj")), Err(IoError::NoFolder { .. })));
        assert!(matches!(write(folder.path()), Err(IoError::IsDirectory { .. })));
        let path = folder.path().join("kept.obj");
        write(&path).unwrap();
        assert!(matches!(write(&path.join("below.obj")), Err(IoError::NoFolder { .. })));
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        assert!(matches!(write(&path), Err(IoError::WriteDenied { .. })));
        assert_eq!(names(folder.path()), ["kept.obj"]);
    }

    #[cfg(unix)]
    #[test]
    fn permissions_links_and_devices_are_respected() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("a"), folder.path().join("b"));
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        write_atomically(&link, |out| out.write_all(b"new")).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
        write_atomically(Path::new("/dev/null"), |out| out.write_all(b"x")).unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
    #[cfg(unix)]
    #[test]
    fn a_named_pipe_is_refused_and_does_not_block() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let refused = write_atomically(&pipe, |out| out.write_all(b"x")).unwrap_err();
        assert!(refused.to_string().contains("named pipe"), "{refused}");
    }
}
