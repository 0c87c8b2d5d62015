//! What commands read: files, and pipes, which can be read once only.
//!
//! Some commands look at a log twice (the columns first, then the rows). What is no file is kept in
//! a temporary one while it is read, so that whoever opens it again begins at its start; it is
//! never opened twice, which would wait for another writer.

use std::collections::HashMap;
use std::fs::{File, Metadata};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::context::Context;
use crate::error::{Error, Result};

/// Bytes of the longest description (robot, coefficients, effects): some 10⁵ lines, where people
/// write a hundred.
pub const MOST_DESCRIPTION: u64 = 8 << 20;

/// Bytes of the longest speed profile: a week at 20 rows a second.
pub const MOST_PROFILE: u64 = 1 << 30;

/// A file or a pipe, from its start on.
#[derive(Debug)]
pub struct Input {
    from: From,
    metadata: Metadata,
}

#[derive(Debug)]
enum From {
    File(File),
    Pipe { kept: Arc<Mutex<Kept>>, offset: u64 },
}

/// A pipe, and what of it has been read.
#[derive(Debug)]
struct Kept {
    /// Until it has ended.
    pipe: Option<File>,
    read: File,
    length: u64,
}

/// Pipes that a call has opened, by the name that they were opened by.
type Pipes = Mutex<HashMap<PathBuf, Arc<Mutex<Kept>>>>;

impl Input {
    /// Opens a file or a pipe, which the call keeps as long as it lasts.
    ///
    /// # Errors
    /// What the operating system refuses.
    pub fn open(context: &Context, path: &Path) -> Result<Self> {
        Self::try_open(context, path).map_err(|error| Error::io(path, &error))
    }

    fn try_open(context: &Context, path: &Path) -> io::Result<Self> {
        let metadata = std::fs::metadata(path)?;
        if metadata.is_file() || metadata.is_dir() {
            return Ok(Self { from: From::File(File::open(path)?), metadata });
        }
        let pipes = context.kept::<Pipes>();
        let mut pipes = pipes.lock().unwrap_or_else(PoisonError::into_inner);
        let kept = match pipes.get(path) {
            Some(kept) => Arc::clone(kept),
            None => {
                let kept = Kept { pipe: Some(File::open(path)?), read: tempfile::tempfile()?, length: 0 };
                let kept = Arc::new(Mutex::new(kept));
                pipes.insert(path.to_owned(), Arc::clone(&kept));
                kept
            }
        };
        Ok(Self { from: From::Pipe { kept, offset: 0 }, metadata })
    }

    /// What it is.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }

    /// Bytes in all, where that is known.
    pub fn size(&self) -> Option<u64> {
        match &self.from {
            From::File(_) => self.metadata.is_file().then_some(self.metadata.len()),
            From::Pipe { kept, .. } => {
                let kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                kept.pipe.is_none().then_some(kept.length)
            }
        }
    }
}

impl Read for Input {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match &mut self.from {
            From::File(file) => file.read(buffer),
            From::Pipe { kept, offset } => {
                let count = kept.lock().unwrap_or_else(PoisonError::into_inner).read_at(*offset, buffer)?;
                *offset += count as u64;
                Ok(count)
            }
        }
    }
}

impl Kept {
    fn read_at(&mut self, offset: u64, buffer: &mut [u8]) -> io::Result<usize> {
        if offset < self.length {
            let most = buffer.len().min((self.length - offset) as usize);
            self.read.seek(SeekFrom::Start(offset))?;
            return self.read.read(&mut buffer[..most]);
        }
        let Some(pipe) = &mut self.pipe else { return Ok(0) };
        let count = pipe.read(buffer)?;
        if count == 0 {
            self.pipe = None;
            return Ok(0);
        }
        self.read.seek(SeekFrom::Start(self.length))?;
        self.read.write_all(&buffer[..count])?;
        self.length += count as u64;
        Ok(count)
    }
}

/// All of a text that is read once, as long as it has at most so many bytes.
///
/// # Errors
/// What the operating system refuses; a longer text, or none.
pub fn read_text(path: &Path, most: u64) -> Result<String> {
    text_of(File::open(path).map_err(|error| Error::io(path, &error))?, path, most)
}

/// The same of what has been opened.
///
/// # Errors
/// As [`read_text`].
pub fn text_of(input: impl Read, path: &Path, most: u64) -> Result<String> {
    let mut text = Vec::new();
    input.take(most + 1).read_to_end(&mut text).map_err(|error| Error::io(path, &error))?;
    if text.len() as u64 > most {
        let message = format!("is longer than {most} bytes; expected a text that somebody wrote");
        return Err(Error::failed(message).in_file(path));
    }
    String::from_utf8(text).map_err(|_| Error::failed("is not UTF-8 text").in_file(path))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// A pipe gives the same bytes to whoever opens it, however their reads overlap.
    #[test]
    fn a_pipe_is_read_as_often_as_it_is_opened() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pipe");
        rustix::fs::mknodat(
            rustix::fs::CWD,
            &path,
            rustix::fs::FileType::Fifo,
            rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR,
            0,
        )
        .unwrap();
        let content: Vec<u8> = (0..100_000_u32).flat_map(u32::to_le_bytes).collect();
        let (to, written) = (path.clone(), content.clone());
        let writer = std::thread::spawn(move || File::create(to).unwrap().write_all(&written).unwrap());
        let context = Context::default();
        let mut first = Input::open(&context, &path).unwrap();
        let mut start = vec![0; 1000];
        first.read_exact(&mut start).unwrap();
        assert_eq!(start, content[..1000]);
        for _ in 0..2 {
            let mut all = Vec::new();
            Input::open(&context, &path).unwrap().read_to_end(&mut all).unwrap();
            assert_eq!(all, content);
        }
        let mut rest = Vec::new();
        first.read_to_end(&mut rest).unwrap();
        assert_eq!(rest, content[1000..]);
        writer.join().unwrap();
    }

    #[test]
    fn what_never_ends_is_refused() {
        let error = read_text(Path::new("/dev/zero"), 1 << 16).unwrap_err().to_string();
        assert!(error.starts_with("/dev/zero: is longer than 65536 bytes"), "{error}");
    }
}
