//! `cargo xtask bloat`: machine code of ours in the release build of `gmr`, and how much of it
//! stands there often.
//!
//! A generic function has a symbol for each set of its types, all of one name without them:
//! `nm --demangle` prints symbols so.

use std::collections::{BTreeMap, BTreeSet};

use crate::paths::target_folder;
use crate::steps::{Stop, answer, carried_out, command};

/// Copies from which a function counts as standing there often.
const OFTEN: usize = 4;

/// Functions that are listed.
const LISTED: usize = 20;

/// Builds, counts and prints.
pub(crate) fn run() -> bool {
    carried_out(|steps| {
        steps.run("gmr", command("cargo build --quiet --release --package host-tools --bin gmr"))?;
        let binary = target_folder().join("release/gmr");
        let symbols = answer(&format!("nm --demangle --print-size --defined-only {}", binary.display()));
        let symbols = symbols.ok_or_else(|| Stop::new("nm, of binutils, cannot list the symbols of gmr"))?;
        print(&functions(&symbols, &ours()?));
        Ok(())
    })
}

/// The workspace's crates, as code names them.
fn ours() -> Result<BTreeSet<String>, Stop> {
    let read = || {
        let metadata = answer("cargo metadata --no-deps --format-version 1")?;
        let metadata: serde_json::Value = serde_json::from_str(&metadata).ok()?;
        let packages = metadata["packages"].as_array()?;
        let targets = packages.iter().filter_map(|package| package["targets"].as_array()).flatten();
        Some(targets.filter_map(|target| Some(target["name"].as_str()?.replace('-', "_"))).collect())
    };
    read().ok_or_else(|| Stop::new("cargo metadata does not list the crates"))
}

/// Copies and bytes of each function of these crates.
fn functions<'a>(symbols: &'a str, ours: &BTreeSet<String>) -> BTreeMap<&'a str, (usize, u64)> {
    let mut functions = BTreeMap::new();
    for line in symbols.lines() {
        // Address, size, kind, name: `t` and `T` are code.
        let mut fields = line.splitn(4, ' ');
        let (Some(_), Some(size), Some("t" | "T"), Some(name)) =
            (fields.next(), fields.next(), fields.next(), fields.next())
        else {
            continue;
        };
        // The type of an implementation stands in brackets: `<gap::types::Round as
        // core::fmt::Debug>::fmt`.
        let path = name.trim_start_matches(['<', '&', '*', '[', '(']);
        let path = path.strip_prefix("mut ").or_else(|| path.strip_prefix("dyn ")).unwrap_or(path);
        let is_ours = path.split_once("::").is_some_and(|(first, _)| ours.contains(first));
        if let (true, Ok(size)) = (is_ours, u64::from_str_radix(size, 16)) {
            let (copies, bytes) = functions.entry(name).or_default();
            *copies += 1;
            *bytes += size;
        }
    }
    functions
}

fn print(functions: &BTreeMap<&str, (usize, u64)>) {
    let all: u64 = functions.values().map(|(_, bytes)| bytes).sum();
    let mut often: Vec<_> = functions.iter().filter(|(_, (copies, _))| *copies >= OFTEN).collect();
    often.sort_by_key(|(_, (_, bytes))| std::cmp::Reverse(*bytes));
    let surplus: u64 = often.iter().map(|(_, (_, bytes))| bytes).sum();
    let share = 100.0 * surplus as f64 / all.max(1) as f64;
    println!("   {:.2} MB of ours, {share:.0} % of it in {OFTEN} copies or more", all as f64 / 1e6);
    for (name, (copies, bytes)) in often.iter().take(LISTED) {
        println!("   {:7.1} kB {copies:3} × {name}", *bytes as f64 / 1e3);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Data, other crates and names without a path are no functions of ours.
    #[test]
    fn copies_of_our_functions_are_counted() {
        let symbols = "\
0000000000000010 0000000000000020 t fit::fit
0000000000000030 0000000000000010 t fit::fit
0000000000000040 0000000000000008 t <fit::Fit<_> as core::fmt::Debug>::fmt
0000000000000050 0000000000000001 r fit::TABLE
0000000000000060 0000000000000001 t core::fmt::write
0000000000000070 0000000000000001 T fit
";
        let sizes = functions(symbols, &BTreeSet::from(["fit".to_owned()]));
        let expected = [("<fit::Fit<_> as core::fmt::Debug>::fmt", (1, 8)), ("fit::fit", (2, 0x30))];
        assert_eq!(sizes, BTreeMap::from(expected));
    }
}
