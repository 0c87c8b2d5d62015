//! Registers of OTG_FS: the sequences that the manual asks for, none of which waits without end.

use embassy_stm32::Peri;
use embassy_stm32::gpio::{AfType, Flex, OutputType, Speed};
use embassy_stm32::interrupt::typelevel::{self, Interrupt};
use embassy_stm32::pac::otg::regs::{Fifo, Gintsts};
use embassy_stm32::pac::otg::vals::{Dspd, Eptyp, Pfivl};
use embassy_stm32::pac::{RCC, USB_OTG_FS as OTG};
use embassy_stm32::peripherals::{PA11, PA12};
use embassy_time::Timer;

use super::state::Packet;
use super::{DATA_TO_HOST, ENDPOINTS, PACKET_BYTES, TRANSFER_BYTES};

/// Of a function of the pins: OTG_FS (datasheet, alternate functions).
const ALTERNATE_FUNCTION: u8 = 10;
/// Longer than a transaction of 64 bytes takes at full speed: 50 µs, 11,000 cycles, of which a look
/// takes six at least.
const MOST_LOOKS: u32 = 2_000;
/// The core takes up to 25 ms to become a device (RM0385, OTG_GUSBCFG, FDMOD).
const MOST_MODE_MS: u32 = 30;
/// For an AHB clock above 32 MHz (RM0385, TRDT values).
const TURNAROUND: u8 = 6;
/// SETUP packets that may come one behind the other.
const SETUP_PACKETS: u8 = 3;

/// Words of the FIFOs, 320 in all. Received: room for three SETUP packets, two packets of 64 bytes,
/// and their status (RM0385, device FIFO RAM allocation: 10 + 2 · 17 + 2 · 2 + 1), doubled. Sent:
/// what each endpoint may hand over at once.
const RECEIVE_WORDS: u16 = 98;
const _: () = assert!(RECEIVE_WORDS + send_words_before(ENDPOINTS) <= 320);

/// Bytes that this endpoint may hand over at once.
pub(super) const fn most_bytes(index: usize) -> usize {
    let [first, second] = DATA_TO_HOST;
    if index == first || index == second { TRANSFER_BYTES } else { PACKET_BYTES }
}

/// Of all endpoints below this one.
const fn send_words_before(index: usize) -> u16 {
    let (mut words, mut below) = (0, 0);
    while below < index {
        words += most_bytes(below) as u16 / 4;
        below += 1;
    }
    words
}

fn wait_for(holds: impl Fn() -> bool) {
    let _ = (0..MOST_LOOKS).any(|_| holds());
}

/// Gives the pins to the peripheral, for good.
pub(super) fn take_pins(plus: Peri<'static, PA12>, minus: Peri<'static, PA11>) {
    for mut pin in [Flex::new(plus), Flex::new(minus)] {
        pin.set_as_af_unchecked(ALTERNATE_FUNCTION, AfType::output(OutputType::PushPull, Speed::VeryHigh));
        // Dropped, it would be disconnected.
        core::mem::forget(pin);
    }
}

/// Sets the peripheral up and connects to the bus.
#[expect(unsafe_code, reason = "enables an interrupt: no critical section relies on its being masked")]
pub(super) async fn start() {
    RCC.ahb2enr().modify(|register| register.set_usb_otg_fsen(true));
    // Enabled clocks take two cycles.
    cortex_m::asm::dsb();
    RCC.ahb2rstr().modify(|register| register.set_usb_otg_fsrst(true));
    RCC.ahb2rstr().modify(|register| register.set_usb_otg_fsrst(false));
    wait_for(|| OTG.grstctl().read().ahbidl());
    OTG.gusbcfg().write(|register| {
        register.set_fdmod(true);
        register.set_physel(true);
        register.set_trdt(TURNAROUND);
    });
    for _ in 0..MOST_MODE_MS {
        if !OTG.gintsts().read().cmod() {
            break;
        }
        Timer::after_millis(1).await;
    }
    // The transceiver on. The bus's supply is wired to PD3, not to the pin that the peripheral
    // watches: as if it were there.
    OTG.gccfg_v2().modify(|register| {
        register.set_pwrdwn(true);
        register.set_vbden(false);
    });
    OTG.gotgctl().modify(|register| {
        register.set_bvaloen(true);
        register.set_bvaloval(true);
    });
    OTG.dctl().write(|register| register.set_sdis(true));
    OTG.dcfg().write(|register| {
        register.set_pfivl(Pfivl::FRAME_INTERVAL_80);
        register.set_dspd(Dspd::FULL_SPEED_INTERNAL);
    });
    share_memory();
    OTG.diepmsk().write(|register| register.set_xfrcm(true));
    OTG.doepmsk().write(|register| {
        register.set_xfrcm(true);
        register.set_stupm(true);
    });
    OTG.daintmsk().write(|register| {
        register.set_iepm((1 << ENDPOINTS) - 1);
        register.set_oepm((1 << ENDPOINTS) - 1);
    });
    OTG.gintsts().write_value(Gintsts(u32::MAX));
    OTG.gintmsk().write(|register| {
        register.set_usbrst(true);
        register.set_enumdnem(true);
        register.set_rxflvlm(true);
        register.set_iepint(true);
        register.set_oepint(true);
    });
    OTG.gahbcfg().write(|register| register.set_gint(true));
    // SAFETY: see above.
    unsafe { typelevel::OTG_FS::enable() };
    OTG.dctl().write(|register| register.set_sdis(false));
}

