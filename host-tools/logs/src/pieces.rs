//! A large text in pieces, which end where lines do: read one behind the other, turned into numbers
//! by whichever thread is free, and handed out in order.
//!
//! A piece's lines are taken as far as they are rows, which is nearly always to its end. Where one
//! is none, a fault or a blank line, and at the end of the file, what is left goes back to
//! [`Source`](super::source::Source), whose reader says what it is.

use std::collections::VecDeque;
use std::io::Read as _;
use std::sync::Arc;

use log_formats::ahead::{Ahead, Work};
use support::input::Input;

use super::line::Layout;
use super::parsed::Rows;
use super::source::BUFFER;

/// Bytes of a piece.
const PIECE: usize = 1 << 18;

/// Pieces that wait to be handed out, at most.
const MOST_PIECES: usize = 16;

/// Rows of a text, of which others make numbers ahead.
pub(super) struct Pieces {
    ahead: Ahead<Text>,
    /// Those at hand, and the next of them.
    rows: Rows,
    next: usize,
}

impl Pieces {
    /// Of a file behind what was read of it.
    pub(super) fn new(file: Input, unread: Vec<u8>, layout: Layout) -> Self {
        let text = Text {
            layout: Arc::new(layout),
            reader: Some(Reader { file, rest: unread, is_over: false }),
            pieces: VecDeque::new(),
            first: 0,
            spare: Vec::new(),
        };
        Self { ahead: Ahead::new(text, 0), rows: Rows::default(), next: 0 }
    }

    /// The next row, if there is one at hand.
    #[inline]
    pub(super) fn row(&mut self) -> Option<(&mut Rows, usize)> {
        let place = self.next;
        if place == self.rows.len() {
            return None;
        }
        self.next += 1;
        Some((&mut self.rows, place))
    }

    /// Goes on to the next piece: how many bytes of text its rows are. None where a line is no row,
    /// or there are no more.
    pub(super) fn advance(&mut self) -> Option<usize> {
        if !self.rows.is_whole() {
            return None;
        }
        let used = std::mem::take(&mut self.rows);
        self.ahead.with(|text| text.spare.push(used));
        self.next = 0;
        self.rows = self.ahead.take_next().flatten()?;
        Some(self.rows.bytes())
    }

    /// The file, and what was read of it behind the last row.
    pub(super) fn end(self) -> Option<(Input, Vec<u8>)> {
        let Text { reader, pieces, .. } = self.ahead.into_work()?;
        let mut unread = self.rows.into_rest();
        for piece in pieces {
            match piece {
                Piece::Read(text) => unread.extend(text),
                Piece::Made(rows) => unread.extend(rows.into_text()),
                Piece::Begun => {}
            }
        }
        let Reader { file, rest, .. } = reader?;
        unread.extend(rest);
        Some((file, unread))
    }
}

/// The text of a file.
struct Text {
    layout: Arc<Layout>,
    /// None while it reads.
    reader: Option<Reader>,
    pieces: VecDeque<Piece>,
    /// The number of the first of them.
    first: usize,
    /// Memory of rows that were handed out.
    spare: Vec<Rows>,
}

struct Reader {
    file: Input,
    /// Behind the last line end.
    rest: Vec<u8>,
    is_over: bool,
}

enum Piece {
    Read(Vec<u8>),
    Begun,
    Made(Rows),
}

enum Job {
    Read(Reader, Vec<u8>),
    Make { number: usize, text: Vec<u8>, into: Rows, layout: Arc<Layout> },
}

enum Done {
    Read(Reader, Vec<u8>),
    Made { number: usize, rows: Rows },
}

impl Work for Text {
    type Job = Job;
    type Done = Done;
    /// None at the end.
    type Next = Option<Rows>;

    fn claim(&mut self) -> Option<Job> {
        let read = |piece: &Piece| matches!(piece, Piece::Read(_));
        if let Some(place) = self.pieces.iter().position(read)
            && let Piece::Read(text) = std::mem::replace(&mut self.pieces[place], Piece::Begun)
        {
            let into = self.spare.pop().unwrap_or_default();
            return Some(Job::Make { number: self.first + place, text, into, layout: self.layout.clone() });
        }
        if self.pieces.len() == MOST_PIECES || self.reader.as_ref().is_none_or(|reader| reader.is_over) {
            return None;
        }
        // Of the memory of rows, that of the text.
        let text = self.spare.last_mut().map(Rows::take_text).unwrap_or_default();
        self.reader.take().map(|reader| Job::Read(reader, text))
    }

    fn make(job: Job) -> Done {
        match job {
            Job::Read(mut reader, text) => {
                let text = reader.read(text);
                Done::Read(reader, text)
            }
            Job::Make { number, text, into, layout } => Done::Made { number, rows: into.of(text, &layout) },
        }
    }

    fn keep(&mut self, done: Done) {
        match done {
            Done::Read(reader, text) => {
                self.reader = Some(reader);
                if !text.is_empty() {
                    self.pieces.push_back(Piece::Read(text));
                }
            }
            Done::Made { number, rows } => {
                let place = number.checked_sub(self.first);
                if let Some(piece) = place.and_then(|place| self.pieces.get_mut(place)) {
                    *piece = Piece::Made(rows);
                }
            }
        }
    }

    fn take(&mut self) -> Option<Option<Rows>> {
        match self.pieces.front() {
            Some(Piece::Made(_)) => {
                self.first += 1;
                self.pieces.pop_front().map(|piece| match piece {
                    Piece::Made(rows) => Some(rows),
                    Piece::Read(_) | Piece::Begun => None,
                })
            }
            Some(Piece::Read(_) | Piece::Begun) => None,
            None => self.reader.as_ref().is_some_and(|reader| reader.is_over).then_some(None),
        }
    }

    fn is_behind(&self) -> bool {
        self.pieces.len() < MOST_PIECES / 2 && self.reader.as_ref().is_none_or(|reader| !reader.is_over)
    }
}

impl Reader {
    /// The next piece, up to its last line end; empty at the end of the file, where that has been
    /// read as a whole, or at a line too long for it, which is left.
    fn read(&mut self, mut text: Vec<u8>) -> Vec<u8> {
        text.clear();
        text.append(&mut self.rest);
        let mut searched = 0;
        let mut most = PIECE;
        loop {
            let before = text.len();
            let wanted = most.saturating_sub(before) as u64;
            // What the operating system refuses, whoever reads the rest will hear.
            let read = (&mut self.file).take(wanted).read_to_end(&mut text);
            self.is_over = !matches!(read, Ok(count) if count as u64 == wanted);
            if let Some(last) = memchr::memrchr(b'\n', &text[searched..]) {
                self.rest.extend_from_slice(&text[searched + last + 1..]);
                text.truncate(searched + last + 1);
                return text;
            }
            searched = text.len();
            if self.is_over || searched >= BUFFER {
                self.is_over = true;
                self.rest = text;
                return Vec::new();
            }
            most = BUFFER;
        }
    }
}
