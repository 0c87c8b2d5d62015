//! The robot's end of the exchange with the virtual board: requests in, answers out. No I/O; see
//! [`firmware::exchange`].

use std::collections::VecDeque;

use firmware::exchange::{Kind, LONGEST_FRAME, NOTICE_LINK, NOTICE_NODE};
use support::error::{Error, Result};

use super::flash::{Refused, VirtualFlash};
use super::lockstep::Truth;
use super::robot::VirtualRobot;

/// Bytes before the body of a request: kind and time.
const REQUEST_HEAD: usize = 1 + 8;

/// Everything that the board's requests are answered from.
#[derive(Debug)]
pub struct ExchangeServer {
    /// Plant, sensors, servos.
    pub robot: VirtualRobot,
    /// The store's sectors.
    pub flash: VirtualFlash,
    /// Bytes from the host that the board has not fetched.
    pub to_board: VecDeque<u8>,
    /// Bytes from the board that the host has not taken.
    pub from_board: VecDeque<u8>,
    /// The same on the port of the ROS node.
    pub node_to_board: VecDeque<u8>,
    /// Likewise.
    pub node_from_board: VecDeque<u8>,
    /// When the last request was made, µs of the board's clock.
    board_us: u64,
    exchanges: u64,
    truths: Option<Truths>,
}

/// What was true, at regular times.
#[derive(Debug)]
struct Truths {
    period_us: u64,
    next_us: u64,
    taken: Vec<Truth>,
}

impl ExchangeServer {
    /// A robot and the flash of its board.
    pub fn new(robot: VirtualRobot, flash: VirtualFlash) -> Self {
        Self {
            robot,
            flash,
            to_board: VecDeque::new(),
            from_board: VecDeque::new(),
            node_to_board: VecDeque::new(),
            node_from_board: VecDeque::new(),
            board_us: 0,
            exchanges: 0,
            truths: None,
        }
    }

    /// Notes the truth every `period_us` from now on, for [`Self::take_truths`].
    pub fn note_truths(&mut self, period_us: u64) {
        let next_us = self.robot.now_us().next_multiple_of(period_us);
        self.truths = Some(Truths { period_us, next_us, taken: Vec::new() });
    }

    /// Whether something has been noted since the last time.
    pub fn has_truths(&self) -> bool {
        self.truths.as_ref().is_some_and(|truths| !truths.taken.is_empty())
    }

    /// What has been noted since the last time.
    pub fn take_truths(&mut self) -> Vec<Truth> {
        self.truths.as_mut().map_or_else(Vec::new, |truths| std::mem::take(&mut truths.taken))
    }

    /// The board's clock at its last request, µs.
    pub fn board_us(&self) -> u64 {
        self.board_us
    }

    /// Requests answered.
    pub fn exchanges(&self) -> u64 {
        self.exchanges
    }

    /// Answers a request (without its length) with a whole frame (with its length).
    ///
    /// # Errors
    /// The request is none; the flash's file cannot be written.
    pub fn answer(&mut self, request: &[u8], frame: &mut Vec<u8>) -> Result<()> {
        let strange = || {
            let shown: Vec<u8> = request.iter().copied().take(16).collect();
            Error::failed(format!(
                "the virtual board sent a request of {} bytes that is none ({shown:02x?} …): is its image of another version?",
                request.len()
            ))
        };
        let (head, body) = request.split_at_checked(REQUEST_HEAD).ok_or_else(strange)?;
        let (&[code], time) = head.split_first_chunk().ok_or_else(strange)?;
        let kind = Kind::from_code(code).ok_or_else(strange)?;
        let time_us = u64::from_le_bytes(time.try_into().map_err(|_| strange())?);
        self.advance_to(time_us);
        self.exchanges += 1;

        frame.clear();
        // Length and notices come last.
        frame.extend([0; 3]);
        let done = |result: std::result::Result<(), Refused>| u8::from(result.is_err());
        match kind {
            Kind::I2c => {
                let [address, count, bytes @ ..] = body else { return Err(strange()) };
                frame.push(0);
                let from = frame.len();
                frame.resize(from + usize::from(*count), 0);
                frame[from - 1] = self.robot.i2c(*address, bytes, &mut frame[from..]) as u8;
            }
            Kind::Servo => {
                let answer = self.robot.servo(body);
                frame.extend(answer.delay_us.to_le_bytes());
                frame.extend(answer.bytes);
            }
            Kind::Link | Kind::NodeLink => {
                let (to_board, from_board) = match kind {
                    Kind::Link => (&mut self.to_board, &mut self.from_board),
                    _ => (&mut self.node_to_board, &mut self.node_from_board),
                };
                let (room, bytes) = body.split_first_chunk().ok_or_else(strange)?;
                from_board.extend(bytes);
                let room = usize::from(u16::from_le_bytes(*room)).min(LONGEST_FRAME - 1);
                frame.extend(to_board.drain(..room.min(to_board.len())));
            }
            Kind::ServoSupply => {
                let &[on] = body else { return Err(strange()) };
                self.robot.set_servo_supply(on != 0);
            }
            Kind::Inertial => frame.extend(self.robot.inertial(body)),
            Kind::FlashRead => {
                let &[a, b, c, d, low, high] = body else { return Err(strange()) };
                let (offset, count) = (u32::from_le_bytes([a, b, c, d]), u16::from_le_bytes([low, high]));
                // Beyond its end there is nothing: an empty answer.
                frame.extend(self.flash.read(offset, usize::from(count)).unwrap_or(&[]));
            }
            Kind::FlashWrite => {
                let (offset, bytes) = body.split_first_chunk().ok_or_else(strange)?;
                frame.push(done(self.flash.write(u32::from_le_bytes(*offset), bytes)?));
            }
            Kind::FlashErase => {
                let &[a, b, c, d, e, f, g, h] = body else { return Err(strange()) };
                let (from, to) = (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
                frame.push(done(self.flash.erase(from, to)?));
            }
        }
        let length = frame.len() - 2;
        if length > LONGEST_FRAME {
            return Err(strange());
        }
        frame[..2].copy_from_slice(&(length as u16).to_le_bytes());
        frame[2] = if self.to_board.is_empty() { 0 } else { NOTICE_LINK };
        frame[2] |= if self.node_to_board.is_empty() { 0 } else { NOTICE_NODE };
        Ok(())
    }

    fn advance_to(&mut self, time_us: u64) {
        self.board_us = self.board_us.max(time_us);
        if let Some(truths) = &mut self.truths {
            while truths.next_us <= time_us {
                self.robot.advance_to(truths.next_us);
                truths.taken.push(self.robot.truth());
                truths.next_us += truths.period_us;
            }
        }
        self.robot.advance_to(time_us);
    }
}

#[cfg(test)]
mod tests {
    use plant::{Kinematics, PlantSet, ProfileKind, Scenario};