/// One FIFO for all that is received, one for each endpoint that sends.
fn share_memory() {
    OTG.grxfsiz().write(|register| register.set_rxfd(RECEIVE_WORDS));
    for index in 0..ENDPOINTS {
        let place = if index == 0 { OTG.dieptxf0() } else { OTG.dieptxf(index - 1) };
        place.write(|register| {
            register.set_sa(RECEIVE_WORDS + send_words_before(index));
            register.set_fd(most_bytes(index) as u16 / 4);
        });
    }
}

/// As a bus reset leaves a device: no address, no endpoint but the control pipe's, nothing sent or
/// received.
pub(super) fn reset() {
    critical_section::with(|_| {
        for index in 0..ENDPOINTS {
            abandon(index);
            if index > 0 {
                OTG.diepctl(index).modify(|register| register.set_usbaep(false));
                OTG.doepctl(index).modify(|register| {
                    register.set_snak(true);
                    register.set_usbaep(false);
                });
            }
        }
        OTG.grstctl().write(|register| register.set_rxfflsh(true));
        wait_for(|| !OTG.grstctl().read().rxfflsh());
        OTG.dcfg().modify(|register| register.set_dad(0));
        expect_setup();
    });
}

/// The device's address, from the status stage on.
pub(super) fn set_address(address: u8) {
    OTG.dcfg().modify(|register| register.set_dad(address));
}

/// SETUP packets may come.
pub(super) fn expect_setup() {
    OTG.doeptsiz(0).write(|register| {
        register.set_rxdpid_stupcnt(SETUP_PACKETS);
        register.set_pktcnt(1);
        register.set_xfrsiz(PACKET_BYTES as u32);
    });
}

/// Answers the control transfer by a stall, which the next SETUP packet ends.
pub(super) fn reject() {
    OTG.diepctl(0).modify(|register| register.set_stall(true));
    OTG.doepctl(0).modify(|register| register.set_stall(true));
}

/// Lets the endpoint take a packet.
pub(super) fn arm(index: usize) {
    critical_section::with(|_| {
        // A transfer that is set up already waits only for its acknowledgements.
        if OTG.doeptsiz(index).read().pktcnt() == 0 {
            OTG.doeptsiz(index).modify(|register| {
                register.set_pktcnt(1);
                register.set_xfrsiz(PACKET_BYTES as u32);
            });
        }
        OTG.doepctl(index).modify(|register| {
            register.set_cnak(true);
            register.set_epena(true);
        });
    });
}

/// Whether what was last sent has been fetched, all of it, or taken back.
pub(super) fn is_sent(index: usize) -> bool {
    !OTG.diepctl(index).read().epena()
}

/// Whether the host has set the endpoint that sends up.
pub(super) fn sends(index: usize) -> bool {
    OTG.diepctl(index).read().usbaep()
}

/// Whether it has set up the one that receives.
pub(super) fn receives(index: usize) -> bool {
    OTG.doepctl(index).read().usbaep()
}

