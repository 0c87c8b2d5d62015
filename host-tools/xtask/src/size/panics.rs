//! Where the board's image may panic, and why none of it is reached.
//!
//! Every call of the panic machinery in the linked image, by whose code it stands in. What is not
//! in [`KNOWN`] fails the check: a new index, division or unwrap in our own code, or a dependency
//! that begins to panic in another way.

use std::collections::BTreeMap;

use addr2line::Context;
use addr2line::gimli::{EndianSlice, RunTimeEndian};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind};

use crate::steps::Stop;

/// Names of functions that do not return, and what they are called for.
const KINDS: [(&str, &str); 10] = [
    ("async_fn_resumed", "resumed"),
    ("panic_bounds_check", "index"),
    ("slice_index_fail", "slice"),
    ("unwrap_failed", "unwrap"),
    ("expect_failed", "unwrap"),
    ("panic_already", "borrowed"),
    ("div_by_zero", "division"),
    ("rem_by_zero", "division"),
    ("_defmt_panic", "panic"),
    ("panicking", "panic"),
];

/// Whose code, how it may panic, and why it does not. An entry is a kind of a crate, so that a new
/// kind has no entry. `*` is any code. The first that fits counts.
const KNOWN: [(&str, &str, &str); 48] = [
    (
        "*",
        "resumed",
        "an async function that has ended is not polled again: neither executor nor select, join or await do",
    ),
    (
        "firmware",
        "borrowed",
        "borrows end before the function that takes them does, none of which can wait or calls another",
    ),
    (
        "firmware: bin/opencr.rs",
        "unwrap",
        "starting the first task: its pool has room for one, and it is started once",
    ),
    ("firmware: boards/opencr/usb/link.rs", "panic", "static buffers of USB are taken once, at start"),
    ("firmware: bin/opencr.rs", "panic", "statics of the tasks are taken once, at start"),
    (
        "firmware: boards/opencr/mod.rs",
        "panic",
        "the set-up of drivers from constants, inlined: which every start goes through",
    ),
    (
        "firmware: tasks/orient.rs",
        "unwrap",
        "an instant plus a period: 64 bits of microseconds last 584,000 years",
    ),
    (
        "firmware: power_sensors/sensor.rs",
        "panic",
        "the sensor bus is unlocked by the guard that locked it, once",
    ),
    ("defmt", "panic", "what panics without a message ends here"),
    ("defmt-rtt", "panic", "the logger is taken within a critical section and does not log itself"),
    ("embassy-executor", "borrowed", "a task is not polled while it is polled"),
    ("embassy-executor", "panic", "a waker is of a task; sampling is started once"),
    ("embassy-futures", "panic", "a select or join that has ended is not polled again"),
    ("embassy-futures", "unwrap", "likewise: what a select or join takes out is there until it ends"),
    ("futures-util", "panic", "a select or map that has ended is not polled again"),
    ("futures-util", "unwrap", "likewise"),
    ("embassy-hal-internal", "panic", "an interrupt's priority is one of the chip's sixteen, a constant"),
    ("embassy-sync", "borrowed", "a mutex's state is borrowed within a critical section, for no call"),
    ("embassy-sync", "panic", "a mutex is unlocked by the guard that locked it"),
    (
        "embassy-time",
        "unwrap",
        "instants plus constants of seconds: 64 bits of microseconds last 584,000 years",
    ),
    (
        "embassy-stm32",
        "panic",
        "set-up from constants, which every start goes through; DMA sizes and bursts of the drivers' constants; a DMA error is a bus fault at an \
         address, all of which are of statics in SRAM or constants in flash",
    ),
    ("embassy-stm32", "index", "DMA channels and streams that set-up gave, all below the chip's sixteen"),
    ("embassy-stm32", "unwrap", "clocks that set-up has started, and interrupts that it has bound"),
    ("embassy-stm32", "division", "rates and lengths of rings from constants above 0"),
    (
        "embassy-stm32",
        "slice",
        "transfers of the few bytes that the drivers here ask for, within their buffers",
    ),
    ("stm32-metapac", "panic", "indices of registers that the chip has, from constants"),
    // Calls of the crate before, which the linker has made one.
    ("firmware: boards/opencr/time.rs", "panic", "a limit's compare channel is one of 1 to 3, constants"),
    ("stm32-metapac", "index", "likewise"),
    (
        "embassy-usb",
        "borrowed",
        "the waker of a port's control lines is borrowed for one call, on one executor: reset, SET_LINE_CODING and SET_CONTROL_LINE_STATE reach it",
    ),
    (
        "embassy-usb",
        "index",
        "SET_CONFIGURATION and SET_INTERFACE walk the descriptor that set-up wrote, whose interfaces are there; strings of set-up fit the 64 bytes",
    ),
    (
        "embassy-usb",
        "slice",
        "descriptors of set-up, and data of a control transfer, of which the driver gives at most what there is room for and the request names at \
         most the buffer's 64 bytes",
    ),
    (
        "embassy-usb",
        "panic",
        "descriptors of set-up, which every start goes through; packets fit a receiver's buffer of 64 bytes, as the driver leaves out longer ones",
    ),
    (
        "embassy-usb",
        "unwrap",
        "endpoints and interfaces of set-up; a line coding is decoded where seven bytes of it came; the descriptor walked is the one that set-up wrote",
    ),
    ("vqf-rs", "panic", "times and constants of set-up are above 0"),
    ("vqf-rs", "index", "filters have the widths that the crate gives them"),
    ("libm", "index", "indices of its own tables, from parts of a number"),
    ("libm", "panic", "likewise"),
    ("libm", "slice", "likewise"),
    ("embedded-io-async", "panic", "a write takes at least a byte of what it is given, which is not nothing"),
    ("embedded-io-async", "slice", "a write takes at most what it is given"),
    ("embassy-embedded-hal", "panic", "the sensor bus is unlocked by the guard that locked it, once"),
    ("embassy-embedded-hal", "borrowed", "the shared bus's mutex is borrowed within a critical section"),
    ("sequential-storage", "panic", "its own states, which it has read before it uses them"),
    (
        "sequential-storage",
        "slice",
        "lengths come from headers whose CRC was right, and are held against the buffer first",
    ),
    ("sequential-storage", "index", "likewise"),
    ("sequential-storage", "unwrap", "a checksum is made to differ from 0; a buffer is taken once a turn"),
    ("sequential-storage", "division", "sizes of words and pages are constants above 0"),
    ("crc", "index", "a byte is an index of a table of 256"),
];

