//! The records of an MCAP file (<https://mcap.dev/spec>) and their fields. Each length is compared with the bytes that are
//! there.
//!
//! A record whose fields do not fill it is invalid: so a length or a kind that a disk has altered is detected, and a forged
//! length allocates no memory.

/// The content of a record, as far as it is used here.
pub(super) enum Record<'a> {
    Channel {
        id: u16,
        topic: &'a str,
    },
    Message {
        channel: u16,
        data: &'a [u8],
    },
    Chunk(Chunk<'a>),
    DataEnd {
        checksum: u32,
    },
    Footer {
        checksum: u32,
    },
    Statistics(Statistics),
    /// A record of a kind that does not belong to the run.
    Other,
}

/// Records that are packed together.
pub(super) struct Chunk<'a> {
    /// The number of bytes of the records.
    pub(super) size: u64,
    /// CRC-32 of them, 0 if it is not known.
    pub(super) checksum: u32,
    pub(super) compression: &'a [u8],
    pub(super) data: &'a [u8],
}

/// The counts of a whole file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Statistics {
    pub(super) messages: u64,
    pub(super) chunks: u32,
    pub(super) first_ns: u64,
    pub(super) last_ns: u64,
}

/// Bytes of a record before what stands in it: its kind and its length.
pub(super) const HEAD: usize = 9;

/// The kind and the length of the record that begins with these bytes.
pub(super) fn head(bytes: &[u8]) -> Option<(u8, u64)> {
    let mut fields = Fields(bytes);
    Some((fields.u8()?, fields.u64()?))
}

/// A record of this kind with these bytes; `None` if it is none that a recording has.
pub(super) fn parse(kind: u8, body: &[u8]) -> Option<Record<'_>> {
    let mut fields = Fields(body);
    let record = match kind {
        CHANNEL => {
            let (id, _schema) = (fields.u16()?, fields.u16()?);
            let topic = std::str::from_utf8(fields.text()?).ok()?;
            fields.text()?;
            fields.texts()?;
            Record::Channel { id, topic }
        }
        MESSAGE => {
            let channel = fields.u16()?;
            fields.skip(4 + 8 + 8)?;
            Record::Message { channel, data: fields.rest() }
        }
        CHUNK => Record::Chunk(fields.chunk()?),
        STATISTICS => Record::Statistics(fields.statistics()?),
        DATA_END => Record::DataEnd { checksum: fields.u32()? },
        FOOTER => {
            fields.skip(8 + 8)?;
            Record::Footer { checksum: fields.u32()? }
        }
        kind => {
            fields_of_other(kind)?.iter().try_for_each(|field| fields.pass(field))?;
            Record::Other
        }
    };
    fields.0.is_empty().then_some(record)
}

/// Whether a chunk may begin with these bytes, or what comes behind the last of them, or the last record of all.
pub(super) fn may_begin(bytes: &[u8]) -> bool {
    match head(bytes) {
        Some((CHUNK, length)) => {
            let mut fields = Fields(&bytes[HEAD..]);
            let rest = fields.chunk_head().map(|(chunk, packed)| (chunk.compression.len() as u64, packed));
            rest.is_some_and(|(name, packed)| packed.checked_add(CHUNK_HEAD + name) == Some(length))
        }
        Some((DATA_END, 4)) => bytes.get(HEAD + 4).is_none_or(|next| (HEADER..=DATA_END).contains(next)),
        // Behind it is the end of the file.
        Some((FOOTER, 20)) => bytes.get(HEAD + 20).is_none_or(|next| *next == 0x89),
        _ => false,
    }
}

/// The number of bytes that [`may_begin`] examines.
pub(super) const BEGINNING: usize = HEAD + CHUNK_HEAD as usize + 8;

/// The first of these bytes with which a record may begin that [`may_begin`] knows.
pub(super) fn first_of_interest(bytes: &[u8]) -> Option<usize> {
    bytes.iter().position(|byte| matches!(*byte, CHUNK | DATA_END | FOOTER))
}

