//! What a command has to say of its inputs besides its result: rows left out, keys that it does not know, masses taken for granted.
//!
//! Kept until the command has done what it was asked for: a refusal is one line, and what led to it stands in that line.

use std::fmt::Arguments;
use std::sync::{Mutex, PoisonError};

use crate::{job, printable};

/// More are counted only.
const MOST: usize = 1_000;

/// In the order in which they came, and how many are not kept.
static NOTICES: Mutex<(Vec<String>, usize)> = Mutex::new((Vec::new(), 0));

/// Adds a line: `notice!`.
pub fn add(line: Arguments<'_>) {
    // Of a job they are its own, and dropped with whatever it said where it fails.
    if job::keep_said(&printable::line(&format!("gmr: {line}"))) {
        return;
    }
    let mut notices = NOTICES.lock().unwrap_or_else(PoisonError::into_inner);
    if notices.0.len() < MOST {
        notices.0.push(line.to_string());
    } else {
        notices.1 += 1;
    }
}

/// Prints the lines so far, on standard error; none of them comes a second time.
pub fn tell() {
    let (lines, dropped) = std::mem::take(&mut *NOTICES.lock().unwrap_or_else(PoisonError::into_inner));
    for line in lines {
        eprintln!("gmr: {line}");
    }
    if dropped > 0 {
        eprintln!("gmr: {dropped} more");
    }
}