    use super::*;
    use crate::robot::RobotOptions;

    fn server() -> ExchangeServer {
        let scenario =
            Scenario::new(PlantSet::Servo, Kinematics::Differential, ProfileKind::Standstill, 10.0, 1);
        let robot = VirtualRobot::new(scenario, RobotOptions::default()).unwrap();
        ExchangeServer::new(robot, VirtualFlash::default())
    }

    /// Notices and body of the answer.
    fn ask(server: &mut ExchangeServer, kind: Kind, time_us: u64, body: &[u8]) -> (u8, Vec<u8>) {
        let request = [&[kind as u8][..], &time_us.to_le_bytes(), body].concat();
        let mut frame = Vec::new();
        server.answer(&request, &mut frame).unwrap();
        assert_eq!(usize::from(u16::from_le_bytes([frame[0], frame[1]])), frame.len() - 2);
        (frame[2], frame[3..].to_vec())
    }

    #[test]
    fn every_kind_is_answered() {
        let mut server = server();
        // Configuration after power-on.
        assert_eq!(ask(&mut server, Kind::I2c, 0, &[0x40, 2, 0]), (0, vec![0, 0x39, 0x9F]));
        assert_eq!(ask(&mut server, Kind::I2c, 0, &[0x50, 2, 0]).1[0], 1);
        assert_eq!(ask(&mut server, Kind::Inertial, 0, &[0xF5, 0]).1, [0, 0x71]);
        let ping = [0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x03, 0x00, 0x01, 0x19, 0x4E];
        let (_, answer) = ask(&mut server, Kind::Servo, 1000, &ping);
        assert_eq!(
            (answer[..4].to_vec(), answer.len()),
            (vec![0x58, 2, 0, 0], 4 + 14),
            "600 µs, then a status"
        );
        assert_eq!((server.robot.now_us(), server.board_us()), (1000, 1000));
        let mut write = 16_u32.to_le_bytes().to_vec();
        write.extend([7; 16]);
        assert_eq!(ask(&mut server, Kind::FlashWrite, 1000, &write), (0, vec![0]));
        write[0] = 17;
        assert_eq!(ask(&mut server, Kind::FlashWrite, 1000, &write), (0, vec![1]));
        assert_eq!(ask(&mut server, Kind::FlashRead, 1000, &[15, 0, 0, 0, 2, 0]), (0, vec![0xFF, 7]));
        assert_eq!(ask(&mut server, Kind::FlashErase, 1000, &[0, 0, 0, 0, 0, 0x80, 0, 0]), (0, vec![0]));
        assert_eq!(ask(&mut server, Kind::FlashRead, 1000, &[16, 0, 0, 0, 1, 0]), (0, vec![0xFF]));
    }

    /// What does not fit the board's room stays, and the notice with it.
    #[test]
    fn the_link_carries_both_ways_and_loses_nothing() {
        let mut server = server();
        server.to_board.extend([1, 2, 3]);
        assert_eq!(ask(&mut server, Kind::I2c, 0, &[0x40, 0, 0]), (NOTICE_LINK, vec![0]));
        assert_eq!(ask(&mut server, Kind::Link, 0, &[2, 0, 9, 8]), (NOTICE_LINK, vec![1, 2]));
        assert_eq!(ask(&mut server, Kind::Link, 0, &[0xFF, 0xFF]), (0, vec![3]));
        assert_eq!(server.from_board, [9, 8]);
    }

    #[test]
    fn what_is_no_request_is_refused() {
        let mut server = server();
        let good = [&[Kind::FlashErase as u8][..], &[0; 8], &[0; 8]].concat();
        assert!(server.answer(&good, &mut Vec::new()).is_ok());
        for cut in 0..good.len() {
            assert!(server.answer(&good[..cut], &mut Vec::new()).is_err(), "{cut}");
        }
        let unknown = [&[99][..], &[0; 8]].concat();
        assert!(
            server.answer(&unknown, &mut Vec::new()).unwrap_err().to_string().contains("another version")
        );
    }

    /// At every period, whatever the times of the requests.
    #[test]
    fn truths_are_noted_at_their_times() {
        let mut server = server();
        server.note_truths(5000);
        for time_us in [3, 5001, 17_000, 17_000, 20_000] {
            ask(&mut server, Kind::I2c, time_us, &[0x40, 2, 0]);
        }
        let times: Vec<u64> = server.take_truths().iter().map(|truth| truth.time_us).collect();
        assert_eq!(times, [0, 5000, 10_000, 15_000, 20_000]);
        assert_eq!(server.take_truths(), []);
        assert_eq!(server.exchanges(), 5);
    }
}
