//! Master of a servo bus: one instruction at a time, its answers within a bounded time.
//!
//! The port turns the direction of the half-duplex line itself: after `write` and `flush`
//! everything is sent and the port listens. A future of the port that is dropped, because its time
//! is over, must leave the port usable.
//!
//! At 1 Mbit/s, with the factory's return delay of 500 µs, a sync read of registers 126 … 146 of
//! two servos takes 16 bytes out (160 µs) and twice 500 µs and 32 bytes (320 µs): 1.8 ms, of the 5
//! ms between samples. Nothing needs changing in the servos for it.

use core::future::ready;

use embassy_futures::select::{Either, select};
use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use super::packet::{BROADCAST, Instruction, OVERHEAD, Parser, encode};
use super::status::{ALERT, Refusal};

/// Longest packet on the bus, either way, stuffing included.
const LONGEST: usize = 64;

/// More bytes than this during one wait are no answer.
const MOST_HEARD: usize = 4 * LONGEST;

/// Most reads that throw away what came unasked.
const MOST_STALE_READS: usize = 8;

/// How long things take on this bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// Bits per second; a byte takes ten.
    pub baud: u32,
    /// What a servo waits before it answers, µs.
    pub return_delay_us: u32,
    /// How much later than it should be an answer may be, µs.
    pub margin_us: u32,
}

impl Timing {
    /// Until so many bytes must have been sent, µs.
    const fn sent_us(&self, bytes: usize) -> u32 {
        // No rate at all is no reason to divide by it.
        let baud = if self.baud == 0 { 1 } else { self.baud };
        (bytes as u32).saturating_mul(10_000_000).div_ceil(baud).saturating_add(self.margin_us)
    }

    /// Until a status with so many data must have come, µs. Stuffing adds a byte to every three at
    /// most.
    const fn answered_us(&self, data: usize) -> u32 {
        self.return_delay_us.saturating_add(self.sent_us(OVERHEAD + 1 + data + data / 3))
    }
}

/// Why there is no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BusError {
    /// None in time.
    Timeout,
    /// A wrong checksum or length.
    Broken,
    /// The servo refuses.
    Refused(Refusal),
    /// From another servo, of another length, or with an error that no servo has.
    Unexpected,
    /// The port reports an error.
    Port,
    /// The packet does not fit the buffer.
    TooLong,
}

/// What a servo answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Answer<const L: usize> {
    /// The registers asked for.
    pub data: [u8; L],
    /// The servo has a hardware error (register 70). The data count all the same.
    pub alert: bool,
}

/// A status as it came.
struct Status<const L: usize> {
    id: u8,
    error: u8,
    /// `None` when their number is another.
    data: Option<[u8; L]>,
}

impl<const L: usize> Status<L> {
    fn check(self) -> Result<Answer<L>, BusError> {
        if self.error & !ALERT != 0 {
            return Err(Refusal::from_error(self.error).map_or(BusError::Unexpected, BusError::Refused));
        }
        let data = self.data.ok_or(BusError::Unexpected)?;
        Ok(Answer { data, alert: self.error & ALERT != 0 })
    }
}

/// The servo bus behind a port.
pub struct Bus<P, D> {
    port: P,
    delay: D,
    timing: Timing,
    parser: Parser<LONGEST>,
    /// Errors of the port while nobody expected anything.
    port_errors: u32,
}

impl<P: Read + Write, D: DelayNs> Bus<P, D> {
    /// A bus that keeps this timing.
    pub fn new(port: P, delay: D, timing: Timing) -> Self {
        Self { port, delay, timing, parser: Parser::default(), port_errors: 0 }
    }

    /// Gives the port back.
    pub fn release(self) -> P {
        self.port
    }

    /// Asks a servo for its model number and firmware version.
    ///
    /// # Errors
    /// There is no valid answer of this servo in time.
    pub async fn ping(&mut self, id: u8) -> Result<(u16, u8), BusError> {
        self.transmit(id, Instruction::Ping, &[]).await?;
        let [low, high, version] = self.answer(id).await?.data;
        Ok((u16::from_le_bytes([low, high]), version))
    }

    /// Reads `L` bytes of a servo's registers.
    ///
    /// # Errors
    /// There is no valid answer of this servo in time, or it refuses.
    pub async fn read<const L: usize>(&mut self, id: u8, address: u16) -> Result<Answer<L>, BusError> {
        self.transmit(id, Instruction::Read, &[&address.to_le_bytes(), &length::<L>()?]).await?;
        self.answer(id).await
    }

