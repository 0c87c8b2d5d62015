//! Takes back what an IN endpoint holds for a host that does not fetch it.
//!
//! The driver leaves an endpoint enabled over a bus reset and a closed port, and then waits for it without end.

use embassy_stm32::pac::USB_OTG_FS;

/// Far longer than a transaction on the bus takes; a core without a bus answers at once.
const MOST_LOOKS: u32 = 20_000;

/// Disables a transfer that waits (RM0385, OTG: IN endpoint disable), and empties its FIFO.
pub(super) fn abandon(endpoint: usize) {
    let control = USB_OTG_FS.diepctl(endpoint);
    let raised = USB_OTG_FS.diepint(endpoint);
    // The FIFO must not be written meanwhile.
    critical_section::with(|_| {
        if control.read().epena() {
            control.modify(|register| register.set_snak(true));
            wait_for(|| raised.read().inepne());
            control.modify(|register| {
                register.set_snak(true);
                register.set_epdis(true);
            });
            wait_for(|| raised.read().epdisd() || !control.read().epena());
            raised.write(|register| register.set_epdisd(true));
        }
        USB_OTG_FS.grstctl().write(|register| {
            register.set_txfflsh(true);
            register.set_txfnum(endpoint as u8);
        });
        wait_for(|| !USB_OTG_FS.grstctl().read().txfflsh());
    });
}

fn wait_for(holds: impl Fn() -> bool) {
    let _ = (0..MOST_LOOKS).any(|_| holds());
}
