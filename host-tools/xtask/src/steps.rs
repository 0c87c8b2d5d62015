//! A list of commands: each is announced, timed and, when it fails, the last.

use std::collections::BTreeSet;
use std::fmt;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Why the list ended early, in one line or two.
#[derive(Debug)]
pub(crate) struct Stop(String);

impl Stop {
    pub(crate) fn new(why: impl Into<String>) -> Self {
        Self(why.into())
    }
}

impl fmt::Display for Stop {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

/// The steps done so far, and the sum of the `test result:` lines they printed.
#[derive(Default)]
pub(crate) struct Steps {
    done: Vec<(String, Duration)>,
    tests: Tally,
}

/// Does a list of steps, and says how long each took and why the list ended early. True when it did
/// not.
pub(crate) fn carried_out(work: impl FnOnce(&mut Steps) -> Result<(), Stop>) -> bool {
    let mut steps = Steps::default();
    let result = work(&mut steps);
    steps.print_summary();
    if let Err(stop) = &result {
        println!("\nstopped: {stop}");
    }
    result.is_ok()
}

/// How many tests ran.
#[derive(Default, Debug, PartialEq, Eq, Clone)]
pub(crate) struct Tally {
    passed: u64,
    pub(crate) failed: u64,
    /// Left out by the harness itself.
    ignored: u64,
    /// Ran, and said that they could not test anything here. The harness counts them as passed.
    skipped: BTreeSet<String>,
}

/// What such a test says: `host-tools/tests/suite/common/skipped.rs`.
const SKIPPED: &str = "SKIPPED: ";

impl Tally {
    /// Tests that tested something.
    pub(crate) fn passed(&self) -> u64 {
        self.passed.saturating_sub(self.skipped.len() as u64)
    }

    /// Tests that did not.
    pub(crate) fn skipped(&self) -> u64 {
        self.ignored + self.skipped.len() as u64
    }

    /// Those that said so, with their reasons.
    pub(crate) fn reasons(&self) -> impl Iterator<Item = &str> {
        self.skipped.iter().map(String::as_str)
    }

    /// Adds a summary of libtest or our images (`test result: ok. 3 passed; 0 failed; …`), or what
    /// a skipped test says, anywhere in the line. Other lines count nothing.
    fn add_line(&mut self, line: &str) {
        if let Some((_, said)) = line.split_once(SKIPPED) {
            self.skipped.insert(said.trim_end().to_owned());
        }
        let Some(result) = line.strip_prefix("test result: ") else { return };
        let words: Vec<&str> = result.split([' ', ';', '.']).filter(|word| !word.is_empty()).collect();
        for pair in words.windows(2) {
            let [number, what] = pair else { continue };
            let Ok(number) = number.parse::<u64>() else { continue };
            match *what {
                "passed" => self.passed += number,
                "failed" => self.failed += number,
                "ignored" => self.ignored += number,
                _ => {}
            }
        }
    }
}

impl Steps {
    /// Runs `command` as the step `name` in the workspace's directory.
    pub(crate) fn run(&mut self, name: &str, mut command: Command) -> Result<(), Stop> {
        let started = announce(name);
        let line = command_line(&command);
        println!("   {line}");
        command.current_dir(crate::paths::root()).stdout(Stdio::piped());
        let mut child = command.spawn().map_err(|error| Stop::new(format!("{line}\n   {error}")))?;
        self.echo(&mut child);
        let status = child.wait().map_err(|error| Stop::new(format!("{line}\n   {error}")))?;
        self.finish(name, started);
        if status.success() { Ok(()) } else { Err(Stop::new(format!("{line}\n   {status}"))) }
    }

