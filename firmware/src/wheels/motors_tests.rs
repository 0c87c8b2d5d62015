//! The motors on a bus of servos with control tables.

use super::*;
use crate::drive::Orders;
use crate::dynamixel::testing::{Patience, Servos};
use crate::dynamixel::xl430::TRIPPED;
use crate::testing::now;

const STEP_US: u64 = 5_000;
const FORWARD: Orders = Orders { goals: [100, 120], torque: true, profile: [0; 2] };

type Board<'a> = Wheels<&'a Servos, &'a Patience>;

fn board(servos: &Servos) -> Board<'_> {
    Wheels::new(servos, &servos.patience)
}

/// Samples `from` to `to`.
fn run(wheels: &mut Board<'_>, orders: &Orders, from: u64, to: u64) {
    for i in from..to {
        now(wheels.poll(STEP_US * i));
        now(wheels.drive(STEP_US * i, orders));
    }
}

fn goals(servos: &Servos) -> [i32; 2] {
    servos.servos.borrow().each_ref().map(|servo| servo.goal())
}

fn torque(servos: &Servos) -> [bool; 2] {
    servos.servos.borrow().each_ref().map(|servo| servo.has_torque())
}

fn table(servos: &Servos, servo: usize, address: usize) -> u8 {
    servos.servos.borrow()[servo].table[address]
}

/// Within a fifth of a second from the start.
fn driving(servos: &Servos) -> Board<'_> {
    let mut wheels = board(servos);
    run(&mut wheels, &FORWARD, 0, 40);
    assert_eq!((wheels.drive_state(), goals(servos)), (DriveState::Ready, [100, 120]));
    wheels
}

#[test]
fn from_the_start_to_driving() {
    let servos = Servos::new();
    let wheels = driving(&servos);
    assert!(wheels.has_torque() && torque(&servos) == [true; 2]);
    assert_eq!([table(&servos, 0, 98), table(&servos, 1, 98)], [10, 10]);
    assert_eq!(wheels.counters().unverified, 0);
}

#[test]
fn a_new_goal_is_on_the_bus_with_the_next_sample() {
    let servos = Servos::new();
    let mut wheels = driving(&servos);
    run(&mut wheels, &Orders { goals: [-50, 300], ..FORWARD }, 40, 41);
    // Register 44 is 265.
    assert_eq!((goals(&servos), wheels.goals()), ([-50, 265], [-50, 265]));
    now(wheels.hurry(STEP_US * 40 + 2_500, &Orders { goals: [0; 2], ..FORWARD }));
    assert_eq!(goals(&servos), [0, 0]);
}

#[test]
fn without_orders_nothing_is_written() {
    let servos = Servos::new();
    let mut wheels = board(&servos);
    run(&mut wheels, &Orders::NONE, 0, 200);
    assert_eq!((torque(&servos), wheels.drive_state()), ([false; 2], DriveState::Off));
    let sent = servos.instructions.borrow();
    assert!(sent.iter().all(|code| [0x01, 0x02, 0x82].contains(code)), "{sent:?}");
}

#[test]
fn torque_is_switched_off_as_asked_and_on_again() {
    let servos = Servos::new();
    let mut wheels = driving(&servos);
    run(&mut wheels, &Orders { torque: false, ..FORWARD }, 40, 45);
    assert_eq!((torque(&servos), goals(&servos)), ([false; 2], [0; 2]));
    assert_eq!(wheels.drive_state(), DriveState::Off);
    run(&mut wheels, &Orders { profile: [20, 30], ..FORWARD }, 45, 80);
    assert_eq!((torque(&servos), goals(&servos)), ([true; 2], [100, 120]));
    assert_eq!([table(&servos, 0, 108), table(&servos, 1, 108)], [20, 30]);
}

