//! What the host may change: all of a write is done, or nothing of it.

use super::{State, Upload};
use crate::control_table::{
    Access, CALIBRATE_IMU, COMMAND_TIMEOUT, COMMAND_VELOCITY, END, FIFO_ACKNOWLEDGE, HEARTBEAT, LEDS,
    PREVIOUS_CRC, PROFILE_ACCELERATION, REGISTERS, Register, SOUND, TORQUE_ENABLE, UPLOAD_COMMAND,
    UPLOAD_ITEM, UPLOAD_LENGTH, UPLOAD_SIGNATURE, UPLOAD_WINDOW,
};
use crate::dynamixel::status::Refusal;

const SUBMIT: u8 = 1;
const FORGET: u8 = 2;

/// Writes `data` to the addresses from `address` on. What lies between registers is ignored, as
/// long as there is a register at all.
///
/// # Errors
/// Nothing was changed: [`Refusal::Length`] for no data or a part of a number; [`Refusal::Range`]
/// beyond the table, for unknown commands and for acknowledging what is yet to come;
/// [`Refusal::Access`] for registers that only the board changes, where there is no register, and
/// for the upload while it is waiting to be written.
pub fn write(state: &mut State<'_>, address: u16, data: &[u8]) -> Result<(), Refusal> {
    let request = Request::new(address, data)?;
    let command = request.value(UPLOAD_COMMAND).map(u8::from_le_bytes);
    let item = request.value(UPLOAD_ITEM).map(u8::from_le_bytes);
    let length = request.value(UPLOAD_LENGTH).map(u16::from_le_bytes);
    let window = request.slice(UPLOAD_WINDOW);
    let signature = request.slice(UPLOAD_SIGNATURE);
    let acknowledged = request.value(FIFO_ACKNOWLEDGE).map(u32::from_le_bytes);
    let previous = request.value(PREVIOUS_CRC).map(u32::from_le_bytes);

    if command.is_some_and(|command| command > FORGET)
        || acknowledged.is_some_and(|sequence| !state.fifo.can_acknowledge(sequence))
    {
        return Err(Refusal::Range);
    }
    let changes_upload = item.is_some() || length.is_some() || window.is_some() || signature.is_some();
    if (changes_upload && state.upload.is_waiting())
        || (command == Some(FORGET) && state.upload.is_being_written())
    {
        return Err(Refusal::Access);
    }
    if let Some(crc) = previous {
        // No other register that may be written is near enough for the same request.
        return if state.upload.roll_back(crc, &state.settings) { Ok(()) } else { Err(Refusal::Access) };
    }

    write_drive(state, &request);
    state.upload.item = item.unwrap_or(state.upload.item);
    state.upload.length = length.unwrap_or(state.upload.length);
    let Upload { window: window_bytes, signature: signature_bytes, .. } = &mut state.upload;
    for (bytes, slice) in [(&mut window_bytes[..], window), (&mut signature_bytes[..], signature)] {
        if let Some((offset, data)) = slice {
            bytes.iter_mut().skip(offset).zip(data).for_each(|(place, byte)| *place = *byte);
        }
    }
    if let Some(sequence) = acknowledged {
        state.fifo.acknowledge(sequence);
    }
    match command {
        Some(SUBMIT) => state.upload.submit(&state.settings),
        Some(FORGET) => state.upload.forget(),
        _ => {}
    }
    Ok(())
}

/// What the node writes. Each value counts that the request covers whole.
fn write_drive(state: &mut State<'_>, request: &Request<'_>) {
    let State { pilot, panel, time_us, .. } = state;
    if let Some([value]) = request.value(HEARTBEAT) {
        pilot.beat(value, *time_us);
    }
    if let Some([on]) = request.value(TORQUE_ENABLE) {
        pilot.set_torque(on != 0);
    }
    pilot.command(request.numbers(COMMAND_VELOCITY), *time_us);
    pilot.set_profile(request.numbers(PROFILE_ACCELERATION));
    if let Some(timeout) = request.value(COMMAND_TIMEOUT) {
        pilot.set_command_timeout(u16::from_le_bytes(timeout));
    }
    if let Some((offset, bytes)) = request.slice(LEDS) {
        panel.leds.iter_mut().skip(offset).zip(bytes).for_each(|(place, byte)| *place = *byte);
    }
    if let Some([sound]) = request.value(SOUND) {
        panel.sound = sound;
    }
    if let Some([calibrate]) = request.value(CALIBRATE_IMU) {
        panel.calibrate(calibrate);
    }
}

/// Data for addresses that may be written.
struct Request<'a> {
    address: u16,
    data: &'a [u8],
}

impl<'a> Request<'a> {
    fn new(address: u16, data: &'a [u8]) -> Result<Self, Refusal> {
        if data.is_empty() {
            return Err(Refusal::Length);
        }
        let (first, end) = (usize::from(address), usize::from(address) + data.len());
        if end > usize::from(END) {
            return Err(Refusal::Range);
        }
        let mut has_register = false;
        // They stand by their addresses.
        let behind = REGISTERS.partition_point(|register| usize::from(register.end()) <= first);
        for register in REGISTERS.iter().skip(behind) {
            let (start, stop) = (usize::from(register.address), usize::from(register.end()));
            if start >= end {
                break;
            }
            has_register = true;
            if register.access == Access::Read {
                return Err(Refusal::Access);
            }
            let size = usize::from(register.kind.size());
            let cut = |at: usize| at > start && at < stop && !(at - start).is_multiple_of(size);
            if cut(first) || cut(end) {
                return Err(Refusal::Length);
            }
        }
        // Somebody who drives by registers that other firmware has must not believe that it was
        // done.
        if has_register { Ok(Self { address, data }) } else { Err(Refusal::Access) }
    }

    /// The data for a register of one value.
    fn value<const N: usize>(&self, register: Register) -> Option<[u8; N]> {
        let at = register.address.checked_sub(self.address)?;
        self.data.get(usize::from(at)..)?.first_chunk().copied()
    }

    /// The data for a register of several numbers, those that are whole.
    fn numbers<const N: usize>(&self, register: Register) -> [Option<i32>; N] {
        let mut numbers = [None; N];
        for (number, address) in numbers.iter_mut().zip((register.address..).step_by(size_of::<i32>())) {
            *number = self.value(Register { address, count: 1, ..register }).map(i32::from_le_bytes);
        }
        numbers
    }

    /// The data for a part of an array of bytes, and where in the array it begins.
    fn slice(&self, register: Register) -> Option<(usize, &'a [u8])> {
        let before = usize::from(register.address.saturating_sub(self.address));
        let offset = usize::from(self.address.saturating_sub(register.address));
        let data = self.data.get(before..)?;
        let length = data.len().min(usize::from(register.size()).checked_sub(offset)?);
        data.get(..length).filter(|slice| !slice.is_empty()).map(|slice| (offset, slice))
    }
}
