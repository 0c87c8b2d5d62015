//! The inertial sensor TDK MPU-9250 as its bus sees it: registers, ranges, and what it feels of the
//! robot.
//!
//! Sources: product specification PS-MPU-9250A-01 and register map RM-MPU-9250A-00. Its
//! magnetometer is not modelled: the firmware does not read it.

/// Registers of the map that do something here.
mod register {
    pub(super) const GYRO_CONFIG: u8 = 0x1B;
    pub(super) const ACCEL_CONFIG: u8 = 0x1C;
    pub(super) const ACCEL_OUT: u8 = 0x3B;
    pub(super) const GYRO_OUT: u8 = 0x43;
    pub(super) const POWER: u8 = 0x6B;
    pub(super) const WHO_AM_I: u8 = 0x75;
}

/// What WHO_AM_I says (register 117).
const IDENTITY: u8 = 0x71;
/// Of the power register after a reset: the best clock (register 107).
const POWER_RESET: u8 = 0x01;
/// Bits of it.
const RESET: u8 = 1 << 7;
const SLEEP: u8 = 1 << 6;
/// Bit of an address that says: read (7.5).
const READ: u8 = 0x80;
/// Registers after the last one of the map do not exist and read 0.
const REGISTERS: usize = 128;

/// Zero-rate output, degrees a second: ±5 at 25 °C (Table 1). A device of the middle.
const BIAS_DEG_S: [f64; 3] = [-3.0, 2.0, 1.5];
/// Noise of a reading behind the filter of 41 Hz that the firmware sets: densities of 0.01 °/s and
/// 300 µg per √Hz (Tables 1 and 2), by the root of the noise bandwidth, 1.57 · 41 Hz.
const NOISE_DEG_S: f64 = 0.080;
const NOISE_G: f64 = 0.002_4;
const GRAVITY_M_S2: f64 = 9.806_65;

/// What the robot does: rotation about its upright axis and acceleration along its way.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Felt {
    /// rad/s, counter-clockwise.
    pub yaw_rad_s: f64,
    /// m/s², forward.
    pub forward_m_s2: f64,
}

/// One chip: x forward, y left, z up, as the OpenCR carries it.
#[derive(Debug, Clone)]
pub struct Mpu9250Chip {
    registers: [u8; REGISTERS],
}

impl Default for Mpu9250Chip {
    fn default() -> Self {
        let mut chip = Self { registers: [0; REGISTERS] };
        chip.reset();
        chip
    }
}

impl Mpu9250Chip {
    fn reset(&mut self) {
        self.registers = [0; REGISTERS];
        self.put(register::WHO_AM_I, &[IDENTITY]);
        self.put(register::POWER, &[POWER_RESET]);
    }

    /// One transaction: an address, then bytes both ways from that register on.
    pub fn transact(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut answer = vec![0; bytes.len()];
        let Some((first, rest)) = bytes.split_first() else { return answer };
        for ((offset, sent), place) in (0..).zip(rest).zip(answer.iter_mut().skip(1)) {
            let register = (first & !READ).wrapping_add(offset) & !READ;
            if first & READ != 0 {
                *place = self.get(register);
            } else if register == register::POWER && sent & RESET != 0 {
                self.reset();
            } else if register != register::WHO_AM_I {
                self.put(register, &[*sent]);
            }
        }
        answer
    }

    /// A new reading, which comes every millisecond as it is set up. `noise` gives a normal deviate
    /// of unit variance.
    pub fn feel(&mut self, felt: Felt, mut noise: impl FnMut() -> f64) {
        if self.get(register::POWER) & SLEEP != 0 {
            return;
        }
        let full_deg_s = f64::from(250_u16 << (self.get(register::GYRO_CONFIG) >> 3 & 3));
        let full_g = f64::from(2_u16 << (self.get(register::ACCEL_CONFIG) >> 3 & 3));
        let rates = [0.0, 0.0, felt.yaw_rad_s.to_degrees()];
        let forces = [felt.forward_m_s2 / GRAVITY_M_S2, 0.0, 1.0];
        let mut counts = |values: [f64; 3], noise_of: f64, full: f64| {
            let mut bytes = [0; 6];
            for (place, value) in bytes.chunks_exact_mut(2).zip(values) {
                let count = ((value + noise_of * noise()) / full * 32_768.0).round();
                place.copy_from_slice(&(count.clamp(-32_768.0, 32_767.0) as i16).to_be_bytes());
            }
            bytes
        };
        let forces = counts(forces, NOISE_G, full_g);
        let rates =
            counts(std::array::from_fn(|axis| rates[axis] + BIAS_DEG_S[axis]), NOISE_DEG_S, full_deg_s);
        self.put(register::ACCEL_OUT, &forces);
        self.put(register::GYRO_OUT, &rates);
    }

    fn get(&self, register: u8) -> u8 {
        self.registers.get(usize::from(register)).copied().unwrap_or(0)
    }

    fn put(&mut self, register: u8, bytes: &[u8]) {
        for (place, byte) in self.registers.iter_mut().skip(usize::from(register)).zip(bytes) {
            *place = *byte;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(chip: &mut Mpu9250Chip, register: u8) -> [i16; 3] {
        let answer = chip.transact(&[register | READ, 0, 0, 0, 0, 0, 0]);
        std::array::from_fn(|axis| i16::from_be_bytes([answer[1 + 2 * axis], answer[2 + 2 * axis]]))
    }

    /// Register map: identity, resets, addresses that count on, and an identity that nobody can
    /// write.
    #[test]
    fn registers_are_those_of_the_map() {
        let mut chip = Mpu9250Chip::default();
        assert_eq!(chip.transact(&[0x75 | READ, 0]), [0, 0x71]);
        assert_eq!(chip.transact(&[0x6B | READ, 0]), [0, 0x01]);
        chip.transact(&[0x1A, 0x03, 0x08, 0x08]);
        chip.transact(&[0x75, 0x00]);
        assert_eq!(chip.transact(&[0x1A | READ, 0, 0, 0]), [0, 0x03, 0x08, 0x08]);
        chip.transact(&[0x6B, 0x80]);
        assert_eq!(chip.transact(&[0x1A | READ, 0, 0, 0]), [0, 0, 0, 0]);
        assert_eq!(chip.transact(&[0x75 | READ, 0]), [0, 0x71]);
    }

    /// Sensitivities (Tables 1 and 2): 131 counts per °/s and 16,384 per g, halved with every
    /// range.
    #[test]
    fn readings_are_in_the_range_that_is_set() {
        for range in 0..4_u8 {
            let mut chip = Mpu9250Chip::default();
            chip.transact(&[0x1B, range << 3, range << 3]);
            let felt = Felt { yaw_rad_s: 10_f64.to_radians(), forward_m_s2: GRAVITY_M_S2 / 2.0 };
            chip.feel(felt, || 0.0);
            let scale = f64::from(1 << range);
            let rate = (10.0 + BIAS_DEG_S[2]) * 32_768.0 / 250.0 / scale;
            assert_eq!(counts(&mut chip, 0x43)[2], rate.round() as i16, "{range}");
            assert_eq!(counts(&mut chip, 0x3B), [(8192.0 / scale) as i16, 0, (16_384.0 / scale) as i16]);
        }
    }

    #[test]
    fn asleep_it_feels_nothing() {
        let mut chip = Mpu9250Chip::default();
        chip.transact(&[0x6B, SLEEP]);
        chip.feel(Felt::default(), || 1.0);
        assert_eq!(counts(&mut chip, 0x3B), [0; 3]);
    }
}
