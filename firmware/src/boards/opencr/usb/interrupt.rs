//! USB's interrupt: takes what the host sends, and notes what it did.

use embassy_stm32::interrupt::typelevel;
use embassy_stm32::pac::USB_OTG_FS as OTG;
use embassy_stm32::pac::otg::vals::Pktstsd;

use super::hardware;
use super::state::STATE;

/// The handler.
pub(in crate::boards::opencr) struct Interrupt;

#[expect(unsafe_code, reason = "the HAL declares handlers unsafe; this one is called for its interrupt only")]
impl typelevel::Handler<typelevel::OTG_FS> for Interrupt {
    unsafe fn on_interrupt() {
        let raised = OTG.gintsts().read();
        if raised.usbrst() {
            OTG.gintsts().write(|register| register.set_usbrst(true));
            hardware::reset();
            STATE.reset();
        }
        if raised.enumdne() {
            // Full speed, the only one there is: the control pipe's packets have 64 bytes, which is
            // the value after reset.
            OTG.gintsts().write(|register| register.set_enumdne(true));
        }
        while OTG.gintsts().read().rxflvl() {
            receive();
        }
        look_at_endpoints();
    }
}

/// Takes one entry out of the receive FIFO.
fn receive() {
    let status = OTG.grxstsp().read();
    let index = usize::from(status.epnum());
    match status.pktstsd() {
        Pktstsd::SETUP_DATA_RX => {
            let packet = hardware::receive(usize::from(status.bcnt()));
            // A SETUP packet ends what was under way (USB 2.0, 8.5.3), whether it is a good one or
            // not.
            hardware::abandon(0);
            STATE.control().clear();
            STATE.stage_setup(packet.and_then(|packet| packet.setup()).filter(|_| index == 0));
        }
        Pktstsd::OUT_DATA_RX => {
            let packet = hardware::receive(usize::from(status.bcnt()));
            if let Some(endpoint) = STATE.endpoint(index) {
                endpoint.stage(packet);
            }
        }
        // The end of a transfer raises its endpoint's interrupt; of anything else there is nothing
        // to take.
        _ => {}
    }
}

fn look_at_endpoints() {
    let raised = OTG.daint().read();
    for (index, endpoint) in STATE.endpoints() {
        if raised.iepint() >> index & 1 == 1 {
            let flags = OTG.diepint(index).read();
            OTG.diepint(index).write_value(flags);
            endpoint.to_host.wake();
        }
        if raised.oepint() >> index & 1 == 1 {
            let flags = OTG.doepint(index).read();
            OTG.doepint(index).write_value(flags);
            if index == 0 && flags.stup() {
                hardware::expect_setup();
                STATE.publish_setup();
            }
            if flags.xfrc() {
                endpoint.publish();
            }
        }
    }
}