    /// Writes to a servo's registers. Tells whether the servo has an alert.
    ///
    /// # Errors
    /// There is no valid answer of this servo in time, or it refuses.
    pub async fn write(&mut self, id: u8, address: u16, data: &[u8]) -> Result<bool, BusError> {
        self.transmit(id, Instruction::Write, &[&address.to_le_bytes(), data]).await?;
        Ok(self.answer::<0>(id).await?.alert)
    }

    /// Restarts a servo.
    ///
    /// # Errors
    /// There is no valid answer of this servo in time, or it refuses.
    pub async fn reboot(&mut self, id: u8) -> Result<(), BusError> {
        self.transmit(id, Instruction::Reboot, &[]).await?;
        self.answer::<0>(id).await.map(|_| ())
    }

    /// Reads the same `L` bytes of several servos' registers with one instruction. `None` leaves a
    /// place out.
    ///
    /// Each servo answers after the one before it in the list, so one that is silent may silence
    /// those behind it: when an answer does not come in time, those still missing are asked one by
    /// one, at once. A silent servo so costs its own answer and time, not the others' answers.
    pub async fn sync_read<const N: usize, const L: usize>(
        &mut self,
        address: u16,
        ids: [Option<u8>; N],
    ) -> [Option<Result<Answer<L>, BusError>>; N] {
        let mut answers = ids.map(|id| id.map(|_| Err(BusError::Timeout)));
        if let Err(error) = self.ask_all::<N, L>(address, ids).await {
            return ids.map(|id| id.map(|_| Err(error)));
        }
        let asked_from = |from: usize| (from..N).find(|place| matches!(ids.get(*place), Some(Some(_))));
        let mut next = 0;
        // Each answer moves `next` on, or is a late one of a servo given up before.
        for _ in 0..2 * N {
            let Some(waiting) = asked_from(next) else { return answers };
            match self.hear::<L>().await {
                Ok(status) => {
                    let from = ids.iter().position(|id| *id == Some(status.id));
                    let answer = if from.is_some() { status.check() } else { Err(BusError::Unexpected) };
                    let place = from.unwrap_or(waiting);
                    put(&mut answers, place, answer);
                    next = next.max(place + 1);
                }
                Err(BusError::Timeout) => {
                    next = waiting + 1;
                    while let Some(place) = asked_from(next) {
                        if let Some(Some(id)) = ids.get(place) {
                            put(&mut answers, place, self.read(*id, address).await);
                        }
                        next = place + 1;
                    }
                }
                Err(error) => {
                    put(&mut answers, waiting, Err(error));
                    next = waiting + 1;
                }
            }
        }
        answers
    }

    /// Writes `L` bytes to the same register of several servos, each its own. Nobody answers: read
    /// back what they took.
    ///
    /// # Errors
    /// It could not be sent.
    pub async fn sync_write<const N: usize, const L: usize>(
        &mut self,
        address: u16,
        values: [(u8, [u8; L]); N],
    ) -> Result<(), BusError> {
        let mut parameters = [0; LONGEST];
        let mut end = 0;
        let address = address.to_le_bytes();
        let length = length::<L>()?;
        let pieces = [&address[..], &length[..]].into_iter();
        for piece in pieces.chain(values.iter().flat_map(|(id, data)| [core::slice::from_ref(id), &data[..]]))
        {
            let place = parameters.get_mut(end..end + piece.len()).ok_or(BusError::TooLong)?;
            place.copy_from_slice(piece);
            end += piece.len();
        }
        let parameters = parameters.get(..end).unwrap_or(&[]);
        self.transmit(BROADCAST, Instruction::SyncWrite, &[parameters]).await
    }

    /// Errors of the port between answers, since somebody asked: noise on the line.
    pub fn take_port_errors(&mut self) -> u32 {
        core::mem::take(&mut self.port_errors)
    }

    /// The port.
    pub fn port(&mut self) -> &mut P {
        &mut self.port
    }

