//! Files that are read whole.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use crate::error::{Error, quoted};

/// The bytes of a regular file. `kind`: what it should be, such as "scene file". `most`: no more bytes than this and one are read.
///
/// # Errors
///
/// [`Error::Io`] if it cannot be read; [`Error::File`] if it is not a regular file or is empty.
pub(crate) fn read_whole(path: &Path, kind: &str, most: Option<u64>) -> Result<Vec<u8>, Error> {
    let problem = |problem: String| Error::File { path: quoted(path), problem, error: None };
    let io = |e: io::Error| Error::io(path, e);
    let found = fs::metadata(path).map_err(io)?;
    // A file of /proc has no length, and reading it may block.
    if found.is_file() && found.len() == 0 {
        return Err(problem("is empty".into()));
    }
    if found.is_dir() {
        return Err(problem(format!("is a directory, not a {kind}")));
    }
    // Opening a pipe or reading a device may block for ever.
    if !found.is_file() {
        return Err(problem(format!("is a pipe or a device; a {kind} is a regular file")));
    }
    // One byte more than allowed: the length of a file may change.
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(io)?;
    file.take(most.map_or(u64::MAX, |most| most + 1)).read_to_end(&mut bytes).map_err(io)?;
    Ok(bytes)
}

/// An error in the text of a file, with the name of the file and these words before it.
pub(crate) fn in_file(path: &Path, words: &str, error: Error) -> Error {
    let path = quoted(path);
    match error {
        Error::Cancelled => error,
        Error::File { problem, error, .. } => {
            Error::File { path, problem: format!("{words}{problem}"), error }
        }
        other => {
            let problem = format!("{words}{other}");
            Error::File { path, problem, error: Some(Box::new(other)) }
        }
    }
}
