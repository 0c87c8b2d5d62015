//! Lines of a file through one large buffer: memory does not grow with the file.

use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};

use support::context::Context;
use support::error::{Error, Result};
use support::input::Input;

/// Bytes read at once, and the longest line accepted.
pub(super) const BUFFER: usize = 1 << 20;

/// One line of a file, as a range of the buffer of [`Source`].
pub(super) enum Line {
    /// A line that ends with a line feed, which is not part of it.
    Whole(usize, usize),
    /// The last bytes of a file that does not end with a line feed.
    Cut(usize, usize),
    End,
}

/// Of a text whose lines end with CR alone, as on old Macs.
pub(super) fn carriage_returns() -> Error {
    Error::failed(
        "lines end with a carriage return alone; expected line feeds (tr '\\r' '\\n' < old.csv > new.csv)",
    )
    .at_line(1)
}

pub(super) struct Source {
    context: Context,
    path: PathBuf,
    /// None while it is lent.
    file: Option<Input>,
    /// What is read before the file.
    before: Cursor<Vec<u8>>,
    size: Option<u64>,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    read: u64,
    exhausted: bool,
    line: u64,
}

impl Source {
    pub(super) fn open(context: &Context, path: &Path) -> Result<Self> {
        let file = Input::open(context, path)?;
        let metadata = file.metadata();
        if metadata.is_dir() && !log_formats::folder::is_bag(path) {
            return Err(Error::failed(
                "is a folder; expected a run log (a file: CSV, MCAP, db3, ULog or Parquet), or the folder of a bag with its metadata.yaml",
            )
            .in_file(path));
        }
        let size = file.size();
        Ok(Self {
            context: context.clone(),
            path: path.to_owned(),
            file: Some(file),
            before: Cursor::default(),
            size,
            buffer: vec![0; BUFFER],
            start: 0,
            end: 0,
            read: 0,
            exhausted: false,
            line: 0,
        })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Size of the file; `None` for a pipe.
    pub(super) fn size(&self) -> Option<u64> {
        self.size
    }

    /// Bytes whose lines were handed out.
    pub(super) fn consumed(&self) -> u64 {
        self.read - (self.end - self.start) as u64
    }

    /// Number of the line handed out last, counted from 1.
    pub(super) fn line_number(&self) -> u64 {
        self.line
    }

    pub(super) fn bytes(&self, start: usize, end: usize) -> &[u8] {
        &self.buffer[start..end]
    }

    /// What is in the buffer behind the line handed out last.
    pub(super) fn unread(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// Takes the first bytes of [`unread`](Self::unread) for a line, the line feed included.
    pub(super) fn skip_line(&mut self, length: usize) {
        self.start += length;
        self.line += 1;
    }

    /// Whether it is a file, of which so many bytes at least have not been read.
    pub(super) fn has_left(&self, least: u64) -> bool {
        let is_file = self.file.as_ref().is_some_and(|file| file.metadata().is_file());
        is_file && self.size.is_some_and(|size| size.saturating_sub(self.read) >= least)
    }

    /// Lends the file, with what is in the buffer: from there on others read it, and say how far
    /// they are.
    pub(super) fn lend(&mut self) -> Option<(Input, Vec<u8>)> {
        let file = self.file.take()?;
        let unread = self.unread().to_vec();
        self.read -= unread.len() as u64;
        (self.start, self.end) = (0, 0);
        Some((file, unread))
    }

    /// Counts a line that others have read.
    #[inline]
    pub(super) fn count_line(&mut self) {
        self.line += 1;
    }

    /// Counts bytes whose lines others have read.
    pub(super) fn count_bytes(&mut self, count: usize) {
        self.context.point();
        self.read += count as u64;
    }

    /// Takes the file back, with what was read of it and is still to be handed out.
    pub(super) fn take_back(&mut self, file: Input, unread: Vec<u8>) {
        (self.file, self.before) = (Some(file), Cursor::new(unread));
    }

    pub(super) fn next_line(&mut self) -> Result<Line> {
        let mut searched = 0;
        loop {
            if let Some(length) = memchr::memchr(b'\n', &self.buffer[self.start + searched..self.end]) {
                let start = self.start;
                let end = start + searched + length;
                self.start = end + 1;
                self.line += 1;
                return Ok(Line::Whole(start, end));
            }
            searched = self.end - self.start;
            if self.exhausted {
                let (start, end) = (self.start, self.end);
                self.start = end;
                if start == end {
                    return Ok(Line::End);
                }
                self.line += 1;
                return Ok(Line::Cut(start, end));
            }
            self.refill()?;
        }
    }

    fn refill(&mut self) -> Result<()> {
        self.context.point();
        self.buffer.copy_within(self.start..self.end, 0);
        self.end -= self.start;
        self.start = 0;
        if self.end == self.buffer.len() {
            if self.buffer.contains(&b'\r') {
                return Err(carriage_returns().in_file(&self.path));
            }
            return Err(Error::failed(format!(
                "no line end within {BUFFER} bytes; expected a run log (CSV text, one row a line)"
            ))
            .in_file(&self.path)
            .at_line(self.line + 1));
        }
        loop {
            let free = &mut self.buffer[self.end..];
            let read = match (self.before.read(free), &mut self.file) {
                (Ok(0), Some(file)) => file.read(free),
                (before, _) => before,
            };
            match read {
                Ok(0) => {
                    self.exhausted = true;
                    return Ok(());
                }
                Ok(count) => {
                    self.end += count;
                    self.read += count as u64;
                    return Ok(());
                }
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => return Err(Error::io(&self.path, &error)),
            }
        }
    }
}