    async fn ask_all<const N: usize, const L: usize>(
        &mut self,
        address: u16,
        ids: [Option<u8>; N],
    ) -> Result<(), BusError> {
        let mut list = [0; N];
        let mut count = 0;
        for (place, id) in list.iter_mut().zip(ids.iter().flatten()) {
            *place = *id;
            count += 1;
        }
        let list = list.get(..count).unwrap_or(&[]);
        if list.is_empty() {
            return Ok(());
        }
        self.transmit(BROADCAST, Instruction::SyncRead, &[&address.to_le_bytes(), &length::<L>()?, list])
            .await
    }

    /// Forgets what came unasked, then sends.
    async fn transmit(
        &mut self,
        id: u8,
        instruction: Instruction,
        parameters: &[&[u8]],
    ) -> Result<(), BusError> {
        self.clear().await;
        let mut buffer = [0; LONGEST];
        let packet = encode(id, instruction, parameters, &mut buffer).map_err(|_| BusError::TooLong)?;
        let limit = self.timing.sent_us(packet.len());
        let outcome = select(send(&mut self.port, packet), self.delay.delay_us(limit)).await;
        match outcome {
            Either::First(sent) => sent,
            Either::Second(()) => Err(BusError::Timeout),
        }
    }

    /// What a servo sent too late must not be taken for its next answer.
    async fn clear(&mut self) {
        self.parser.clear();
        for _ in 0..MOST_STALE_READS {
            let mut stale = [0; LONGEST];
            match select(self.port.read(&mut stale), ready(())).await {
                Either::First(Ok(0)) | Either::Second(()) => break,
                Either::First(Ok(_)) => {}
                Either::First(Err(_)) => self.port_errors = self.port_errors.saturating_add(1),
            }
        }
    }

    /// The answer of one servo. Noise before it and other servos' late answers are passed over
    /// while there is time.
    async fn answer<const L: usize>(&mut self, id: u8) -> Result<Answer<L>, BusError> {
        let mut error = BusError::Timeout;
        let mut budget = MOST_HEARD;
        let listen = async {
            loop {
                match status(&mut self.port, &mut self.parser, &mut budget).await {
                    Ok(status) if status.id == id => return status.check(),
                    Ok(_) => error = BusError::Unexpected,
                    Err(BusError::Broken) if budget > 0 => error = BusError::Broken,
                    Err(other) => return Err(other),
                }
            }
        };
        let outcome = select(listen, self.delay.delay_us(self.timing.answered_us(L))).await;
        match outcome {
            Either::First(answer) => answer,
            Either::Second(()) => Err(error),
        }
    }

    /// The next status, whosever it is.
    async fn hear<const L: usize>(&mut self) -> Result<Status<L>, BusError> {
        let mut budget = MOST_HEARD;
        let listen = status(&mut self.port, &mut self.parser, &mut budget);
        let outcome = select(listen, self.delay.delay_us(self.timing.answered_us(L))).await;
        match outcome {
            Either::First(status) => status,
            Either::Second(()) => Err(BusError::Timeout),
        }
    }
}

async fn send<P: Write>(port: &mut P, mut bytes: &[u8]) -> Result<(), BusError> {
    while !bytes.is_empty() {
        let sent = port.write(bytes).await.map_err(|_| BusError::Port)?;
        match bytes.get(sent..) {
            Some(rest) if sent > 0 => bytes = rest,
            _ => return Err(BusError::Port),
        }
    }
    port.flush().await.map_err(|_| BusError::Port)
}

/// Listens for a status; hears at most `budget` bytes. [`BusError::Broken`] where a packet was, or
/// the budget is used up.
async fn status<P: Read, const L: usize>(
    port: &mut P,
    parser: &mut Parser<LONGEST>,
    budget: &mut usize,
) -> Result<Status<L>, BusError> {
    loop {
        while let Some(packet) = parser.next_packet() {
            let packet = packet.map_err(|_| BusError::Broken)?;
            // Instructions are our own, where the line has an echo.
            if packet.instruction == Instruction::Status as u8
                && let Some((error, data)) = packet.parameters.split_first()
            {
                return Ok(Status { id: packet.id, error: *error, data: data.try_into().ok() });
            }
        }
        if *budget == 0 {
            return Err(BusError::Broken);
        }
        match port.read(parser.space()).await {
            Ok(0) | Err(_) => return Err(BusError::Port),
            Ok(count) => {
                parser.received(count);
                *budget = budget.saturating_sub(count);
            }
        }
    }
}

fn length<const L: usize>() -> Result<[u8; 2], BusError> {
    u16::try_from(L).map(u16::to_le_bytes).map_err(|_| BusError::TooLong)
}

