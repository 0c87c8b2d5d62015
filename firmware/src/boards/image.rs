//! What the images share: their statics, and the tasks of which only the types differ.

/// Statics and tasks of an image for the board whose module below [`crate::boards`] is named. A
/// task has to be of one type each, so they are written where the image is, once for both.
#[macro_export]
macro_rules! image_tasks {
    ($board:ident) => {
        use embassy_executor::task;
        use static_cell::{ConstStaticCell, StaticCell};
        use $crate::boards::$board::{InertialPort, Limit, Link, SensorBus, ServoPort, StoreFlash};
        use $crate::boards::{VERIFY, sampler, watch_stack};
        use $crate::tasks::{self, Buffers, BusCounters, Records, Reporter, Shared};

        /// What tasks share, the buses' counters, and the links' buffers. To be called once.
        fn statics() -> (&'static Shared, &'static BusCounters, &'static mut [Buffers; 2]) {
            // Of its own, all zero: made with the rest it would pass over the stack.
            static RECORDS: ConstStaticCell<Records> = ConstStaticCell::new([[0; _]; _]);
            static SHARED: StaticCell<Shared> = StaticCell::new();
            static COUNTERS: ConstStaticCell<BusCounters> = ConstStaticCell::new(BusCounters::new());
            static BUFFERS: ConstStaticCell<[Buffers; 2]> =
                ConstStaticCell::new([const { Buffers::new() }; 2]);
            (&*SHARED.init(Shared::new(RECORDS.take())), &*COUNTERS.take(), BUFFERS.take())
        }

        #[task]
        async fn keep(store: StoreFlash, shared: &'static Shared) {
            tasks::keep(store, VERIFY, shared).await
        }

        #[task]
        async fn measure(
            sensors: SensorBus,
            servos: ServoPort,
            limit: Limit,
            counters: &'static BusCounters,
            shared: &'static Shared,
        ) {
            tasks::measure(sampler(sensors, servos, limit, counters), counters, shared).await
        }

        #[task]
        async fn orient(inertial: InertialPort, shared: &'static Shared) {
            tasks::orient(inertial, shared).await
        }

        /// The links in the order in which a board gives them.
        const PORTS: [Reporter; 2] = [Reporter::NodePort, Reporter::OwnPort];

        #[task(pool_size = 2)]
        async fn serve(link: Link, buffers: &'static mut Buffers, shared: &'static Shared, port: Reporter) {
            tasks::serve(link, buffers, shared, port).await
        }

        #[task]
        async fn stack() {
            watch_stack().await
        }
    };
}
