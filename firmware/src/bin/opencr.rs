//! The image for the OpenCR: sets the board up and starts the tasks.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use embassy_executor::Spawner;
    use firmware::boards::opencr::{Board, Panel, StatusLed, UsbDevice, init, sampling, watchdog};
    use firmware::boards::{send, start};

    firmware::image_tasks!(opencr);

    #[embassy_executor::main]
    async fn main(spawner: Spawner) {
        let (shared, counters, buffers) = statics();
        let Board { sensors, servos, servo_limit, inertial, links, usb, store, status_led, panel, reset } =
            init(counters);
        start(spawner, keep(store, shared));
        let above = sampling();
        send(above, measure(sensors, servos, servo_limit, counters, shared));
        send(above, orient(inertial, shared));
        for ((link, buffers), port) in links.into_iter().zip(buffers).zip(PORTS) {
            start(spawner, serve(link, buffers, shared, port));
        }
        start(spawner, run_usb(usb, shared));
        shared.set_reset(reset);
        start(spawner, blink(status_led));
        start(spawner, panel_task(panel, shared));
        start(spawner, watch(shared));
        start(spawner, stack());
    }

    #[task]
    async fn run_usb(mut usb: UsbDevice, shared: &'static Shared) {
        usb.run(shared).await
    }

    #[task]
    async fn blink(mut led: StatusLed) {
        led.blink().await
    }

    #[task]
    async fn panel_task(mut panel: Panel, shared: &'static Shared) {
        panel.run(shared).await
    }

    #[task]
    async fn watch(shared: &'static Shared) {
        tasks::watch(watchdog::PERIOD, watchdog::feed, shared).await
    }
}

/// A host has no such board.
#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("an image for the OpenCR: build it for thumbv7em-none-eabihf, see docs/board.md");
}