/// Each register that would make the wheel do something else than asked.
#[test]
fn a_servo_that_is_set_up_otherwise_gets_no_torque() {
    for (address, value) in [(9, 254), (10, 0), (10, 5), (11, 3), (44, 0), (68, 1)] {
        let servos = Servos::new();
        let at = usize::from(address);
        servos.servos.borrow_mut()[1].table[at] = value;
        servos.servos.borrow_mut()[1].table[45] = 0;
        if address != 44 {
            servos.servos.borrow_mut()[1].table[44] = 200;
        }
        let mut wheels = board(&servos);
        run(&mut wheels, &FORWARD, 0, 60);
        assert_eq!((torque(&servos), wheels.drive_state()), ([false; 2], DriveState::Unfit), "{address}");
        assert_eq!(wheels.statuses().map(|status| status.misfit), [0, address]);
    }
}

/// A servo that answers nonsense, beside one that is set up as needed, so that goals are sent to
/// both.
#[test]
fn a_negative_limit_is_none() {
    for limit in [-5, i32::MIN] {
        let servos = Servos::new();
        servos.servos.borrow_mut()[1].table[44..48].copy_from_slice(&i32::to_le_bytes(limit));
        let mut wheels = board(&servos);
        run(&mut wheels, &FORWARD, 0, 60);
        assert_eq!((torque(&servos), goals(&servos)), ([false; 2], [0; 2]), "{limit}");
        assert_eq!((wheels.drive_state(), wheels.statuses()[1].misfit), (DriveState::Unfit, 44));
    }
}

/// The sync write is not answered: that it was not heard shows when the goals are read back, ten
/// times a second.
#[test]
fn a_goal_that_was_not_taken_is_sent_again() {
    let servos = Servos::new();
    let mut wheels = driving(&servos);
    servos.servos.borrow_mut()[0].table[104] = 7;
    let orders = Orders { goals: [60, 60], ..FORWARD };
    servos.servos.borrow_mut()[1].deaf = 1;
    run(&mut wheels, &orders, 40, 41);
    assert_eq!(goals(&servos), [60, 120]);
    run(&mut wheels, &orders, 41, 62);
    assert_eq!(goals(&servos), [60, 60]);
}

#[test]
fn a_tripped_watchdog_is_cleared_by_an_acknowledged_write() {
    let servos = Servos::new();
    let mut wheels = driving(&servos);
    servos.servos.borrow_mut()[1].table[98] = TRIPPED;
    servos.servos.borrow_mut()[1].table[104..108].fill(0);
    run(&mut wheels, &FORWARD, 40, 80);
    assert_eq!((table(&servos, 1, 98), goals(&servos)), (10, [100, 120]));
    assert_eq!(wheels.counters().tripped, 1);
}

/// It has forgotten torque, watchdog and turns: found within a tenth of a second, and its position
/// goes on.
#[test]
fn a_servo_that_restarts_drives_on() {
    let servos = Servos::new();
    let mut wheels = driving(&servos);
    servos.advance([0, 0], [10_000, 10_000]);
    now(wheels.poll(STEP_US * 200));
    let before = wheels.statuses()[0].odometer.unwrap();
    servos.servos.borrow_mut()[0].restart();
    run(&mut wheels, &FORWARD, 201, 260);
    assert_eq!((torque(&servos), goals(&servos)), ([true; 2], [100, 120]));
    assert_eq!(wheels.counters().restarts, 1);
    assert_eq!(wheels.statuses()[0].odometer, Some(before));
}

/// Its other wheel would turn the robot on the spot.
#[test]
fn a_robot_that_lost_a_wheel_stands() {
    let servos = Servos::new();
    let mut wheels = driving(&servos);
    servos.servos.borrow_mut()[0].is_present = false;
    run(&mut wheels, &FORWARD, 40, 45);
    assert_eq!((goals(&servos)[1], wheels.drive_state()), (0, DriveState::Lost));
    servos.servos.borrow_mut()[0].is_present = true;
    run(&mut wheels, &FORWARD, 45, 100);
    assert_eq!((wheels.drive_state(), goals(&servos)), (DriveState::Ready, [100, 120]));
}

