//! The driver of both chips.
//!
//! Sources: MPU-9250 product specification PS-MPU-9250A-01 and register map RM-MPU-9250A-00;
//! ICM-20648 datasheet DS-000179. Registers up to 1 MHz (MPU-9250, 7.5), modes 0 and 3, first bit
//! of the address 1 for reading.

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::spi::SpiDevice;

use super::ChipModel;

/// A reset takes so long (MPU-9250: 4.18.1, start-up time of registers, at most 100 ms), ms.
const RESET_MS: u32 = 100;
/// The gyroscope's start, ms: 35 typically.
const START_MS: u32 = 50;
/// A chip whose supply broke down measures by other ranges: its set-up is looked at once in so many
/// readings.
const READINGS_PER_LOOK: u8 = 20;
/// Noise moves the last bits all the time: so many equal readings are of a chip that has stopped.
const MOST_EQUAL: u8 = 40;

/// ±500 °/s: a robot that turns on the spot does 151, and a bump does not clip.
const RAD_S_PER_COUNT: f32 = 500.0 / 32_768.0 * core::f32::consts::PI / 180.0;
/// ±4 g.
const M_S2_PER_COUNT: f32 = 4.0 / 32_768.0 * 9.806_65;

/// Bit of a register's address that says: read.
const READ: u8 = 0x80;
/// The ICM-20648's register by which a bank is chosen.
const BANK_SELECT: u8 = 0x7F;

/// Why there is no reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The bus reported an error, or took too long.
    Bus,
    /// None of the known chips answers.
    Absent,
    /// It does not hold what it was told: its supply broke down.
    SetUpLost,
    /// It answers, always the same.
    Stuck,
}

/// What the sensor felt, by its own axes: on the board x forward, y left, z up, as the stock
/// firmware takes them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// rad/s, bias included.
    pub angular_velocity: [f32; 3],
    /// m/s²; at rest gravity's reaction, upwards.
    pub acceleration: [f32; 3],
}

/// A register and what it is to hold.
struct Setting {
    bank: u8,
    register: u8,
    value: u8,
}

const fn setting(bank: u8, register: u8, value: u8) -> Setting {
    Setting { bank, register, value }
}

impl ChipModel {
    const ALL: [Self; 2] = [Self::Mpu9250, Self::Icm20648];

    /// Register of the identity, and what it says.
    const fn identity(self) -> (u8, u8) {
        match self {
            Self::Mpu9250 => (0x75, 0x71),
            Self::Icm20648 => (0x00, 0xE0),
        }
    }

    /// Register by which everything is reset.
    const fn power(self) -> u8 {
        match self {
            Self::Mpu9250 => 0x6B,
            Self::Icm20648 => 0x06,
        }
    }

    /// After a reset: no I²C, clock by the gyroscope, a reading each millisecond behind some 41 to
    /// 51 Hz, ±500 °/s, ±4 g.
    const fn settings(self) -> &'static [Setting] {
        match self {
            Self::Mpu9250 => {
                &const {
                    [
                        setting(0, 0x6A, 0x10),
                        setting(0, 0x6B, 0x01),
                        setting(0, 0x19, 0x00),
                        setting(0, 0x1A, 0x03),
                        setting(0, 0x1B, 0x08),
                        setting(0, 0x1C, 0x08),
                        setting(0, 0x1D, 0x03),
                    ]
                }
            }
            Self::Icm20648 => {
                &const {
                    [
                        setting(0, 0x03, 0x10),
                        setting(0, 0x06, 0x01),
                        setting(0, 0x07, 0x00),
                        setting(2, 0x00, 0x00),
                        setting(2, 0x01, 0x1B),
                        setting(2, 0x14, 0x1B),
                    ]
                }
            }
        }
    }

    /// First register of a reading, and where in it acceleration and rotation begin.
    const fn reading(self) -> (u8, usize, usize) {
        match self {
            // Acceleration, temperature, rotation.
            Self::Mpu9250 => (0x3B, 0, 8),
            Self::Icm20648 => (0x2D, 0, 6),
        }
    }

    const fn has_banks(self) -> bool {
        matches!(self, Self::Icm20648)
    }
}

