//! One direction of a cable: the bytes of the message that is under way.

use super::{Direction, Item, Meaning};

#[derive(Clone, Debug)]
pub(super) struct Half<B> {
    memory: B,
    /// The number of bytes of the memory that are used.
    len: usize,
    /// The instant of the first of them.
    from_ns: u64,
    /// The instant of the last but one, and of the last.
    last_ns: [u64; 2],
}

impl<B: AsRef<[u8]> + AsMut<[u8]>> Half<B> {
    pub(super) fn new(memory: B) -> Self {
        Self { memory, len: 0, from_ns: 0, last_ns: [0; 2] }
    }

    /// The number of bytes that a message may have.
    pub(super) fn room(&self) -> usize {
        self.memory.as_ref().len()
    }

    pub(super) fn is_full(&self) -> bool {
        self.len >= self.room()
    }

    pub(super) fn bytes(&self) -> &[u8] {
        self.memory.as_ref().get(..self.len).unwrap_or_default()
    }

    /// Takes a byte, for which there must be room.
    pub(super) fn push(&mut self, byte: u8, at_ns: u64) {
        if let Some(free) = self.memory.as_mut().get_mut(self.len) {
            *free = byte;
            self.len += 1;
        }
        if self.len <= 1 {
            self.from_ns = at_ns;
        }
        self.last_ns = [self.last_ns[1], at_ns];
    }

    /// Whether something is held to which nothing was added for longer than this.
    pub(super) fn is_silent(&self, now_ns: u64, silence_ns: u64) -> bool {
        self.len > 0 && now_ns.saturating_sub(self.last_ns[1]) > silence_ns
    }

    /// Everything that is held is an item, if anything is.
    pub(super) fn tell(
        &mut self,
        direction: Direction,
        mut read: impl FnMut(&[u8], u64) -> Meaning,
        each: &mut impl FnMut(Item<'_>),
    ) {
        let (bytes, to_ns) = (self.bytes(), self.last_ns[1]);
        if !bytes.is_empty() {
            let meaning = read(bytes, to_ns);
            each(item(direction, (self.from_ns, to_ns), bytes, &meaning));
        }
        self.len = 0;
    }

    /// Everything that is held but the last byte belongs to nothing.
    pub(super) fn tell_all_but_last(&mut self, direction: Direction, each: &mut impl FnMut(Item<'_>)) {
        let Some((&last, before @ [_, ..])) = self.bytes().split_last() else { return };
        let meaning = Meaning::not_understood(before, "");
        each(item(direction, (self.from_ns, self.last_ns[0]), before, &meaning));
        self.len = 0;
        self.push(last, self.last_ns[1]);
    }
}

fn item<'a>(
    direction: Direction,
    (from_ns, to_ns): (u64, u64),
    bytes: &'a [u8],
    meaning: &'a Meaning,
) -> Item<'a> {
    let Meaning { text, is_understood, age_ns } = meaning;
    let (text, is_understood, age_ns) = (text.as_str(), *is_understood, *age_ns);
    Item { direction, from_ns, to_ns, bytes, text, is_understood, age_ns }
}
