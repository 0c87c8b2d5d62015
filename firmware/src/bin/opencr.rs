//! The image for the OpenCR: sets the board up and starts the tasks.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use embassy_executor::Spawner;
    use embassy_sync::mutex::Mutex;
    use firmware::boards::opencr::{
        Board, SensorBus, ServoPort, StatusLed, StoreFlash, UsbDevice, UsbLink, init,
    };
    use firmware::boards::{SharedSensorBus, sampler, start, watch_stack};
    use firmware::tasks::{self, Buffers, BusCounters, CountedBus, Shared};
    use static_cell::{ConstStaticCell, StaticCell};

    type Sensors = SharedSensorBus<SensorBus>;

    #[embassy_executor::main]
    async fn main(spawner: Spawner) {
        static SHARED: StaticCell<Shared> = StaticCell::new();
        static COUNTERS: ConstStaticCell<BusCounters> = ConstStaticCell::new(BusCounters::new());
        static SENSORS: StaticCell<Sensors> = StaticCell::new();

        let (shared, counters) = (&*SHARED.init_with(Shared::new), &*COUNTERS.take());
        let Board { sensors, servos, link, usb, store, status_led } = init(counters);
        let sensors = &*SENSORS.init(Mutex::new(CountedBus::new(sensors, counters)));
        start(spawner, keep(store, shared));
        start(spawner, measure(sensors, servos, counters, shared));
        start(spawner, serve(link, shared));
        start(spawner, run_usb(usb));
        start(spawner, blink(status_led));
        start(spawner, stack());
    }

    #[embassy_executor::task]
    async fn keep(store: StoreFlash, shared: &'static Shared) {
        tasks::keep(store, shared).await
    }

    #[embassy_executor::task]
    async fn measure(
        sensors: &'static Sensors,
        servos: ServoPort,
        counters: &'static BusCounters,
        shared: &'static Shared,
    ) {
        tasks::measure(sampler(sensors, servos), counters, shared).await
    }

    #[embassy_executor::task]
    async fn serve(link: UsbLink, shared: &'static Shared) {
        static BUFFERS: ConstStaticCell<Buffers> = ConstStaticCell::new(Buffers::new());
        tasks::serve(link, BUFFERS.take(), shared).await
    }

    #[embassy_executor::task]
    async fn run_usb(mut usb: UsbDevice) {
        usb.run().await
    }

    #[embassy_executor::task]
    async fn blink(mut led: StatusLed) {
        led.blink().await
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