/// The sensor on its bus.
pub struct Chip<S> {
    spi: S,
    model: Option<ChipModel>,
    readings: u8,
    last: [u8; READING],
    equal: u8,
}

/// Bytes of a reading with its address.
const READING: usize = 1 + 14;

impl<S: SpiDevice> Chip<S> {
    /// Nothing is sent yet.
    pub const fn new(spi: S) -> Self {
        Self { spi, model: None, readings: 0, last: [0; READING], equal: 0 }
    }

    /// Asks which chip there is, resets it and sets it up: 0.2 s.
    ///
    /// # Errors
    /// None answers, the bus fails, or the chip does not take its set-up.
    pub async fn start(&mut self, delay: &mut impl DelayNs) -> Result<ChipModel, Fault> {
        self.model = None;
        for model in ChipModel::ALL {
            if model.has_banks() {
                self.write(BANK_SELECT, 0).await?;
            }
            let (register, identity) = model.identity();
            if self.read(register).await? != identity {
                continue;
            }
            self.write(model.power(), 0x80).await?;
            delay.delay_ms(RESET_MS).await;
            for setting in model.settings() {
                self.choose(model, setting.bank).await?;
                self.write(setting.register, setting.value).await?;
            }
            self.choose(model, 0).await?;
            delay.delay_ms(START_MS).await;
            self.check(model).await?;
            (self.model, self.readings, self.equal) = (Some(model), 0, 0);
            return Ok(model);
        }
        Err(Fault::Absent)
    }

    /// What it feels now.
    ///
    /// # Errors
    /// [`Self::start`] has to follow.
    pub async fn motion(&mut self) -> Result<Motion, Fault> {
        let motion = self.read_motion().await;
        if motion.is_err() {
            self.model = None;
        }
        motion
    }

    async fn read_motion(&mut self) -> Result<Motion, Fault> {
        let model = self.model.ok_or(Fault::Absent)?;
        self.readings += 1;
        if self.readings >= READINGS_PER_LOOK {
            self.readings = 0;
            self.check(model).await?;
        }
        let (register, acceleration, rotation) = model.reading();
        let mut bytes = [0; READING];
        if let Some(first) = bytes.first_mut() {
            *first = register | READ;
        }
        self.spi.transfer_in_place(&mut bytes).await.map_err(|_| Fault::Bus)?;
        let same = bytes.get(1..) == self.last.get(1..);
        self.equal = if same { self.equal.saturating_add(1) } else { 0 };
        self.last = bytes;
        if self.equal >= MOST_EQUAL {
            return Err(Fault::Stuck);
        }
        let data = bytes.get(1..).unwrap_or(&[]);
        Ok(Motion {
            angular_velocity: axes(data, rotation).map(|count| f32::from(count) * RAD_S_PER_COUNT),
            acceleration: axes(data, acceleration).map(|count| f32::from(count) * M_S2_PER_COUNT),
        })
    }

    /// Whether it is that chip still, and holds its set-up.
    async fn check(&mut self, model: ChipModel) -> Result<(), Fault> {
        let mut holds = true;
        for setting in model.settings() {
            self.choose(model, setting.bank).await?;
            holds &= self.read(setting.register).await? == setting.value;
        }
        self.choose(model, 0).await?;
        let (register, identity) = model.identity();
        holds &= self.read(register).await? == identity;
        if holds { Ok(()) } else { Err(Fault::SetUpLost) }
    }

    async fn choose(&mut self, model: ChipModel, bank: u8) -> Result<(), Fault> {
        if model.has_banks() { self.write(BANK_SELECT, bank << 4).await } else { Ok(()) }
    }

