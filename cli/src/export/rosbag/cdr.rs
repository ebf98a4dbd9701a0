//! Messages of ROS 2 in the bytes of its middleware: CDR (OMG's Common Data Representation), plain, little endian. Each number begins at a
//! multiple of its own size, counted from behind the header of four bytes.

/// A message that is being written.
pub(super) struct Cdr(Vec<u8>);

/// Little endian, plain CDR, no options.
const HEADER: [u8; 4] = [0, 1, 0, 0];

impl Cdr {
    pub(super) fn new() -> Self {
        Self(HEADER.to_vec())
    }

    fn align(&mut self, size: usize) {
        let written = self.0.len() - HEADER.len();
        self.0.resize(HEADER.len() + written.next_multiple_of(size), 0);
    }

    pub(super) fn u8(mut self, number: u8) -> Self {
        self.0.push(number);
        self
    }

    pub(super) fn i32(mut self, number: i32) -> Self {
        self.align(4);
        self.0.extend(number.to_le_bytes());
        self
    }

    pub(super) fn u32(mut self, number: u32) -> Self {
        self.align(4);
        self.0.extend(number.to_le_bytes());
        self
    }

    pub(super) fn f32(mut self, number: f64) -> Self {
        self.align(4);
        // ROS has ranges in single precision.
        self.0.extend((number as f32).to_le_bytes());
        self
    }

    pub(super) fn f64(mut self, number: f64) -> Self {
        self.align(8);
        self.0.extend(number.to_le_bytes());
        self
    }

    pub(super) fn f64s(self, numbers: &[f64]) -> Self {
        numbers.iter().fold(self, |cdr, &number| cdr.f64(number))
    }

    /// A text has its length with the zero at its end.
    pub(super) fn text(self, text: &str) -> Self {
        let mut cdr = self.length(text.len() + 1);
        cdr.0.extend(text.as_bytes());
        cdr.u8(0)
    }

    /// The length of a sequence whose elements follow.
    pub(super) fn length(self, length: usize) -> Self {
        self.u32(u32::try_from(length).expect("sequences of a message are short"))
    }

    /// A `builtin_interfaces/Time`, of nanoseconds since the start.
    pub(super) fn time(self, ns: u64) -> Self {
        let seconds = i32::try_from(ns / 1_000_000_000).unwrap_or(i32::MAX);
        self.i32(seconds).u32((ns % 1_000_000_000) as u32)
    }

    pub(super) fn bytes(self) -> Vec<u8> {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_begin_at_multiples_of_their_size_behind_the_header() {
        let bytes = Cdr::new().u8(7).f64(1.0).text("ab").u32(5).bytes();
        let mut expected = vec![0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0];
        expected.extend(1.0f64.to_le_bytes());
        expected.extend([3, 0, 0, 0, b'a', b'b', 0, 0, 5, 0, 0, 0]);
        assert_eq!(bytes, expected);
    }
}
