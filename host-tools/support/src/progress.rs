//! A progress bar over files, on standard error, only on a terminal and only after a second.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::context::Context;

/// Bytes read of a list of files.
pub struct FileProgress {
    context: Context,
    bar: Option<ProgressBar>,
    started: Instant,
    total: u64,
    done: u64,
    current: u64,
}

impl FileProgress {
    /// Over these files; those whose size is not known count as empty.
    pub fn new(context: &Context, files: &[PathBuf]) -> Self {
        let size = |file: &PathBuf| std::fs::metadata(file).map_or(0, |metadata| metadata.len());
        Self {
            context: context.clone(),
            bar: None,
            started: Instant::now(),
            total: files.iter().map(size).sum(),
            done: 0,
            current: 0,
        }
    }

    /// So many bytes of the current file are read.
    pub fn at(&mut self, (bytes, _): (u64, Option<u64>)) {
        self.current = bytes;
        self.context.at("reading", self.done + bytes, self.total);
        if self.bar.is_none() && self.started.elapsed() > Duration::from_secs(1) {
            let bar = ProgressBar::new(self.total);
            if let Ok(style) =
                ProgressStyle::with_template("reading {bar:40} {bytes}/{total_bytes}, {eta} left")
            {
                bar.set_style(style);
            }
            self.bar = Some(bar);
        }
        if let Some(bar) = &self.bar {
            bar.set_position(self.done + bytes);
        }
    }

    /// The current file is read.
    pub fn done_with_file(&mut self) {
        self.done += self.current;
        self.current = 0;
    }

    /// Takes the bar away.
    pub fn finish(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

/// Work in stages of unknown length: a spinner that says which one, on a terminal only.
pub struct StageProgress {
    context: Context,
    bar: ProgressBar,
}

impl StageProgress {
    /// With the first one.
    pub fn new(context: &Context, stage: &'static str) -> Self {
        let bar = ProgressBar::no_length();
        if let Ok(style) = ProgressStyle::with_template("{spinner} {wide_msg} {elapsed}") {
            bar.set_style(style);
        }
        bar.set_message(stage);
        bar.enable_steady_tick(Duration::from_millis(120));
        Self { context: context.clone(), bar }
    }

    /// Now this one.
    pub fn at(&self, stage: &'static str) {
        self.context.at(stage, 0, 0);
        self.bar.set_message(stage);
    }
}

impl Drop for StageProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// So many pieces of work of one kind: a bar, on a terminal only. Pieces may end on any thread.
pub struct CountProgress {
    context: Context,
    bar: ProgressBar,
}

impl CountProgress {
    /// None is done.
    pub fn new(context: &Context, what: &'static str, count: u64) -> Self {
        let bar = ProgressBar::new(count).with_prefix(what);
        if let Ok(style) =
            ProgressStyle::with_template("{prefix} {bar:40} {pos} of {len}, {elapsed}, {eta} left")
        {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(250));
        Self { context: context.clone(), bar }
    }

    /// One more is done.
    pub fn one_more(&self) {
        self.bar.inc(1);
        let (done, total) = (self.bar.position(), self.bar.length().unwrap_or(0));
        self.context.at(&self.bar.prefix(), done, total);
    }
}

impl Drop for CountProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// A recording: a bar where its length is known, a spinner where not, and what the board says.
pub struct RecordProgress {
    bar: ProgressBar,
    drawn: Option<Instant>,
}

impl RecordProgress {
    /// So long, where that is known.
    pub fn new(length: Option<Duration>) -> Self {
        let bar = match length {
            Some(length) => ProgressBar::new(length.as_millis().try_into().unwrap_or(u64::MAX)),
            None => ProgressBar::no_length(),
        };
        let template =
            if length.is_some() { "{bar:20} {prefix} {wide_msg}" } else { "{spinner} {prefix} {wide_msg}" };
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        Self { bar, drawn: None }
    }

    /// So much is recorded. The text is asked for only when there is somebody to read it.
    pub fn at(&mut self, elapsed: Duration, text: impl FnOnce() -> String) {
        let is_due = self.drawn.is_none_or(|drawn| drawn.elapsed() > Duration::from_millis(100));
        if self.bar.is_hidden() || !is_due {
            return;
        }
        self.drawn = Some(Instant::now());
        self.bar.set_prefix(format!("{:.1} s", elapsed.as_secs_f64()));
        self.bar.set_message(text());
        self.bar.set_position(elapsed.as_millis().try_into().unwrap_or(u64::MAX));
    }

    /// Takes the bar away.
    pub fn finish(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Waiting for something that may take up to a limit.
pub struct WaitProgress {
    bar: ProgressBar,
}

impl WaitProgress {
    /// For what, and how long at most.
    pub fn new(what: &'static str, limit: Duration) -> Self {
        let bar = ProgressBar::new(limit.as_millis().try_into().unwrap_or(u64::MAX));
        if let Ok(style) = ProgressStyle::with_template("{prefix} {bar:40} {msg}") {
            bar.set_style(style);
        }
        bar.set_prefix(what);
        Self { bar }
    }

    /// So long already.
    pub fn at(&self, waited: Duration) {
        self.bar.set_message(format!("{:.0} s", waited.as_secs_f64()));
        self.bar.set_position(waited.as_millis().try_into().unwrap_or(u64::MAX));
    }
}

impl Drop for WaitProgress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