/// Overload: it stays off until somebody has looked and switches torque off and on.
#[test]
fn a_failed_servo_waits_for_somebody() {
    let servos = Servos::new();
    let mut wheels = driving(&servos);
    servos.servos.borrow_mut()[1].hardware_error = 0x20;
    servos.servos.borrow_mut()[1].table[64] = 0;
    run(&mut wheels, &FORWARD, 40, 80);
    assert_eq!((wheels.drive_state(), goals(&servos)), (DriveState::Failed, [0, 0]));
    run(&mut wheels, &Orders { torque: false, ..FORWARD }, 80, 85);
    run(&mut wheels, &FORWARD, 85, 140);
    assert_eq!((wheels.drive_state(), goals(&servos)), (DriveState::Ready, [100, 120]));
}

/// With both servos answering, all of it fits a sample: the goals and one packet beside the read.
#[test]
fn no_sample_has_more_than_three_packets() {
    let servos = Servos::new();
    let mut wheels = board(&servos);
    for i in 0..200 {
        servos.instructions.borrow_mut().clear();
        let orders = Orders { goals: [(i % 7) as i32 * 10; 2], ..FORWARD };
        now(wheels.poll(STEP_US * i));
        now(wheels.drive(STEP_US * i, &orders));
        assert!(servos.instructions.borrow().len() <= 3, "sample {i}");
    }
    assert_eq!(servos.patience.0.get(), 0);
}

/// One servo restarts with another set-up while the other one runs: that one's torque is its own.
#[test]
fn each_servo_is_off_by_itself() {
    let servos = Servos::new();
    let mut wheels = driving(&servos);
    assert_eq!(wheels.are_off(), [false; 2]);
    servos.servos.borrow_mut()[0].restart();
    servos.servos.borrow_mut()[0].table[11] = 3;
    run(&mut wheels, &FORWARD, 40, 100);
    assert_eq!((wheels.drive_state(), torque(&servos)), (DriveState::Unfit, [false, true]));
    assert_eq!((wheels.has_torque(), wheels.are_off()), (false, [true, false]));
    run(&mut wheels, &Orders { torque: false, ..FORWARD }, 100, 110);
    assert_eq!((torque(&servos), wheels.are_off()), ([false; 2], [true; 2]));
}

/// The board has restarted and the servos have not: a torque that nobody has switched on since is
/// found, and switched off as asked.
#[test]
fn torque_from_before_the_start_is_found() {
    for (address, value) in [(64, 1), (9, 254)] {
        let servos = Servos::new();
        for servo in servos.servos.borrow_mut().iter_mut() {
            (servo.table[64], servo.table[address]) = (1, value);
        }
        let mut wheels = board(&servos);
        run(&mut wheels, &FORWARD, 0, 4);
        assert_eq!(wheels.are_off(), [false; 2], "{address}");
        run(&mut wheels, &Orders::NONE, 4, 60);
        assert_eq!((torque(&servos), wheels.are_off()), ([false; 2], [true; 2]), "{address}");
    }
}

/// Every write whose acknowledgement gets lost: whatever a servo then holds, nobody takes it for
/// off.
#[test]
fn an_unacknowledged_torque_counts_as_one() {
    for lost in 0..40 {
        let servos = Servos::new();
        let mut wheels = board(&servos);
        for i in 0..60 {
            now(wheels.poll(STEP_US * i));
            let breaks = u32::from(i >= lost);
            servos.servos.borrow_mut().iter_mut().for_each(|servo| servo.broken = breaks);
            now(wheels.drive(STEP_US * i, &FORWARD));
            servos.servos.borrow_mut().iter_mut().for_each(|servo| servo.broken = 0);
            let pairs = torque(&servos).into_iter().zip(wheels.are_off());
            assert!(pairs.into_iter().all(|(holds, is_off)| !(holds && is_off)), "{lost}, sample {i}");
        }
    }
}
