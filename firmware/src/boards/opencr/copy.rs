//! Copies memory by words.
//!
//! What the compiler brings along copies fewer than sixteen bytes one by one, and more by one word
//! a turn, of four instructions. A tick copies some 4 KB of futures, records and packets, and a
//! host's read of all registers 18 KB more. These take their place in the image: the compiler's are
//! weak. Memory is normal memory everywhere, where this core loads and stores words at any address;
//! several at once only at those of words, which the names with a number promise.
#![expect(
    unsafe_code,
    reason = "the run-time ABI's functions, by their contract: memory of both is theirs, apart, so many bytes of it"
)]

use core::arch::global_asm;

global_asm!(
    ".syntax unified",
    ".thumb",
    ".p2align 2",
    ".global __aeabi_memcpy4, __aeabi_memcpy8, __aeabi_memcpy, memcpy",
    ".type __aeabi_memcpy4, %function",
    ".type __aeabi_memcpy8, %function",
    ".type __aeabi_memcpy, %function",
    ".type memcpy, %function",
    // Of whole words: eight a turn, the rest as any other.
    "__aeabi_memcpy4:",
    "__aeabi_memcpy8:",
    "    subs r2, r2, #32",
    "    blo 2f",
    "    push {{r4, r5, r6, r7, r8, lr}}",
    "1:  ldmia r1!, {{r3, r4, r5, r6, r7, r8, ip, lr}}",
    "    stmia r0!, {{r3, r4, r5, r6, r7, r8, ip, lr}}",
    "    subs r2, r2, #32",
    "    bhs 1b",
    "    pop {{r4, r5, r6, r7, r8, lr}}",
    "2:  adds r2, r2, #32",
    // Of any address. r0, which `memcpy` gives back, stays.
    "__aeabi_memcpy:",
    "memcpy:",
    "    mov ip, r0",
    "    subs r2, r2, #16",
    "    blo 4f",
    "3:  ldr r3, [r1], #4",
    "    str r3, [ip], #4",
    "    ldr r3, [r1], #4",
    "    str r3, [ip], #4",
    "    ldr r3, [r1], #4",
    "    str r3, [ip], #4",
    "    ldr r3, [r1], #4",
    "    str r3, [ip], #4",
    "    subs r2, r2, #16",
    "    bhs 3b",
    "4:  adds r2, r2, #16",
    "    beq 5f",
    // Eight bytes where the carry says so, four where the sign does; then two, and one.
    "    lsls r3, r2, #29",
    "    itttt cs",
    "    ldrcs r3, [r1], #4",
    "    strcs r3, [ip], #4",
    "    ldrcs r3, [r1], #4",
    "    strcs r3, [ip], #4",
    "    itt mi",
    "    ldrmi r3, [r1], #4",
    "    strmi r3, [ip], #4",
    "    lsls r3, r2, #31",
    "    itt cs",
    "    ldrhcs r3, [r1], #2",
    "    strhcs r3, [ip], #2",
    "    itt mi",
    "    ldrbmi r3, [r1]",
    "    strbmi r3, [ip]",
    "5:  bx lr",
    ".size memcpy, . - memcpy",
);
