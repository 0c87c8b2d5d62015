//! docs/link.md says what the code says: its tables are made from the control table. `GMR_BLESS=1`
//! writes them anew.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "tests")]

use std::fmt::Write;
use std::path::PathBuf;

use firmware::control_table::{Access, REGISTERS, Reason};
use firmware::dynamixel::packet::Parser;
use firmware::link::{Device, LONGEST_INSTRUCTION, State};

fn path() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../docs/link.md")
}

fn registers() -> String {
    let mut table =
        String::from("| address | name | type | access | unit | what |\n|---|---|---|---|---|---|\n");
    for register in REGISTERS {
        let count = if register.count > 1 { format!("{} × ", register.count) } else { String::new() };
        let access = if register.access == Access::ReadWrite { "read, write" } else { "read" };
        let (address, name, kind) = (register.address, register.name, register.kind.name());
        let (unit, meaning) = (register.unit, register.meaning);
        writeln!(table, "| {address} | {name} | {count}{kind} | {access} | {unit} | {meaning} |").unwrap();
    }
    table
}

fn reasons() -> String {
    let mut table = String::from("| UPLOAD_REASON | why |\n|---|---|\n");
    for (code, reason) in (0..=u8::MAX).filter_map(|code| Some((code, Reason::from_code(code)?))) {
        writeln!(table, "| {code} | {} |", reason.text()).unwrap();
    }
    table
}

/// The document with `table` between the line that begins with `<!-- name:` and the next `<!--
/// end -->`.
fn with_table(document: &str, name: &str, table: &str) -> String {
    let begin = document.find(&format!("<!-- {name}:")).expect("the table's place");
    let begin = begin + document[begin..].find('\n').expect("the end of a line") + 1;
    let end = begin + document[begin..].find("<!-- end -->").expect("the table's end");
    [&document[..begin], table, &document[end..]].concat()
}

#[test]
fn tables_are_the_codes() {
    let document = std::fs::read_to_string(path()).unwrap();
    let expected = with_table(&with_table(&document, "registers", &registers()), "reasons", &reasons());
    if std::env::var_os("GMR_BLESS").is_some() {
        // In one step: the other test reads it meanwhile.
        let draft = path().with_extension("tmp");
        std::fs::write(&draft, expected).unwrap();
        std::fs::rename(&draft, path()).unwrap();
    } else {
        assert!(document == expected, "docs/link.md is out of date: GMR_BLESS=1 makes it anew");
    }
}

/// The example at its end is what the board receives and sends.
#[test]
fn the_example_is_true() {
    let document = std::fs::read_to_string(path()).unwrap();
    let (_, example) = document.split_once("## By hand").unwrap();
    let lines = example.lines().filter(|line| line.starts_with("    "));
    let bytes = |line: &str| -> Vec<u8> {
        line.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect()
    };
    let [request, answer] = lines.map(bytes).collect::<Vec<_>>().try_into().unwrap();
    let mut buffer = [0; 64];
    let mut device = Device::new();
    device.feed(&request);
    let length = device.answer(&mut State::new(200, 25, &mut []), &mut buffer).unwrap();
    assert_eq!(buffer.get(..length), Some(answer.as_slice()));
    assert_eq!(Parser::<LONGEST_INSTRUCTION>::new().space().len(), 512);
}
