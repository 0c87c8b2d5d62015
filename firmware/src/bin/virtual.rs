//! The image for the emulator.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use embassy_sync::blocking_mutex::raw::NoopRawMutex;
    use embassy_sync::mutex::Mutex;
    use embassy_time::{Duration, Ticker,Delay, Instant};
    use firmware::boards::virtual_board::*;
    use firmware::power_sensors::PowerSensors;
    use firmware::dynamixel::bus::*;
    use embassy_embedded_hal::shared_bus::asynch::i2c::I2cDevice;
    use embedded_io_async::{Read,Write};

    #[cortex_m_rt::entry]
    fn main() -> ! {
        let b = init();
        run(|spawner| {
            spawner.spawn(measure(b.sensors, b.servos).unwrap());
            spawner.spawn(link(b.link).unwrap());
        })
    }

    #[embassy_executor::task]
    async fn measure(sensors: SensorBus, servos: ServoPort) {
        let m = Mutex::<NoopRawMutex,_>::new(sensors);
        let mut p = PowerSensors::new([I2cDevice::new(&m),I2cDevice::new(&m),I2cDevice::new(&m),I2cDevice::new(&m)]);
        let mut s = Bus::new(servos, Delay, Timing { baud: 1_000_000, return_delay_us: 500, margin_us: 500});
        let mut ticker = Ticker::every(Duration::from_millis(5));
        let mut n=0;
        loop {
            ticker.next().await;
            let r = p.poll(Instant::now().as_micros()).await;
            let a = s.sync_read::<2,21>(126,[Some(1),Some(2)]).await;
            n+=1;
let _ = (r, a); if n == 400 { panic!("{} {:?} {:?}", n, r.map(|r|r.is_some()), a) }
        }
    }
    #[embassy_executor::task]
    async fn link(mut link: Link) {
        loop {
            let mut buffer = [0; 64];
            while let Ok(count) = link.read(&mut buffer).await {
                let _ = link.write(&buffer[..count]).await;
                link.flush().await;
            }
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this image runs in an emulator");
}
