//! What the image puts where: the OpenCR's bootloader starts whatever stands at 0x0804_0000, and a
//! wrong address would overwrite it or the store.
//!
//! Sources: stock linker script and bootloader (ROBOTIS-GIT/OpenCR), RM0385 (memory map, vector
//! table).

mod common;

use std::ops::Range;

use object::elf::{PF_X, PT_LOAD};
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{LittleEndian, Object, ObjectSection, ObjectSymbol};

/// The application's sectors, 5 to 7.
const APPLICATION: Range<u32> = 0x0804_0000..0x0810_0000;
const DTCM: Range<u32> = 0x2000_0000..0x2001_0000;
/// SRAM1 and SRAM2.
const SRAM: Range<u32> = 0x2001_0000..0x2005_0000;
/// Core exceptions and 98 interrupts.
const VECTORS: usize = 16 + 98;

type Elf<'data> = ElfFile32<'data, LittleEndian>;

fn with_image(test: impl FnOnce(&Elf<'_>)) {
    let bytes = std::fs::read(common::opencr()).expect("the image can be read");
    test(&Elf::parse(&*bytes).expect("the image is an ELF"));
}

fn section<'data>(elf: &Elf<'data>, name: &str) -> (u32, &'data [u8]) {
    let section = elf.section_by_name(name).unwrap_or_else(|| panic!("no section {name}"));
    (section.address() as u32, section.data().expect("it is in the file"))
}

/// The address of a function, without the bit that says it is Thumb code.
fn function(elf: &Elf<'_>, name: &str) -> u32 {
    let symbol = elf.symbols().find(|symbol| symbol.name() == Ok(name));
    symbol.unwrap_or_else(|| panic!("no function {name}")).address() as u32 & !1
}

fn vectors(elf: &Elf<'_>) -> (u32, Vec<u32>) {
    let (address, bytes) = section(elf, ".vector_table");
    (address, bytes.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect())
}

#[test]
fn the_vector_table_is_where_the_bootloader_jumps() {
    with_image(|elf| {
        let (address, vectors) = vectors(elf);
        assert_eq!(address, APPLICATION.start);
        assert_eq!(vectors.len(), VECTORS);
        let [stack, reset] = vectors[..2] else { unreachable!() };
        assert_eq!(stack, DTCM.end, "the stack begins at the end of DTCM and grows down");
        assert_eq!(reset & !1, elf.entry() as u32 & !1);
        assert!(
            vectors[1..].iter().all(|&v| v == 0 || (v & 1 == 1 && APPLICATION.contains(&v))),
            "{vectors:x?}"
        );
    });
}

/// Where segments are written to (their physical address), not where they are used.
#[test]
fn nothing_is_written_outside_the_application() {
    with_image(|elf| {
        let mut written = 0;
        for segment in elf.elf_program_headers() {
            let (start, length) = (segment.p_paddr(LittleEndian), segment.p_filesz(LittleEndian));
            if segment.p_type(LittleEndian) != PT_LOAD || length == 0 {
                continue;
            }
            written += length;
            assert!(
                APPLICATION.contains(&start) && start + length <= APPLICATION.end,
                "{start:#x}, {length} bytes"
            );
        }
        assert!(written > 10_000, "an image of {written} bytes");
    });
}

/// DMA only reaches statics, the futures of the tasks among them; and these are where DMA reaches
/// them at any time.
#[test]
fn statics_are_in_sram_and_nothing_but_the_stack_in_dtcm() {
    with_image(|elf| {
        for segment in elf.elf_program_headers() {
            let (start, length) = (segment.p_vaddr(LittleEndian), segment.p_memsz(LittleEndian));
            if segment.p_type(LittleEndian) != PT_LOAD || APPLICATION.contains(&start) || length == 0 {
                continue;
            }
            assert!(SRAM.contains(&start) && start + length <= SRAM.end, "{start:#x}, {length} bytes");
            assert_eq!(segment.p_flags(LittleEndian) & PF_X, PF_X & segment.p_flags(LittleEndian));
        }
        for name in [".data", ".bss"] {
            let section = elf.section_by_name(name).unwrap();
            assert!(SRAM.contains(&(section.address() as u32)), "{name}");
            assert!(section.size() > 0, "{name}");
        }
    });
}

/// Trap A of the bootloader: it leaves SysTick running. Our code stops it before anything else
/// runs.
#[test]
fn what_the_bootloader_left_running_is_stopped_first() {
    with_image(|elf| {
        let pre_init = function(elf, "__pre_init");
        let (start, text) = section(elf, ".text");
        let at = (pre_init - start) as usize;
        let body = &text[at..at + 64];
        // The runtime's own does nothing: it has no addresses.
        for register in [0xE000_E010_u32, 0xE000_ED04, 0xE000_E180] {
            assert!(
                body.windows(4).any(|word| word == register.to_le_bytes()),
                "SYST_CSR, ICSR and NVIC_ICER are written: no {register:#x} in {body:x?}"
            );
        }
    });
}

/// Every interrupt that a driver enables has its handler in the table.
#[test]
fn the_drivers_interrupts_have_handlers() {
    // I2C1 event and error; USART3; TIM5; UART4, of the executor that samples; DMA2 stream 0, of
    // the inertial sensor; OTG_FS. The servo port's DMA ends with USART3's idle line.
    const USED: [usize; 7] = [31, 32, 39, 50, 52, 56, 67];
    with_image(|elf| {
        let (_, vectors) = vectors(elf);
        let default = function(elf, "DefaultHandler");
        for interrupt in USED {
            let handler = vectors[16 + interrupt] & !1;
            assert!(handler != 0 && handler != default, "interrupt {interrupt}");
        }
    });
}
