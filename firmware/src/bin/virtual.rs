//! The image for the emulator: the same tasks, with a virtual robot at the end of every bus.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use firmware::boards::start;
    use firmware::boards::virtual_board::{Board, init, run};

    firmware::image_tasks!(virtual_board);

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let (shared, counters, buffers) = statics();
        let Board { sensors, servos, servo_limit, inertial, links, store } = init();
        run(|spawner| {
            start(spawner, keep(store, shared));
            start(spawner, measure(sensors, servos, servo_limit, counters, shared));
            start(spawner, orient(inertial, shared));
            for ((link, buffers), port) in links.into_iter().zip(buffers).zip(PORTS) {
                start(spawner, serve(link, buffers, shared, port));
            }
            start(spawner, stack());
        })
    }
}

/// A host has no such board.
#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("an image for the emulator: `gmr board` runs it, see docs/board.md");
}
