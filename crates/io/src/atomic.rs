//! Files that appear whole or not at all.
//!
//! In: a path and a function that writes the content. Out: the file. Holds: content goes to a temporary file of the
//! same folder that is renamed when complete, so a failure leaves the old file, and no other, behind.

use crate::error::IoError;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a file atomically.
///
/// # Input      the path, its folder must exist; a function that writes the content
/// # Output     the file, with the permissions of the file it replaces or those of any new file; links are followed
/// # Errors     `NoFolder`, `WriteDenied` (also for a file marked read-only), `IsDirectory`, `Unwritable`
/// # Guarantees the old file survives every failure, and no temporary file is left; devices and pipes are not replaced
pub fn write_atomically(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), IoError> {
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    write_through(&target, content).map_err(|e| IoError::writing(path, e))
}

fn write_through(target: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let old = match fs::metadata(target) {
        Ok(old) if old.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
        Ok(old) if !old.is_file() => return content_of(fs::OpenOptions::new().write(true).open(target)?, content),
        Ok(old) if old.permissions().readonly() => return Err(io::ErrorKind::PermissionDenied.into()),
        Ok(old) => Some(old.permissions()),
        Err(e) if e.kind() == io::ErrorKind::NotFound => None,
        Err(e) => return Err(e),
    };
    let temporary = temporary_in(&folder_of(target), old)?;
    // The handle removes the file when it is dropped on the way out with an error.
    content_of(temporary.as_file(), content)?;
    temporary.as_file().sync_all()?;
    temporary.persist(target).map_err(|e| e.error)?;
    Ok(())
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
}
