//! CDR, the encoding of ROS 2 messages: numbers at offsets that are multiples of their size, after
//! a head of four bytes.

/// Reads a message.
pub struct CdrReader<'a> {
    bytes: &'a [u8],
    at: usize,
    big_endian: bool,
}

impl<'a> CdrReader<'a> {
    /// A reader behind the head of a message; `None` without a head of plain CDR.
    pub fn new(message: &'a [u8]) -> Option<Self> {
        let (head, bytes) = message.split_at_checked(4)?;
        let big_endian = match head {
            [0, 0, ..] => true,
            [0, 1, ..] => false,
            _ => return None,
        };
        Some(Self {
            bytes,
            at: 0,
            big_endian,
        })
    }

    /// The bytes of a number, little-endian.
    pub fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let start = self.at.next_multiple_of(N);
        let end = start.checked_add(N)?;
        let mut bytes: [u8; N] = self.bytes.get(start..end)?.try_into().ok()?;
        self.at = end;
        if self.big_endian {
            bytes.reverse();
        }
        Some(bytes)
    }

    /// A whole number of four bytes.
    pub fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    /// A double.
    pub fn f64(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }

    /// A text.
    pub fn text(&mut self) -> Option<&'a str> {
        let length = usize::try_from(self.u32()?).ok()?;
        let bytes = self.bytes.get(self.at..self.at.checked_add(length)?)?;
        self.at += length;
        std::str::from_utf8(bytes.strip_suffix(&[0]).unwrap_or(bytes)).ok()
    }

    /// A sequence of doubles.
    pub fn doubles(&mut self) -> Option<Vec<f64>> {
        let count = self.u32()?;
        // A wrong count ends at the end of the message.
        (0..count).map(|_| self.f64()).collect()
    }
}

/// A message being written, little-endian.
pub struct CdrWriter(pub Vec<u8>);

impl CdrWriter {
    /// A message with its head.
    pub fn new() -> Self {
        Self(vec![0, 1, 0, 0])
    }

    /// The bytes of a number, little-endian.
    pub fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        let length = 4 + (self.0.len() - 4).next_multiple_of(N);
        self.0.resize(length, 0);
        self.0.extend(bytes);
    }

    /// Doubles without their number.
    pub fn array(&mut self, values: &[f64]) {
        values.iter().for_each(|v| self.put(v.to_le_bytes()));
    }

    /// Doubles with their number.
    pub fn sequence(&mut self, values: &[f64]) {
        self.count(values.len());
        self.array(values);
    }

    /// A text.
    pub fn text(&mut self, text: &str) {
        self.count(text.len() + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    /// The length of a sequence.
    pub fn count(&mut self, count: usize) {
        self.put(u32::try_from(count).unwrap_or(u32::MAX).to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is written is read, each number at its offset, and a message that is cut gives nothing.
    #[test]
    fn messages_are_read_as_written() {
        let mut writer = CdrWriter::new();
        writer.put((-7_i32).to_le_bytes());
        writer.count(8);
        writer.text("link1");
        writer.array(&[0.25]);
        writer.sequence(&[1.5, f64::MIN_POSITIVE]);
        let bytes = writer.0;
        // 4 head, 4 + 4, 4 + 6 of the text, 6 to the next multiple of 8, 8, 4, 4 to the next
        // multiple of 8, 16.
        assert_eq!(bytes.len(), 4 + 8 + 10 + 6 + 8 + 8 + 16);
        let read = |bytes: &[u8]| {
            let mut reader = CdrReader::new(bytes)?;
            let first = reader.take().map(i32::from_le_bytes)?;
            let start = (first, reader.u32()?, reader.text()?.to_owned());
            Some((start, reader.f64()?, reader.doubles()?))
        };
        let expected = (
            (-7, 8, "link1".to_owned()),
            0.25,
            vec![1.5, f64::MIN_POSITIVE],
        );
        assert_eq!(read(&bytes), Some(expected));
        for end in 0..bytes.len() {
            assert_eq!(read(&bytes[..end]), None, "{end}");
        }
        assert!(CdrReader::new(&[0, 9, 0, 0]).is_none());
    }

    /// Big-endian messages, as some recorders write them.
    #[test]
    fn both_byte_orders_are_read() {
        let mut reader = CdrReader::new(&[0, 0, 0, 0, 0, 0, 1, 2]).expect("a head");
        assert_eq!(reader.u32(), Some(258));
    }
}
