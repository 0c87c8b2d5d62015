//! What the bootloader leaves running is stopped before anything else runs.
//!
//! The OpenCR's bootloader jumps here with SysTick running and interrupts of its own enabled.
//! Nobody here handles those, and the handler for what nobody handles never returns (docs/board.md,
//! trap A).
//!
//! In assembly, because Rust has no meaning yet: statics are not initialised. `cortex-m-rt` calls
//! `__pre_init` first of all.
#![expect(unsafe_code, reason = "assembly: it writes core registers and touches no memory")]

/// Registers of every Cortex-M7 (ARMv7-M Architecture Reference Manual, B3).
const SYST_CSR: u32 = 0xE000_E010;
const ICSR: u32 = 0xE000_ED04;
const ICSR_PENDSTCLR: u32 = 1 << 25;
/// One bit an interrupt, a word for every 32. The ICPR, which clears those pending, follows at
/// [`ICER_TO_ICPR`].
const NVIC_ICER: u32 = 0xE000_E180;
const ICER_TO_ICPR: u32 = 0x100;
/// For 98 interrupts (RM0385, vector table).
const NVIC_WORDS: u32 = 4;

core::arch::global_asm!(
    ".section .text.__pre_init, \"ax\"",
    ".global __pre_init",
    ".type __pre_init, %function",
    ".thumb_func",
    "__pre_init:",
    "ldr r0, ={syst_csr}",
    "movs r1, #0",
    "str r1, [r0]",
    "ldr r0, ={icer}",
    "mvns r1, r1",
    "movs r2, #{words}",
    "1:",
    "str r1, [r0, #{pending}]",
    "str r1, [r0], #4",
    "subs r2, #1",
    "bne 1b",
    // Last: a SysTick that was pending before it was stopped.
    "ldr r0, ={icsr}",
    "ldr r1, ={pendstclr}",
    "str r1, [r0]",
    "bx lr",
    ".size __pre_init, . - __pre_init",
    syst_csr = const SYST_CSR,
    icer = const NVIC_ICER,
    pending = const ICER_TO_ICPR,
    words = const NVIC_WORDS,
    icsr = const ICSR,
    pendstclr = const ICSR_PENDSTCLR,
);
