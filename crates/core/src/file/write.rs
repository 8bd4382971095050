//! Files that are written whole or not at all.

use std::ffi::OsString;
use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::Path;

use crate::error::Error;

/// Writes a file under a name of its own beside `path`, then renames it, so that it is complete or not there.
///
/// An existing file keeps its permissions; one without write permission is not changed. A link still points to the same file. A device
/// or a pipe is written to directly.
///
/// # Errors
///
/// [`Error::Io`] if it cannot be written.
#[doc(hidden)] // for the Python package, which writes pictures
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    write(path, bytes).map_err(|e| Error::io(path, e))
}

fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let (target, permissions) = match fs::metadata(path) {
        Ok(found) if !found.is_file() => return fs::write(path, bytes),
        Ok(found) => {
            // Renaming does not need write permission for the file, so it is checked here; also for the superuser.
            OpenOptions::new().append(true).open(path)?;
            if found.permissions().readonly() {
                return Err(ErrorKind::PermissionDenied.into());
            }
            (fs::canonicalize(path)?, Some(found.permissions()))
        }
        Err(_) if path.is_symlink() => {
            return Err(io::Error::new(
                ErrorKind::NotFound,
                "is a link to a file that is not there",
            ));
        }
        Err(_) => (path.to_path_buf(), None),
    };
    let mut name = OsString::from(".");
    name.push(target.file_name().unwrap_or_default());
    name.push(format!(".{}.tmp", std::process::id()));
    let unfinished = target.with_file_name(name);
    let written = fs::write(&unfinished, bytes)
        .and_then(|()| permissions.map_or(Ok(()), |same| fs::set_permissions(&unfinished, same)))
        .and_then(|()| fs::rename(&unfinished, &target));
    if written.is_err() {
        let _ = fs::remove_file(&unfinished);
    }
    written
}
