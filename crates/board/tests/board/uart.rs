//! Characters out and in.

use baudbot_avr::usart::Frame;
use baudbot_board::{ReceiveError, Wiring};

use crate::board::world::{MS, World, board_with_file};

#[test]
fn characters_are_answered_with_exact_instants() {
    let mut board = board_with_file("echo_9600.hex", Wiring::builder());
    let mut world = World::default();
    board.run_until(MS, &mut world);
    let mut sent = Vec::new();
    for byte in b'a'..=b'z' {
        board.receive(Frame::byte(byte), board.now_ns(), 9600).unwrap();
        board.run_until(board.now_ns() + 2 * MS, &mut world);
        sent.extend(board.sent());
    }
    board.run_until(board.now_ns() + 3 * MS, &mut world);
    sent.extend(board.sent());
    let bytes: Vec<u8> = sent.iter().map(|sent| sent.frame.data() as u8).collect();
    assert_eq!(bytes, (b'b'..=b'{').collect::<Vec<_>>());
    for sent in &sent {
        // Ten bits of 104 times 16 cycles, rounded twice.
        assert!((sent.end_ns - sent.start_ns).abs_diff(1_040_000) <= 1);
    }
    assert_eq!(board.sent().count(), 0);
    assert_eq!(board.warnings(), []);
}

#[test]
fn a_sender_without_pauses_may_round_its_instants_to_nanoseconds() {
    for (file, baud) in [("echo_115200.hex", 115_200), ("echo_115200.hex", 113_000), ("echo_9600.hex", 9600)]
    {
        let mut board = board_with_file(file, Wiring::builder());
        let mut world = World::default();
        board.run_until(MS, &mut world);
        let mut answers = 0;
        for character in 0..500 {
            let start_ns = MS + character * 10_000_000_000 / u64::from(baud);
            board.run_until(start_ns, &mut world);
            board.receive(Frame::byte(character as u8), start_ns, baud).unwrap();
            answers += board.sent().count();
        }
        assert!(answers > 490, "{answers} at {baud} baud");
        assert_eq!(board.warnings(), []);
    }
}

#[test]
fn a_rate_that_is_none_and_a_line_that_is_not_free_are_errors() {
    let mut board = board_with_file("echo_9600.hex", Wiring::builder());
    board.run_until(MS, &mut World::default());
    assert_eq!(board.receive(Frame::byte(0), MS, 0), Err(ReceiveError::Baud { baud: 0 }));
    board.receive(Frame::byte(0), MS, 9600).unwrap();
    assert!(matches!(board.receive(Frame::byte(0), MS, 9600), Err(ReceiveError::Line(_))));
}