fn put<T>(places: &mut [Option<T>], place: usize, value: T) {
    if let Some(place) = places.get_mut(place) {
        *place = Some(value);
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Patience, Script, Step};
    use super::*;
    use crate::testing::now;

    /// Packets from the e-manual's page on protocol 2.0, of an instruction and its answer each.
    const PING: &[u8] = &[0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x03, 0x00, 0x01, 0x19, 0x4E];
    const PONG: &[u8] = &[0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x07, 0x00, 0x55, 0x00, 0x06, 0x04, 0x26, 0x65, 0x5D];
    const READ: &[u8] = &[0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x07, 0x00, 0x02, 0x84, 0x00, 0x04, 0x00, 0x1D, 0x15];
    const WRITE: &[u8] =
        &[0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x09, 0x00, 0x03, 0x74, 0x00, 0x00, 0x02, 0x00, 0x00, 0xCA, 0x89];
    const REBOOT: &[u8] = &[0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x03, 0x00, 0x08, 0x2F, 0x4E];
    const DONE: &[u8] = &[0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x04, 0x00, 0x55, 0x00, 0xA1, 0x0C];
    const SYNC_READ: &[u8] =
        &[0xFF, 0xFF, 0xFD, 0x00, 0xFE, 0x09, 0x00, 0x82, 0x84, 0x00, 0x04, 0x00, 0x01, 0x02, 0xCE, 0xFA];
    /// Of servo 1 (166) and servo 2 (2079).
    const FIRST: &[u8] =
        &[0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x08, 0x00, 0x55, 0x00, 0xA6, 0x00, 0x00, 0x00, 0x8C, 0xC0];
    const SECOND: &[u8] =
        &[0xFF, 0xFF, 0xFD, 0x00, 0x02, 0x08, 0x00, 0x55, 0x00, 0x1F, 0x08, 0x00, 0x00, 0xBA, 0xBE];

    const TIMING: Timing = Timing { baud: 1_000_000, return_delay_us: 500, margin_us: 500 };
    const POSITION: u16 = 132;

    fn answer(position: u32) -> Result<Answer<4>, BusError> {
        Ok(Answer { data: position.to_le_bytes(), alert: false })
    }

    /// A status with any error and data, checksum and all.
    fn status_of(id: u8, error: u8, data: &[u8]) -> Vec<u8> {
        encode(id, Instruction::Status, &[&[error], data], &mut [0; LONGEST]).unwrap().to_vec()
    }

    fn read_request(id: u8) -> Vec<u8> {
        encode(id, Instruction::Read, &[&[0x84, 0x00, 0x04, 0x00]], &mut [0; LONGEST]).unwrap().to_vec()
    }

    /// Runs `act` on the script, which it has to use up, and gives the time waited in vain, µs.
    fn on<T>(script: Script<'_>, act: impl AsyncFnOnce(&mut Bus<Script<'_>, &Patience>) -> T) -> (T, u64) {
        let patience = Patience::default();
        let mut bus = Bus::new(script, &patience, TIMING);
        let result = now(act(&mut bus));
        bus.release().done();
        (result, patience.0.get())
    }

    fn read_of_one(answers: &[&[u8]]) -> Result<Answer<4>, BusError> {
        on(Script::new(&[(READ, answers)]), async |bus| bus.read::<4>(1, POSITION).await).0
    }

    fn read_of_both(steps: &[Step<'_>]) -> ([Option<Result<Answer<4>, BusError>>; 2], u64) {
        on(Script::new(steps), async |bus| bus.sync_read::<2, 4>(POSITION, [Some(1), Some(2)]).await)
    }

    #[test]
    fn examples_of_the_e_manual() {
        let ping = on(Script::new(&[(PING, &[PONG])]), async |bus| bus.ping(1).await);
        // Model 1030, version 38.
        assert_eq!(ping, (Ok((1030, 38)), 0));
        assert_eq!(read_of_one(&[FIRST]), answer(166));
        let write =
            on(Script::new(&[(WRITE, &[DONE])]), async |bus| bus.write(1, 116, &512_u32.to_le_bytes()).await);
        assert_eq!(write.0, Ok(false));
        assert_eq!(on(Script::new(&[(REBOOT, &[DONE])]), async |bus| bus.reboot(1).await).0, Ok(()));
        assert_eq!(
            read_of_both(&[(SYNC_READ, &[FIRST, SECOND])]),
            ([Some(answer(166)), Some(answer(2079))], 0)
        );
    }

    /// However the bytes are cut, and with both answers in one piece.
    #[test]
    fn answers_come_in_any_pieces() {
        let both = [FIRST, SECOND].concat();
        for cut in 1..both.len() {
            let (one, other) = both.split_at(cut);
            let (answers, _) = read_of_both(&[(SYNC_READ, &[one, other])]);
            assert_eq!(answers, [Some(answer(166)), Some(answer(2079))], "cut at {cut}");
        }
    }

    /// 15 bytes and one of stuffing at 10 µs, the return delay and the margin: 1.16 ms, and it is
    /// over.
    #[test]
    fn silence_costs_a_bounded_time() {
        let silent = on(Script::new(&[(READ, &[])]), async |bus| bus.read::<4>(1, POSITION).await);
        assert_eq!(silent, (Err(BusError::Timeout), 1_160));
        let half = &FIRST[..10];
        assert_eq!(read_of_one(&[half]), Err(BusError::Timeout));
    }

    /// Both of the robot's servos silent at once: 21 data bytes, 0.39 ms with stuffing, twice with
    /// delay and margin.
    #[test]
    fn a_silent_bus_fits_between_two_samples() {
        let patience = Patience::default();
        let mut bus = Bus::new(Silent, &patience, TIMING);
        let answers = now(bus.sync_read::<2, 21>(126, [Some(1), Some(2)]));
        assert_eq!(answers, [Some(Err(BusError::Timeout)); 2]);
        assert_eq!(patience.0.get(), 2 * (390 + 500 + 500));
    }

    #[test]
    fn an_alert_leaves_the_data_valid() {
        let status = status_of(1, ALERT, &166_u32.to_le_bytes());
        assert_eq!(read_of_one(&[&status]), Ok(Answer { data: 166_u32.to_le_bytes(), alert: true }));
    }

    #[test]
    fn refusals() {
        for (error, expected) in [
            (0x04, BusError::Refused(Refusal::Range)),
            (0x80 | 0x07, BusError::Refused(Refusal::Access)),
            (0x7F, BusError::Unexpected),
        ] {
            assert_eq!(read_of_one(&[&status_of(1, error, &[])]), Err(expected), "{error:#x}");
        }
        assert_eq!(read_of_one(&[&status_of(1, 0, &[1, 2, 3])]), Err(BusError::Unexpected));
    }

    /// Any bit of an answer flipped: no wrong number is believed.
    #[test]
    fn broken_answers() {
        for bit in 0..8 * FIRST.len() {
            let mut broken = FIRST.to_vec();
            broken[bit / 8] ^= 1 << (bit % 8);
            let answer = read_of_one(&[&broken]);
            assert!(matches!(answer, Err(BusError::Broken | BusError::Timeout)), "bit {bit}: {answer:?}");
        }
    }

    #[test]
    fn noise_others_and_echoes_before_the_answer_are_passed_over() {
        let noise: &[u8] = &[0xFF, 0xFF, 0xFD, 0x12, 0x00];
        let mut broken = SECOND.to_vec();
        broken[9] ^= 4;
        assert_eq!(read_of_one(&[noise, READ, SECOND, &broken, FIRST]), answer(166));
        assert_eq!(read_of_one(&[SECOND]), Err(BusError::Unexpected));
    }

    /// An answer that came too late is not the answer to the next question.
    #[test]
    fn stale_bytes_are_thrown_away() {
        let script = Script::new(&[(READ, &[FIRST])]).unasked(&status_of(1, 0, &[9; 4])).unasked(&FIRST[..7]);
        assert_eq!(on(script, async |bus| bus.read::<4>(1, POSITION).await).0, answer(166));
        // Neither is what the parser had begun to collect.
        let half = [&FIRST[..7]];
        let script = Script::new(&[(READ, &half), (READ, &[FIRST])]);
        let both =
            on(script, async |bus| [bus.read::<4>(1, POSITION).await, bus.read::<4>(1, POSITION).await]);
        assert_eq!(both.0, [Err(BusError::Timeout), answer(166)]);
        // Nor a whole one that came in one piece with what was waited for.
        let two = [FIRST, &status_of(1, 0, &[9; 4])].concat();
        let two = [&two[..]];
        let script = Script::new(&[(READ, &two), (READ, &[FIRST])]);
        let both =
            on(script, async |bus| [bus.read::<4>(1, POSITION).await, bus.read::<4>(1, POSITION).await]);
        assert_eq!(both.0, [answer(166), answer(166)]);
        // Nor does an error that waited in the port concern it.
        let script = Script::new(&[(READ, &[FIRST])]).failing();
        assert_eq!(on(script, async |bus| bus.read::<4>(1, POSITION).await).0, answer(166));
    }

    /// Who waits for a silent one before it is asked alone.
    #[test]
    fn a_silent_servo_costs_its_own_part() {
        let second = read_request(2);
        let (answers, waited) = read_of_both(&[(SYNC_READ, &[]), (&second, &[SECOND])]);
        assert_eq!(answers, [Some(Err(BusError::Timeout)), Some(answer(2079))]);
        assert_eq!(waited, 1_160);
        // Some do not wait.
        let (answers, waited) = read_of_both(&[(SYNC_READ, &[SECOND])]);
        assert_eq!(answers, [Some(Err(BusError::Timeout)), Some(answer(2079))]);
        assert_eq!(waited, 0);
        let (answers, _) = read_of_both(&[(SYNC_READ, &[FIRST])]);
        assert_eq!(answers, [Some(answer(166)), Some(Err(BusError::Timeout))]);
    }

    #[test]
    fn a_broken_answer_costs_its_own_part() {
        let mut broken = FIRST.to_vec();
        broken[9] ^= 4;
        let (answers, waited) = read_of_both(&[(SYNC_READ, &[&broken, SECOND])]);
        assert_eq!(answers, [Some(Err(BusError::Broken)), Some(answer(2079))]);
        assert_eq!(waited, 0);
        // Noise that looks like a broken packet, then both.
        let (answers, _) = read_of_both(&[(SYNC_READ, &[&broken, FIRST, SECOND])]);
        assert_eq!(answers, [Some(answer(166)), Some(answer(2079))]);
    }

    #[test]
    fn places_left_out_are_not_asked() {
        let request = encode(0xFE, Instruction::SyncRead, &[&[0x84, 0, 4, 0], &[2]], &mut [0; LONGEST])
            .unwrap()
            .to_vec();
        let script = Script::new(&[(&request, &[SECOND])]);
        let (answers, _) = on(script, async |bus| bus.sync_read::<2, 4>(POSITION, [None, Some(2)]).await);
        assert_eq!(answers, [None, Some(answer(2079))]);
        let nobody = on(Script::new(&[]), async |bus| bus.sync_read::<2, 4>(POSITION, [None, None]).await);
        assert_eq!(nobody, ([None, None], 0));
    }

    #[test]
    fn what_does_not_fit_is_not_sent() {
        let (result, _) = on(Script::new(&[]), async |bus| bus.write(1, 0, &[0; LONGEST]).await);
        assert_eq!(result, Err(BusError::TooLong));
    }

    /// A line that never stops: heard for a bounded number of bytes, not for ever.
    #[test]
    fn babble_ends() {
        let patience = Patience::default();
        let mut bus = Bus::new(Babble, &patience, TIMING);
        assert_eq!(now(bus.read::<4>(1, POSITION)), Err(BusError::Broken));
        let answers = now(bus.sync_read::<2, 4>(POSITION, [Some(1), Some(2)]));
        assert_eq!(answers, [Some(Err(BusError::Broken)); 2]);
    }

    struct Silent;
    struct Babble;

    impl embedded_io_async::ErrorType for Silent {
        type Error = embedded_io_async::ErrorKind;
    }
    impl embedded_io_async::ErrorType for Babble {
        type Error = embedded_io_async::ErrorKind;
    }
    impl Write for Silent {
        async fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
            Ok(bytes.len())
        }
        async fn flush(&mut self) -> Result<(), Self::Error> {
            Ok(())
        }
    }
    impl Write for Babble {
        async fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
            Ok(bytes.len())
        }
        async fn flush(&mut self) -> Result<(), Self::Error> {
            Ok(())
        }
    }
    impl Read for Silent {
        async fn read(&mut self, _: &mut [u8]) -> Result<usize, Self::Error> {
            core::future::pending().await
        }
    }
    impl Read for Babble {
        async fn read(&mut self, space: &mut [u8]) -> Result<usize, Self::Error> {
            space.fill(0xFF);
            Ok(space.len())
        }
    }
}
