//! The image for the OpenCR: sets the board up and starts the tasks.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use embassy_executor::Spawner;
    use firmware::boards::opencr::{
        Board, InertialPort, Limit, Panel, SensorBus, ServoPort, StatusLed, StoreFlash, UsbDevice, UsbLink,
        init, sampling, watchdog,
    };
    use firmware::boards::{VERIFY, sampler, send, start, watch_stack};
    use firmware::tasks::{self, Buffers, BusCounters, Records, Reporter, Shared};
    use static_cell::{ConstStaticCell, StaticCell};

    #[embassy_executor::main]
    async fn main(spawner: Spawner) {
        // Of its own, all zero: made with the rest it would pass over the stack.
        static RECORDS: ConstStaticCell<Records> = ConstStaticCell::new([[0; _]; _]);
        static SHARED: StaticCell<Shared> = StaticCell::new();
        static COUNTERS: ConstStaticCell<BusCounters> = ConstStaticCell::new(BusCounters::new());
        static BUFFERS: ConstStaticCell<[Buffers; 2]> = ConstStaticCell::new([const { Buffers::new() }; 2]);

        let (shared, counters) = (&*SHARED.init(Shared::new(RECORDS.take())), &*COUNTERS.take());
        let Board { sensors, servos, servo_limit, inertial, links, usb, store, status_led, panel, reset } =
            init(counters);
        start(spawner, keep(store, shared));
        let above = sampling();
        send(above, measure(sensors, servos, servo_limit, counters, shared));
        send(above, orient(inertial, shared));
        let ports = [Reporter::NodePort, Reporter::OwnPort];
        for ((link, buffers), port) in links.into_iter().zip(BUFFERS.take()).zip(ports) {
            start(spawner, serve(link, buffers, shared, port));
        }
        start(spawner, run_usb(usb, shared));
        shared.set_reset(reset);
        start(spawner, blink(status_led));
        start(spawner, panel_task(panel, shared));
        start(spawner, watch(shared));
        start(spawner, stack());
    }

    #[embassy_executor::task]
    async fn keep(store: StoreFlash, shared: &'static Shared) {
        tasks::keep(store, VERIFY, shared).await
    }

    #[embassy_executor::task]
    async fn measure(
        sensors: SensorBus,
        servos: ServoPort,
        limit: Limit,
        counters: &'static BusCounters,
        shared: &'static Shared,
    ) {
        tasks::measure(sampler(sensors, servos, limit, counters), counters, shared).await
    }

    #[embassy_executor::task(pool_size = 2)]
    async fn serve(link: UsbLink, buffers: &'static mut Buffers, shared: &'static Shared, port: Reporter) {
        tasks::serve(link, buffers, shared, port).await
    }

    #[embassy_executor::task]
    async fn orient(inertial: InertialPort, shared: &'static Shared) {
        tasks::orient(inertial, shared).await
    }

    #[embassy_executor::task]
    async fn run_usb(mut usb: UsbDevice, shared: &'static Shared) {
        usb.run(shared).await
    }

    #[embassy_executor::task]
    async fn blink(mut led: StatusLed) {
        led.blink().await
    }

    #[embassy_executor::task]
    async fn panel_task(mut panel: Panel, shared: &'static Shared) {
        panel.run(shared).await
    }

    #[embassy_executor::task]
    async fn watch(shared: &'static Shared) {
        tasks::watch(watchdog::PERIOD, watchdog::feed, shared).await
    }

    #[embassy_executor::task]
    async fn stack() {
        watch_stack().await
    }
}

/// A host has no such board.
#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("an image for the OpenCR: build it for thumbv7em-none-eabihf, see docs/board.md");
}
