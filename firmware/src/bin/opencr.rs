//! The image for the OpenCR: sets the board up and starts the tasks.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use defmt::info;
    use embassy_executor::Spawner;
    use embassy_time::{Duration, Ticker, with_timeout, Timer, Instant};
    use embedded_hal_async::i2c::I2c;
    use embedded_io_async::{Read, Write};
    use firmware::boards::opencr::{self, SensorBus, ServoPort, UsbDevice, UsbLink};
    use firmware::dynamixel::packet::{Instruction, Parser, encode};
    use firmware::tasks::Connection;

    #[embassy_executor::main]
    async fn main(spawner: Spawner) {
        let board = opencr::init();
        info!("boot");
        spawner.spawn(usb(board.usb).unwrap());
        spawner.spawn(link(board.link).unwrap());
        spawner.spawn(sensors(board.sensors).unwrap());
        spawner.spawn(servos(board.servos).unwrap());
    }

    #[embassy_executor::task]
    async fn usb(mut device: UsbDevice) {
        device.run().await
    }

    #[embassy_executor::task]
    async fn link(mut link: UsbLink) {
        loop {
            link.wait_connection().await;
            let mut buffer = [0; 64];
            while let Ok(count) = link.read(&mut buffer).await {
                if link.write(&buffer[..count]).await.is_err() || link.flush().await.is_err() {
                    break;
                }
            }
        }
    }

    #[embassy_executor::task]
    async fn sensors(mut bus: SensorBus) {
        let mut ticker = Ticker::every(Duration::from_millis(5));
        let (mut ok, mut bad) = (0, 0);
        loop {
            ticker.next().await;
            for register in [2, 1, 3] {
                let mut value = [0; 2];
                match bus.write_read(0x40, &[register], &mut value).await {
                    Ok(()) => ok += 1,
                    Err(e) => {
                        bad += 1;
                        info!("sensor {}", e);
                    }
                }
            }
            if (ok + bad) % 600 == 0 {
                info!("sensors {} {}", ok, bad);
            }
        }
    }

    #[embassy_executor::task]
    async fn servos(mut port: ServoPort) {
        Timer::after_millis(200).await;
        let mut parser = Parser::<128>::default();
        let (mut ok, mut bad) = (0, 0);
        let mut ticker = Ticker::every(Duration::from_millis(5));
        let mut worst = Duration::from_ticks(0);
        loop {
            ticker.next().await;
            let mut buffer = [0; 64];
            let request = encode(254, Instruction::SyncRead, &[&[126, 0, 21, 0, 1, 2]], &mut buffer).unwrap();
            port.write(request).await.unwrap();
            port.flush().await.unwrap();
            let start = Instant::now();
            let mut answers = 0;
            let r = with_timeout(Duration::from_millis(3), async {
                while answers < 2 {
                    let n = port.read(parser.space()).await.unwrap();
                    parser.received(n);
                    while let Some(p) = parser.next_packet() {
                        if p.is_ok() { answers += 1; }
                    }
                }
            }).await;
            worst = worst.max(start.elapsed());
            if r.is_ok() { ok += 1 } else { bad += 1 }
            if (ok + bad) % 200 == 0 {
                info!("servos {} {} {}", ok, bad, worst);
            }
        }
    }
}

/// A host has no board to run this on.
#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this image runs on the board: see .cargo/config.toml");
}