    /// Runs `command` as the step `name` while `beside` runs on another core; what that says is
    /// shown behind.
    pub(crate) fn run_beside(
        &mut self,
        name: &str,
        command: Command,
        mut beside: Command,
    ) -> Result<(), Stop> {
        let line = command_line(&beside);
        println!("\n── beside\n   {line}");
        beside.current_dir(crate::paths::root()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = beside.spawn().map_err(|error| Stop::new(format!("{line}\n   {error}")))?;
        // Read to its end all the time: a pipe that nobody empties would stop it.
        let reader = std::thread::spawn(|| child.wait_with_output());
        let result = self.run(name, command);
        let failed = |why: String| Stop::new(format!("{line}\n   {why}"));
        let output = reader.join().map_err(|_| failed("was not waited for".to_owned()))?;
        let output = output.map_err(|error| failed(error.to_string()))?;
        println!("   {line}");
        for text in [&output.stderr, &output.stdout] {
            print!("{}", String::from_utf8_lossy(text));
        }
        String::from_utf8_lossy(&output.stdout).lines().for_each(|line| self.tests.add_line(line));
        result?;
        if output.status.success() { Ok(()) } else { Err(failed(output.status.to_string())) }
    }

    /// Runs what is more than one command as the step `name`.
    pub(crate) fn work(&mut self, name: &str, work: impl FnOnce() -> Result<(), Stop>) -> Result<(), Stop> {
        let started = announce(name);
        let result = work();
        self.finish(name, started);
        result
    }

    pub(crate) fn tests(&self) -> &Tally {
        &self.tests
    }

    /// One line a step, with its time.
    pub(crate) fn print_summary(&self) {
        println!();
        for (name, time) in &self.done {
            println!("{:7.1} s  {name}", time.as_secs_f64());
        }
        let total: Duration = self.done.iter().map(|(_, time)| *time).sum();
        println!("{:7.1} s  in all", total.as_secs_f64());
    }

    fn echo(&mut self, child: &mut Child) {
        let Some(output) = child.stdout.take() else { return };
        for line in BufReader::new(output).split(b'\n').map_while(Result::ok) {
            let line = String::from_utf8_lossy(&line);
            self.tests.add_line(&line);
            println!("{line}");
        }
    }

    fn finish(&mut self, name: &str, started: Instant) {
        let time = started.elapsed();
        println!("   {name}: {:.1} s", time.as_secs_f64());
        self.done.push((name.to_owned(), time));
    }
}

fn announce(name: &str) -> Instant {
    println!("\n── {name}");
    Instant::now()
}

/// As one would type it.
pub(crate) fn command_line(command: &Command) -> String {
    let variables = command.get_envs().filter_map(|(name, value)| {
        Some(format!("{}={:?} ", name.to_string_lossy(), value?.to_string_lossy()))
    });
    let words = std::iter::once(command.get_program()).chain(command.get_args()).map(|word| {
        let word = word.to_string_lossy();
        if word.contains(' ') { format!("'{word}'") } else { word.into_owned() }
    });
    variables.collect::<String>() + &words.collect::<Vec<_>>().join(" ")
}

/// `program` with its arguments, as one would type them; no argument may contain a space.
pub(crate) fn command(line: &str) -> Command {
    let mut words = line.split_whitespace();
    let mut command = Command::new(words.next().unwrap_or_default());
    command.args(words);
    command
}

/// What `command` says on standard output, or nothing when it cannot run or fails.
pub(crate) fn answer(line: &str) -> Option<String> {
    let output = command(line).current_dir(crate::paths::root()).stderr(Stdio::null()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tally_adds_libtest_and_image_summaries() {
        let mut tally = Tally::default();
        tally.add_line(
            "test result: ok. 17 passed; 0 failed; 3 ignored; 0 measured; 0 filtered out; finished in 0.00s",
        );
        tally.add_line("test result: FAILED. 2 passed; 1 failed");
        tally.add_line("test numbers::failed ... ok");
        assert_eq!((tally.passed(), tally.failed, tally.skipped()), (19, 1, 3));
    }

    /// The harness counts them as passed: they are taken off, each once, wherever in the line it
    /// says so.
    #[test]
    fn skipped_tests_are_not_passed_ones() {
        let mut tally = Tally::default();
        tally.add_line("test inspects_them_all ... SKIPPED: inspect::inspects_them_all: no data");
        tally.add_line("SKIPPED: inspect::inspects_them_all: no data");
        tally.add_line("SKIPPED: page::opens: no browser");
        tally.add_line("test result: ok. 5 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out");
        assert_eq!((tally.passed(), tally.failed, tally.skipped()), (3, 0, 3));
        assert_eq!(tally.reasons().next(), Some("inspect::inspects_them_all: no data"));
    }

    #[test]
    fn a_failing_command_stops_and_says_its_line() {
        let mut steps = Steps::default();
        assert!(steps.run("works", command("true")).is_ok());
        let stop = steps.run("fails", command("false --now")).unwrap_err();
        assert!(stop.to_string().starts_with("false --now\n"), "{stop}");
        let stop = steps.run("is missing", command("no-such-program-here")).unwrap_err();
        assert!(stop.to_string().starts_with("no-such-program-here\n"), "{stop}");
    }

    #[test]
    fn what_runs_beside_counts_and_can_fail() {
        let mut steps = Steps::default();
        let says = |what: &str| {
            let mut echo = command("echo");
            echo.arg(what);
            echo
        };
        let both =
            steps.run_beside("both", says("test result: ok. 2 passed;"), says("test result: ok. 3 passed;"));
        assert!(both.is_ok());
        assert_eq!((steps.tests().passed(), steps.tests().failed), (5, 0));
        let stop = steps.run_beside("one fails", command("true"), command("false --now")).unwrap_err();
        assert!(stop.to_string().starts_with("false --now\n"), "{stop}");
        assert!(steps.run_beside("the other fails", command("false"), command("true")).is_err());
    }

    #[test]
    fn command_lines_can_be_pasted() {
        let mut command = command("cargo doc");
        command.env("RUSTDOCFLAGS", "-D warnings").arg("two words");
        assert_eq!(command_line(&command), "RUSTDOCFLAGS=\"-D warnings\" cargo doc 'two words'");
    }
}