/// Hands the host these bytes, [`most_bytes`] at most, in as many packets as they take: one where
/// there are none. To be called with interrupts masked: the FIFO must not be written while other
/// registers are accessed (erratum 2.15.2, "transmit data FIFO is corrupted").
pub(super) fn send(index: usize, bytes: &[u8]) {
    OTG.dieptsiz(index).write(|register| {
        register.set_mcnt(1);
        register.set_pktcnt(bytes.len().div_ceil(PACKET_BYTES).max(1) as u16);
        register.set_xfrsiz(bytes.len() as u32);
    });
    OTG.diepctl(index).modify(|register| {
        register.set_cnak(true);
        register.set_epena(true);
    });
    let (words, rest) = bytes.as_chunks();
    for word in words {
        OTG.fifo(index).write_value(Fifo(u32::from_le_bytes(*word)));
    }
    if !rest.is_empty() {
        let last = rest.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
        OTG.fifo(index).write_value(Fifo(last));
    }
}

/// Takes the packet that stands first in the FIFO; of one that is too long for any, nothing is
/// kept.
pub(super) fn receive(length: usize) -> Option<Packet> {
    let mut bytes = [0; PACKET_BYTES];
    let mut places = bytes.as_chunks_mut().0.iter_mut();
    for _ in 0..length.div_ceil(4) {
        let word = OTG.fifo(0).read().0.to_le_bytes();
        if let Some(place) = places.next() {
            *place = word;
        }
    }
    Packet::new(bytes, length)
}

/// Takes back what the endpoint holds for a host that has not fetched it (RM0385, IN endpoint
/// disable), and empties its FIFO.
///
/// A closed port and a bus reset leave an endpoint enabled.
pub(super) fn abandon(index: usize) {
    let (control, raised) = (OTG.diepctl(index), OTG.diepint(index));
    // The FIFO must not be written meanwhile.
    critical_section::with(|_| {
        if control.read().epena() {
            // A SETUP packet has the core refuse already.
            if !control.read().naksts() {
                control.modify(|register| register.set_snak(true));
                wait_for(|| raised.read().inepne());
            }
            control.modify(|register| {
                register.set_snak(true);
                register.set_epdis(true);
            });
            wait_for(|| raised.read().epdisd() || !control.read().epena());
            raised.write(|register| register.set_epdisd(true));
        }
        OTG.grstctl().write(|register| {
            register.set_txfflsh(true);
            register.set_txfnum(index as u8);
        });
        wait_for(|| !OTG.grstctl().read().txfflsh());
    });
}

/// The host sets an endpoint up, its first packet the even one, or down.
pub(super) fn enable_sending(index: usize, kind: Option<Eptyp>) {
    abandon(index);
    critical_section::with(|_| {
        OTG.diepctl(index).write(|register| {
            register.set_snak(true);
            if let Some(kind) = kind {
                register.set_usbaep(true);
                register.set_mpsiz(PACKET_BYTES as u16);
                register.set_eptyp(kind);
                register.set_txfnum(index as u8);
                register.set_sd0pid_sevnfrm(true);
            }
        });
    });
}

/// As [`enable_sending`], of one that receives.
pub(super) fn enable_receiving(index: usize, kind: Option<Eptyp>) {
    critical_section::with(|_| {
        OTG.doepctl(index).modify(|register| {
            register.set_snak(kind.is_none());
            register.set_stall(false);
            register.set_usbaep(kind.is_some());
            if let Some(kind) = kind {
                register.set_mpsiz(PACKET_BYTES as u16);
                register.set_eptyp(kind);
                register.set_sd0pid_sevnfrm(true);
            }
        });
    });
    if kind.is_some() {
        arm(index);
    }
}

/// Stalls an endpoint that sends. Where the stall ends, the next packet is the even one (USB 2.0,
/// 9.4.5).
pub(super) fn stall_sending(index: usize, stalled: bool) {
    critical_section::with(|_| {
        OTG.diepctl(index).modify(|register| {
            register.set_stall(stalled);
            register.set_sd0pid_sevnfrm(!stalled && index > 0);
        });
    });
}

/// As [`stall_sending`], of one that receives.
pub(super) fn stall_receiving(index: usize, stalled: bool) {
    critical_section::with(|_| {
        OTG.doepctl(index).modify(|register| {
            register.set_stall(stalled);
            register.set_sd0pid_sevnfrm(!stalled && index > 0);
        });
    });
}

/// Whether it is stalled.
pub(super) fn is_sending_stalled(index: usize) -> bool {
    OTG.diepctl(index).read().stall()
}

/// Whether it is stalled.
pub(super) fn is_receiving_stalled(index: usize) -> bool {
    OTG.doepctl(index).read().stall()
}
