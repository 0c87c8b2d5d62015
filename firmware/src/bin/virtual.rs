//! The image for the emulator: the same tasks, with a virtual robot at the end of every bus.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use embassy_time::Delay;
    use firmware::boards::virtual_board::{
        Board, InertialPort, Link, SensorBus, ServoPort, StoreFlash, init, run,
    };
    use firmware::boards::{VERIFY, sampler, start, watch_stack};
    use firmware::tasks::{self, Buffers, BusCounters, Records, Reporter, Shared};
    use static_cell::{ConstStaticCell, StaticCell};

    #[cortex_m_rt::entry]
    fn main() -> ! {
        // Of its own, all zero: made with the rest it would pass over the stack.
        static RECORDS: ConstStaticCell<Records> = ConstStaticCell::new([[0; _]; _]);
        static SHARED: StaticCell<Shared> = StaticCell::new();
        static COUNTERS: ConstStaticCell<BusCounters> = ConstStaticCell::new(BusCounters::new());
        static BUFFERS: ConstStaticCell<[Buffers; 2]> = ConstStaticCell::new([const { Buffers::new() }; 2]);

        let (shared, counters) = (&*SHARED.init(Shared::new(RECORDS.take())), &*COUNTERS.take());
        let Board { sensors, servos, inertial, links, store } = init();
        run(|spawner| {
            start(spawner, keep(store, shared));
            start(spawner, measure(sensors, servos, counters, shared));
            start(spawner, orient(inertial, shared));
            let ports = [Reporter::NodePort, Reporter::OwnPort];
            for ((link, buffers), port) in links.into_iter().zip(BUFFERS.take()).zip(ports) {
                start(spawner, serve(link, buffers, shared, port));
            }
            start(spawner, stack());
        })
    }

    #[embassy_executor::task]
    async fn keep(store: StoreFlash, shared: &'static Shared) {
        tasks::keep(store, VERIFY, shared).await
    }

    #[embassy_executor::task]
    async fn measure(
        sensors: SensorBus,
        servos: ServoPort,
        counters: &'static BusCounters,
        shared: &'static Shared,
    ) {
        tasks::measure(sampler(sensors, servos, Delay, counters), counters, shared).await
    }

    #[embassy_executor::task]
    async fn orient(inertial: InertialPort, shared: &'static Shared) {
        tasks::orient(inertial, shared).await
    }

    #[embassy_executor::task(pool_size = 2)]
    async fn serve(link: Link, buffers: &'static mut Buffers, shared: &'static Shared, port: Reporter) {
        tasks::serve(link, buffers, shared, port).await
    }

    #[embassy_executor::task]
    async fn stack() {
        watch_stack().await
    }
}

/// A host has no such board.
#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("an image for the emulator: `gmr board` runs it, see docs/board.md");
}
