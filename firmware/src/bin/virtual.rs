//! The image for the emulator.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use embassy_time::{Duration, Ticker};
    use firmware::boards::virtual_board::{self, Robot};

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let robot = virtual_board::init();
        virtual_board::run(|spawner| {
            spawner.spawn(measure(robot).unwrap());
        })
    }

    #[embassy_executor::task]
    async fn measure(mut robot: Robot) {
        let mut ticker = Ticker::every(Duration::from_millis(5));
        loop {
            ticker.next().await;
            for i in 0..14 {
                robot.test(&[0x40, 2, i]);
            }
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this image runs in an emulator");
}