/// So many calls from one crate, of one kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Sites {
    /// A crate; of our own code with its file.
    pub(super) place: String,
    pub(super) kind: &'static str,
    pub(super) count: usize,
    /// `None` where nothing says why it is not reached.
    pub(super) why: Option<&'static str>,
}

/// All of an image with debug information, in the order of their names.
pub(super) fn sites(elf: &[u8]) -> Result<Vec<Sites>, Stop> {
    let broken = |error: &dyn std::fmt::Display| Stop::new(format!("the image cannot be read: {error}"));
    let file = object::File::parse(elf).map_err(|error| broken(&error))?;
    let ends: BTreeMap<u64, &'static str> = file
        .symbols()
        .filter_map(|symbol| {
            let name = symbol.name().ok()?;
            let kind = KINDS.iter().find(|(word, _)| name.contains(word))?.1;
            // The lowest bit says Thumb.
            (symbol.is_definition() && symbol.kind() == object::SymbolKind::Text)
                .then_some((symbol.address() & !1, kind))
        })
        .collect();
    let lines = lines(&file).map_err(|error| broken(&error))?;
    let mut counts: BTreeMap<(String, &'static str), usize> = BTreeMap::new();
    for section in file.sections().filter(|section| section.kind() == SectionKind::Text) {
        let code = section.data().map_err(|error| broken(&error))?;
        for (address, target) in branches(code, section.address()) {
            if let Some(kind) = ends.get(&target)
                && let Some(place) = place(&lines, address)
            {
                *counts.entry((place, kind)).or_default() += 1;
            }
        }
    }
    let sites =
        counts.into_iter().map(|((place, kind), count)| Sites { why: why(&place, kind), place, kind, count });
    Ok(sites.collect())
}

type Lines<'a> = Context<EndianSlice<'a, RunTimeEndian>>;

fn lines<'a>(file: &object::File<'a>) -> Result<Lines<'a>, addr2line::gimli::Error> {
    let endian = if file.is_little_endian() { RunTimeEndian::Little } else { RunTimeEndian::Big };
    let load = |id: addr2line::gimli::SectionId| -> Result<_, addr2line::gimli::Error> {
        let data = file.section_by_name(id.name()).and_then(|section| section.data().ok());
        Ok(EndianSlice::new(data.unwrap_or_default(), endian))
    };
    Context::from_dwarf(addr2line::gimli::Dwarf::load(load)?)
}