    async fn write(&mut self, register: u8, value: u8) -> Result<(), Fault> {
        self.spi.transfer_in_place(&mut [register, value]).await.map_err(|_| Fault::Bus)
    }

    async fn read(&mut self, register: u8) -> Result<u8, Fault> {
        let mut bytes = [register | READ, 0];
        self.spi.transfer_in_place(&mut bytes).await.map_err(|_| Fault::Bus)?;
        let [_, value] = bytes;
        Ok(value)
    }
}

/// Three counts from here on, high byte first.
fn axes(data: &[u8], from: usize) -> [i16; 3] {
    let mut axes = [0; 3];
    let pairs = data.get(from..).unwrap_or(&[]).as_chunks::<2>().0;
    for (axis, pair) in axes.iter_mut().zip(pairs) {
        *axis = i16::from_be_bytes(*pair);
    }
    axes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inertial::testing::{Bus, Nothing};
    use crate::testing::now;

    /// By the datasheets' sensitivities: 65.5 counts per °/s, 8192 per g.
    #[test]
    fn both_chips_are_known_set_up_and_read() {
        for model in ChipModel::ALL {
            let bus = Bus::new(model);
            let mut chip = Chip::new(&bus);
            assert_eq!(now(chip.motion()), Err(Fault::Absent));
            assert_eq!(now(chip.start(&mut Nothing)), Ok(model));
            bus.feel([655, -1310, 65], [0, 8192, -8192]);
            let motion = now(chip.motion()).unwrap();
            let degrees = motion.angular_velocity.map(|rate| rate.to_degrees());
            for (rate, expected) in degrees.into_iter().zip([10.0, -20.0, 0.992]) {
                assert!((rate - expected).abs() < 0.02, "{degrees:?}");
            }
            for (axis, expected) in motion.acceleration.into_iter().zip([0.0, 9.806_65, -9.806_65]) {
                assert!((axis - expected).abs() < 1e-4, "{motion:?}");
            }
        }
    }

    #[test]
    fn nobody_there_is_no_chip() {
        let bus = Bus::new(ChipModel::Mpu9250);
        for (answers, fault) in [(Some(0x00), Fault::Absent), (Some(0xFF), Fault::Absent), (None, Fault::Bus)]
        {
            bus.break_off(answers);
            assert_eq!(now(Chip::new(&bus).start(&mut Nothing)), Err(fault));
        }
    }

    /// Within twenty readings, a tenth of a second, though it goes on answering: by its old ranges
    /// it would be off by a factor.
    #[test]
    fn a_brown_out_is_noticed_and_mended() {
        for model in ChipModel::ALL {
            let bus = Bus::new(model);
            let mut chip = Chip::new(&bus);
            now(chip.start(&mut Nothing)).unwrap();
            let mut readings = 0..20;
            let mut read = |chip: &mut Chip<_>| {
                bus.feel([readings.next().unwrap_or(20), 0, 0], [0, 0, 8192]);
                now(chip.motion())
            };
            assert!((0..5).all(|_| read(&mut chip).is_ok()));
            bus.power_up();
            assert!((0..20).any(|_| read(&mut chip) == Err(Fault::SetUpLost)));
            assert_eq!(read(&mut chip), Err(Fault::Absent));
            assert_eq!(now(chip.start(&mut Nothing)), Ok(model));
            assert!(read(&mut chip).is_ok());
        }
    }

    #[test]
    fn a_reading_that_never_changes_is_none() {
        let bus = Bus::new(ChipModel::Icm20648);
        let mut chip = Chip::new(&bus);
        now(chip.start(&mut Nothing)).unwrap();
        bus.feel([3, 4, 5], [0, 0, 8000]);
        let first = (0..100).position(|_| now(chip.motion()) == Err(Fault::Stuck));
        assert_eq!(first, Some(usize::from(MOST_EQUAL)));
    }
}
