//! A debugger of few words.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

/// A debugger that is connected.
pub(crate) struct Client(TcpStream);

impl Client {
    pub(crate) fn connect(address: SocketAddr) -> Self {
        let stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream.set_nodelay(true).unwrap();
        let mut client = Self(stream);
        assert!(client.ask("qSupported:swbreak+;hwbreak+").contains("PacketSize="));
        client
    }

    /// Sends something without waiting for an answer.
    pub(crate) fn say(&mut self, text: &str) {
        self.shout(text);
        assert_eq!(self.byte(), b'+', "acknowledgement of {text}");
    }

    /// Sends something that no program need read.
    pub(crate) fn shout(&mut self, text: &str) {
        let sum = text.bytes().fold(0_u8, u8::wrapping_add);
        self.0.write_all(format!("${text}#{sum:02x}").as_bytes()).unwrap();
    }

    /// The next answer.
    pub(crate) fn answer(&mut self) -> String {
        assert_eq!(self.byte(), b'$');
        let mut text = Vec::new();
        loop {
            match self.byte() {
                b'#' => break,
                b'*' => {
                    // The last character so many times more.
                    let more = usize::from(self.byte() - 29);
                    let last = *text.last().unwrap();
                    text.extend(std::iter::repeat_n(last, more));
                }
                byte => text.push(byte),
            }
        }
        let _sum = (self.byte(), self.byte());
        self.0.write_all(b"+").unwrap();
        String::from_utf8(text).unwrap()
    }

    pub(crate) fn ask(&mut self, text: &str) -> String {
        self.say(text);
        self.answer()
    }

    /// Ctrl-C.
    pub(crate) fn interrupt(&mut self) {
        self.0.write_all(&[3]).unwrap();
    }

    /// The output of a command behind `monitor`.
    pub(crate) fn monitor(&mut self, command: &str) -> String {
        let hex: String = command.bytes().map(|byte| format!("{byte:02x}")).collect();
        let mut printed = Vec::new();
        let mut answer = self.ask(&format!("qRcmd,{hex}"));
        while let Some(hex) = answer.strip_prefix('O').filter(|hex| *hex != "K") {
            printed.extend(bytes(hex));
            answer = self.answer();
        }
        assert_eq!(answer, "OK");
        String::from_utf8(printed).unwrap()
    }

    /// A register by its number, from its bytes in little endian.
    pub(crate) fn register(&mut self, number: u8) -> u32 {
        let answer = self.ask(&format!("p{number:x}"));
        bytes(&answer).iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte))
    }

    pub(crate) fn pc(&mut self) -> u32 {
        self.register(34)
    }

    pub(crate) fn memory(&mut self, address: u32, count: usize) -> Vec<u8> {
        bytes(&self.ask(&format!("m{address:x},{count:x}")))
    }

    fn byte(&mut self) -> u8 {
        let mut byte = [0];
        self.0.read_exact(&mut byte).unwrap();
        byte[0]
    }
}

fn bytes(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2).map(|at| u8::from_str_radix(&hex[2 * at..][..2], 16).unwrap()).collect()
}