/// Calls and far jumps (BL, B.W: ARMv7-M manual, A7.7.18 and A7.7.12) of Thumb code that begins at
/// `base`: from where, to where.
fn branches(code: &[u8], base: u64) -> impl Iterator<Item = (u64, u64)> + '_ {
    let half = |at: usize| Some(u64::from(u16::from_le_bytes([*code.get(at)?, *code.get(at + 1)?])));
    (0..code.len()).step_by(2).filter_map(move |at| {
        let (first, second) = (half(at)?, half(at + 2)?);
        let is_branch = first & 0xf800 == 0xf000 && (second & 0xd000 == 0xd000 || second & 0xd000 == 0x9000);
        is_branch.then(|| {
            let sign = first >> 10 & 1;
            let bit = |place: u32| !(second >> place ^ sign) & 1;
            let offset =
                sign << 24 | bit(13) << 23 | bit(11) << 22 | (first & 0x3ff) << 12 | (second & 0x7ff) << 1;
            let offset = if sign == 1 { offset.wrapping_sub(1 << 25) } else { offset };
            let address = base + at as u64;
            (address, address.wrapping_add(4).wrapping_add(offset))
        })
    })
}

/// The innermost function around an address that is not the language's own; `None` for the panic
/// machinery itself.
fn place(lines: &Lines<'_>, address: u64) -> Option<String> {
    let mut frames = lines.find_frames(address).skip_all_loads().ok()?;
    while let Ok(Some(frame)) = frames.next() {
        let Some(file) = frame.location.and_then(|location| location.file) else { continue };
        if let Some(place) = owner(file) {
            return Some(place);
        }
    }
    None
}

/// Whose a source file is.
fn owner(file: &str) -> Option<String> {
    if file.contains("/rustc/") || file.contains("/library/core/") || file.contains("/library/alloc/") {
        return None;
    }
    // REGISTRY/name-1.2.3/src/…
    if let Some((_, rest)) = file.split_once("/registry/src/") {
        let package = rest.split('/').nth(1)?;
        let name = package.rsplit_once('-').map_or(package, |(name, _)| name);
        // Its macros stand for whoever uses them.
        return (name != "defmt" || file.ends_with("src/lib.rs")).then(|| name.to_owned());
    }
    if let Some((_, path)) = file.rsplit_once("firmware/src/") {
        return Some(format!("firmware: {path}"));
    }
    if let Some((_, path)) = file.rsplit_once("model-core/src/") {
        return Some(format!("model-core: {path}"));
    }
    // Interrupt handlers and clocks that a build script wrote.
    let (_, built) = file.split_once("/build/")?;
    let package = built.split('/').next()?;
    Some(package.rsplit_once('-').map_or(package, |(name, _)| name).to_owned())
}

/// Why it is not reached.
fn why(place: &str, kind: &str) -> Option<&'static str> {
    let whose = place.split_once(':').map_or(place, |(name, _)| name);
    KNOWN
        .iter()
        .find(|(known, of, _)| ["*", place, whose].contains(known) && *of == kind)
        .map(|(_, _, why)| *why)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As LLVM's disassembler reads them: `bl` forwards by 0x1234 and back by 0x20, `b.w` forwards
    /// by 0x10, and no branch.
    #[test]
    fn branches_are_decoded() {
        let code = |halves: &[u16]| halves.iter().flat_map(|half| half.to_le_bytes()).collect::<Vec<u8>>();
        let to = |halves: &[u16]| branches(&code(halves), 0x0804_0000).collect::<Vec<_>>();
        assert_eq!(to(&[0xf001, 0xf918]), [(0x0804_0000, 0x0804_1234)]);
        assert_eq!(to(&[0xf7ff, 0xffee]), [(0x0804_0000, 0x0803_ffe0)]);
        assert_eq!(to(&[0xf000, 0xb806]), [(0x0804_0000, 0x0804_0010)]);
        assert_eq!(to(&[0xf04f, 0x30ff, 0xbf00]), []);
    }

    #[test]
    fn a_file_has_an_owner() {
        assert_eq!(
            owner("/home/a/.cargo/registry/src/x-1/embassy-usb-0.6.0/src/lib.rs").unwrap(),
            "embassy-usb"
        );
        assert_eq!(owner("/home/a/gmr/firmware/src/wheels/motors.rs").unwrap(), "firmware: wheels/motors.rs");
        assert_eq!(owner("/rustc/5980/library/core/src/cell.rs"), None);
    }

    /// What would be new: an index in our own code.
    #[test]
    fn what_nobody_argued_for_is_unknown() {
        assert!(why("firmware: wheels/motors.rs", "resumed").is_some());
        assert_eq!(why("firmware: wheels/motors.rs", "index"), None);
        assert_eq!(why("model-core: filter.rs", "division"), None);
        assert_eq!(why("heapless", "unwrap"), None);
        // A crate that is argued for in one way has not been in another.
        assert!(why("embassy-sync", "panic").is_some());
        assert_eq!(why("embassy-sync", "index"), None);
    }

    /// No argument speaks of every kind, and none of a kind that there is not.
    #[test]
    fn every_argument_is_about_one_kind() {
        for (whose, kind, why) in KNOWN {
            assert!(KINDS.iter().any(|(_, known)| *known == kind), "{whose}, {kind}");
            assert!(!why.is_empty());
        }
    }
}
