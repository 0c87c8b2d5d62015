use std::collections::BTreeMap;

use super::tree::Reader;
use super::*;

/// Faults of a crate made of these files.
fn faults(files: &[(&str, &str)]) -> Vec<String> {
    let files: BTreeMap<&Path, &str> = files.iter().map(|(path, text)| (Path::new(*path), *text)).collect();
    let read: Reader<'_> = &|path| files.get(path).map(|text| (*text).to_owned());
    let root = files.keys().find(|path| path.ends_with("lib.rs")).unwrap();
    faults_of(&Tree::read(root, read).unwrap())
}

#[test]
fn two_files_that_import_each_other_are_a_circle() {
    let faults = faults(&[
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "use super::b::B; pub struct A(B);"),
        ("b.rs", "use crate::a::A; pub struct B(Option<Box<A>>);"),
    ]);
    assert_eq!(faults, ["a circle of 2 files:\n      a.rs → b.rs (B)\n      b.rs → a.rs (A)"]);
}

/// By an alias of a module, by a path in code, by a macro, by an attribute, in a function, by a glob.
#[test]
fn every_way_to_name_something_ties() {
    for uses in [
        "use super::a; pub fn b() { a::a() }",
        "pub fn b() { super::a::a() }",
        "pub fn b() { println!(\"{}\", crate::a::a()) }",
        "#[arg(value_parser = super::a::a)] pub fn b() {}",
        "pub fn b() { use super::a::a; }",
        "use super::a::*; pub fn b() { a() }",
        "use super::{a::{self as other}}; pub fn b() { other::a() }",
        "mod inner { pub fn c() { super::super::a::a() } } pub fn b() {}",
    ] {
        let files = [("lib.rs", "mod a; mod b;"), ("a.rs", "pub fn a() { super::b::b() }"), ("b.rs", uses)];
        assert_eq!(faults(&files).len(), 1, "{uses}");
    }
}

#[test]
fn a_circle_of_three_through_re_exports_is_found() {
    let faults = faults(&[
        ("src/lib.rs", "pub mod room; pub mod other;"),
        ("src/room/mod.rs", "mod a; mod b; pub use a::A; pub use b::B;"),
        ("src/room/a.rs", "use super::B; pub struct A(B);"),
        ("src/room/b.rs", "use crate::other::C; pub struct B(C);"),
        ("src/other.rs", "pub struct C(Option<Box<crate::room::A>>);"),
    ]);
    assert_eq!(faults.len(), 1);
    assert!(faults[0].starts_with("a circle of 3 files:") && !faults[0].contains("mod.rs"), "{faults:?}");
}

#[test]
fn handing_on_is_no_circle() {
    let faults = faults(&[
        ("lib.rs", "pub mod room;"),
        ("room/mod.rs", "mod a; pub mod b; pub use a::A; pub(crate) use b::*; pub struct Shared;"),
        ("room/a.rs", "use super::{Shared, b}; pub struct A(Shared, b::B);"),
        ("room/b.rs", "use super::Shared; pub struct B(Shared);"),
    ]);
    assert_eq!(faults, [""; 0]);
}

#[test]
fn a_child_and_a_mod_rs_whose_code_needs_it_are_a_circle() {
    let faults = faults(&[
        ("lib.rs", "mod room;"),
        ("room/mod.rs", "mod a; pub struct Shared; pub fn run() { a::run() }"),
        ("room/a.rs", "use super::Shared; pub fn run() {}"),
    ]);
    assert_eq!(faults.len(), 1);
}

#[test]
fn code_for_tests_and_other_crates_tie_nothing() {
    let faults = faults(&[
        ("lib.rs", "mod a; mod b; #[cfg(test)] mod missing;"),
        ("a.rs", "use super::b::B; pub struct A(B);"),
        (
            "b.rs",
            "use rand::a::A as _; use core::fmt; pub struct B; #[cfg(test)] mod tests { use crate::a::A; } \
             impl B { #[cfg(test)] fn a(&self) -> crate::a::A { todo!() } } #[cfg(all(test, unix))] use crate::a::A;",
        ),
    ]);
    assert_eq!(faults, [""; 0]);
}

#[test]
fn a_name_of_a_module_and_of_a_function_in_it_are_told_apart() {
    let faults = faults(&[
        ("lib.rs", "mod whiten; mod b; pub use whiten::whiten;"),
        ("whiten.rs", "use super::b::B; pub fn whiten(_: B) {}"),
        ("b.rs", "pub struct B; pub fn b() { let whiten = 1; whiten.b(); field.whiten; }"),
    ]);
    assert_eq!(faults, [""; 0]);
}

#[test]
fn files_elsewhere_are_found() {
    let faults = faults(&[
        ("tests/lib.rs", "#[path = \"../system/a.rs\"] mod a; mod b;"),
        ("system/a.rs", "mod c; use super::b::B; pub struct A(B);"),
        ("system/c.rs", ""),
        ("tests/b.rs", "pub struct B(Option<Box<super::a::A>>);"),
    ]);
    assert_eq!(faults.len(), 1);
}

#[test]
fn arrows_between_rooms_go_one_way() {
    let faults = faults(&[
        ("host-tools/src/lib.rs", "pub mod fit; pub mod gap;"),
        ("host-tools/src/fit/mod.rs", "pub mod file;"),
        ("host-tools/src/fit/file.rs", "use crate::gap::extended::id_of;"),
        ("host-tools/src/gap/mod.rs", "pub mod extended;"),
        ("host-tools/src/gap/extended.rs", "pub fn id_of() {}"),
    ]);
    assert_eq!(
        faults,
        ["fit must not need gap: host-tools/src/fit/file.rs → host-tools/src/gap/extended.rs (id_of)"]
    );
}

/// docs/architecture.md draws the floors that are checked, the highest first.
#[test]
fn the_floors_are_those_of_the_documentation() {
    let page = std::fs::read_to_string(crate::paths::root().join("docs/architecture.md")).unwrap();
    let mut rest = page.as_str();
    for floor in FLOORS.iter().rev() {
        let line = format!("\n    {} ", floor.join(" · "));
        let at = rest.find(&line).unwrap_or_else(|| panic!("not in its place: {line}"));
        rest = &rest[at + line.len()..];
    }
    for room in FLOORS.concat() {
        assert!(page.contains(&format!("`{room}/`")), "{room} is not explained");
    }
}

/// What it says of a file that is not there, or not Rust.
#[test]
fn what_cannot_be_read_is_named() {
    let read: Reader<'_> = &|path| path.ends_with("lib.rs").then(|| "mod a;".to_owned());
    assert_eq!(Tree::read(Path::new("lib.rs"), read).unwrap_err(), "a/mod.rs: cannot be read");
    let read: Reader<'_> = &|_| Some("struct {".to_owned());
    assert!(Tree::read(Path::new("lib.rs"), read).unwrap_err().starts_with("lib.rs:1: "));
}