/// Fields one after the other. Each takes bytes that are there, or is none.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn skip(&mut self, n: usize) -> Option<&'a [u8]> {
        let (these, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(these)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.skip(N)?.try_into().ok()
    }

    fn u8(&mut self) -> Option<u8> {
        self.array().map(u8::from_le_bytes)
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// A text, or a list of so many bytes.
    fn text(&mut self) -> Option<&'a [u8]> {
        let length = self.u32()?;
        self.skip(usize::try_from(length).ok()?)
    }

    /// Names and texts.
    fn texts(&mut self) -> Option<()> {
        let mut all = Self(self.text()?);
        while !all.0.is_empty() {
            all.text()?;
            all.text()?;
        }
        Some(())
    }

    /// A list of things of so many bytes each.
    fn list(&mut self, each: usize) -> Option<()> {
        self.text()?.len().is_multiple_of(each).then_some(())
    }

    fn rest(&mut self) -> &'a [u8] {
        std::mem::take(&mut self.0)
    }

    fn chunk(&mut self) -> Option<Chunk<'a>> {
        let (chunk, packed) = self.chunk_head()?;
        Some(Chunk { data: self.skip(usize::try_from(packed).ok()?)?, ..chunk })
    }

    /// The chunk without its content, and the number of bytes of that.
    fn chunk_head(&mut self) -> Option<(Chunk<'a>, u64)> {
        self.skip(8 + 8)?;
        let (size, checksum, compression) = (self.u64()?, self.u32()?, self.text()?);
        Some((Chunk { size, checksum, compression, data: &[] }, self.u64()?))
    }

    fn statistics(&mut self) -> Option<Statistics> {
        let messages = self.u64()?;
        self.skip(2 + 4 + 4 + 4)?;
        let (chunks, first_ns, last_ns) = (self.u32()?, self.u64()?, self.u64()?);
        self.list(2 + 8)?;
        Some(Statistics { messages, chunks, first_ns, last_ns })
    }

    fn pass(&mut self, field: &Field) -> Option<()> {
        match *field {
            Field::Fixed(n) => self.skip(n).map(|_| ()),
            Field::Text => self.text().map(|_| ()),
            Field::Texts => self.texts(),
            Field::List(each) => self.list(each),
            Field::Data => {
                let length = self.u64()?;
                self.skip(usize::try_from(length).ok()?).map(|_| ())
            }
        }
    }
}

/// A field of a record that does not belong to the run.
enum Field {
    /// A fixed number of bytes.
    Fixed(usize),
    Text,
    /// Names and texts.
    Texts,
    /// A list of things of so many bytes each.
    List(usize),
    /// Data with their length in 64 bits.
    Data,
}

/// The fields of such a record; `None` if no recording has one of this kind.
fn fields_of_other(kind: u8) -> Option<&'static [Field]> {
    use Field::{Data, Fixed, List, Text, Texts};
    Some(match kind {
        HEADER => &[Text, Text],
        SCHEMA => &[Fixed(2), Text, Text, Text],
        MESSAGE_INDEX => &[Fixed(2), List(8 + 8)],
        CHUNK_INDEX => &[Fixed(4 * 8), List(2 + 8), Fixed(8), Text, Fixed(2 * 8)],
        ATTACHMENT => &[Fixed(2 * 8), Text, Text, Data, Fixed(4)],
        ATTACHMENT_INDEX => &[Fixed(5 * 8), Text, Text],
        METADATA => &[Text, Texts],
        METADATA_INDEX => &[Fixed(2 * 8), Text],
        SUMMARY_OFFSET => &[Fixed(1 + 2 * 8)],
        _ => return None,
    })
}

/// Bytes of a chunk's fields before what is in it, without the name of its compression.
const CHUNK_HEAD: u64 = 8 + 8 + 8 + 4 + 4 + 8;

const HEADER: u8 = 0x01;
const FOOTER: u8 = 0x02;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const CHUNK: u8 = 0x06;
const MESSAGE_INDEX: u8 = 0x07;
const CHUNK_INDEX: u8 = 0x08;
const ATTACHMENT: u8 = 0x09;
const ATTACHMENT_INDEX: u8 = 0x0A;
const STATISTICS: u8 = 0x0B;
const METADATA: u8 = 0x0C;
const METADATA_INDEX: u8 = 0x0D;
const SUMMARY_OFFSET: u8 = 0x0E;
const DATA_END: u8 = 0x0F;
