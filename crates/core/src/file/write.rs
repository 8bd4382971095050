//! Files that are written whole or not at all.

use std::ffi::OsString;
use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::Path;

use crate::error::Error;

/// Writes a file under a name of its own beside `path`, then renames it, so that it is complete or not there.
///
/// A file that is there keeps its permissions, and one that may not be written stays as it is. A link keeps pointing where it
/// does. What is no regular file (a device, a pipe) is written to as it is.
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
            // Renaming asks for no leave to write the file; and who may do anything has none where nobody has.
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
