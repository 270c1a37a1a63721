//! A state as bytes, to continue after a restart of the program.

use crate::settings::{ContactAngles, Filters};

/// The state of an [`Estimator`](crate::Estimator) from one frame to the next, without robot and settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SavedState {
    pub(crate) filters: Filters,
    /// An unknown contact angle and the error of a given one are different states.
    pub(crate) contact_angles: ContactAngles,
    /// In the order of [`crate::visit::Visit`]; zero beyond what the filters need.
    pub(crate) numbers: [f64; NUMBERS],
}

/// Numbers in the largest state, that of `best`.
pub(crate) const NUMBERS: usize = 2329;

const MAGIC: [u8; 4] = *b"RHES";
/// Changes with the numbers of a state or their order.
const VERSION: u16 = 14;
/// Magic, version, filters, contact angles.
const HEADER: usize = 8;
const CHECKSUM: usize = 4;

/// Why a saved state cannot be restored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RestoreError {
    /// Not as long as a saved state.
    Length {
        /// Bytes found; [`SavedState::BYTES`] are needed.
        found: usize,
    },
    /// Does not begin with the mark of a saved state.
    NotASavedState,
    /// Written in another version of the format.
    Version {
        /// The version found.
        found: u16,
        /// The version that this crate writes and reads.
        readable: u16,
    },
    /// The checksum is wrong, or a number is not finite.
    Corrupted,
    /// Saved by an estimator whose contact angles come from elsewhere.
    OtherContactAngles {
        /// Those of the saved state.
        saved: ContactAngles,
        /// Those of the estimator.
        own: ContactAngles,
    },
    /// Saved with other [`Filters`] than the estimator's.
    OtherFilters {
        /// Those of the saved state.
        saved: Filters,
        /// Those of the estimator.
        own: Filters,
    },
}

impl core::fmt::Display for RestoreError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Length { found } => write!(
                f,
                "a saved state has {} bytes, these are {found}",
                SavedState::BYTES
            ),
            Self::NotASavedState => write!(f, "these bytes are not a saved state"),
            Self::Version { found, readable } => write!(
                f,
                "the state was saved in version {found}; only version {readable} can be read"
            ),
            Self::Corrupted => write!(f, "the saved state is corrupted"),
            Self::OtherContactAngles { saved, own } => write!(
                f,
                "the state was saved for contact angles {saved:?}, the estimator is for contact angles {own:?}"
            ),
            Self::OtherFilters { saved, own } => write!(
                f,
                "the state was saved with the filters {saved:?}, the estimator has the filters {own:?}"
            ),
        }
    }
}

impl core::error::Error for RestoreError {}

impl SavedState {
    /// Length of [`Self::to_bytes`].
    pub const BYTES: usize = HEADER + 8 * NUMBERS + CHECKSUM;

    /// Little-endian: `RHES`, version (2 bytes), filters (0 paper, 1 Kalman), contact angles (0 given, 1 unknown), the
    /// numbers as f64, CRC-32 of all before.
    pub fn to_bytes(&self) -> [u8; Self::BYTES] {
        let mut bytes = [0; Self::BYTES];
        let [v0, v1] = VERSION.to_le_bytes();
        let [m0, m1, m2, m3] = MAGIC;
        let filters = code(self.filters);
        let angles = u8::from(self.contact_angles == ContactAngles::Unknown);
        let header = [m0, m1, m2, m3, v0, v1, filters, angles];
        let body = header
            .into_iter()
            .chain(self.numbers.iter().flat_map(|number| number.to_le_bytes()));
        for (to, from) in bytes.iter_mut().zip(body) {
            *to = from;
        }
        if let Some((before, checksum)) = bytes.split_last_chunk_mut::<CHECKSUM>() {
            *checksum = crc32(before).to_le_bytes();
        }
        bytes
    }

    /// Reads what [`Self::to_bytes`] wrote.
    ///
    /// # Errors
    /// All of [`RestoreError`] but [`RestoreError::OtherFilters`] and [`RestoreError::OtherContactAngles`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, RestoreError> {
        let length = RestoreError::Length { found: bytes.len() };
        if bytes.len() != Self::BYTES {
            return Err(length);
        }
        let (before, checksum) = bytes.split_last_chunk::<CHECKSUM>().ok_or(length)?;
        let (header, body) = before.split_first_chunk::<HEADER>().ok_or(length)?;
        let [m0, m1, m2, m3, v0, v1, code, angles] = *header;
        if [m0, m1, m2, m3] != MAGIC {
            return Err(RestoreError::NotASavedState);
        }
        let found = u16::from_le_bytes([v0, v1]);
        if found != VERSION {
            return Err(RestoreError::Version {
                found,
                readable: VERSION,
            });
        }
        if crc32(before).to_le_bytes() != *checksum {
            return Err(RestoreError::Corrupted);
        }
        let filters = match code {
            0 => Filters::Paper,
            1 => Filters::Kalman,
            _ => return Err(RestoreError::Corrupted),
        };
        let contact_angles = match angles {
            0 => ContactAngles::Given,
            1 => ContactAngles::Unknown,
            _ => return Err(RestoreError::Corrupted),
        };
        let mut numbers = [0.0; NUMBERS];
        for (number, chunk) in numbers.iter_mut().zip(body.as_chunks::<8>().0) {
            *number = f64::from_le_bytes(*chunk);
            if !number.is_finite() {
                return Err(RestoreError::Corrupted);
            }
        }
        Ok(Self {
            filters,
            contact_angles,
            numbers,
        })
    }
}

fn code(filters: Filters) -> u8 {
    match filters {
        Filters::Paper => 0,
        Filters::Kalman => 1,
    }
}

/// CRC-32 of IEEE 802.3 (reflected, polynomial 0x04C11DB7), bit by bit: a state is saved rarely.
fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for byte in bytes {
        crc ^= u32::from(*byte);
        for _ in 0..8 {
            let low = crc & 1;
            crc = (crc >> 1) ^ (0xEDB8_8320 * low);
        }
    }
    !crc
}

#[cfg(test)]
mod tests {
    use super::*;

    fn some() -> SavedState {
        let mut numbers = [0.0; NUMBERS];
        for (k, number) in numbers.iter_mut().enumerate() {
            *number = libm::sin(k as f64);
        }
        SavedState {
            filters: Filters::Kalman,
            contact_angles: ContactAngles::Unknown,
            numbers,
        }
    }

    /// The check value of the standard: CRC-32 of "123456789".
    #[test]
    fn the_checksum_is_the_standard_one() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }

    #[test]
    fn bytes_give_back_the_state() {
        for filters in [Filters::Paper, Filters::Kalman] {
            let saved = SavedState { filters, ..some() };
            assert_eq!(SavedState::from_bytes(&saved.to_bytes()), Ok(saved));
        }
    }

    /// Each error has its own cause. A CRC-32 detects each single changed byte.
    #[test]
    fn each_error_has_its_cause() {
        let bytes = some().to_bytes();
        let found = bytes.len() - 1;
        assert_eq!(
            SavedState::from_bytes(&bytes[..found]),
            Err(RestoreError::Length { found })
        );
        assert_eq!(
            SavedState::from_bytes(&[]),
            Err(RestoreError::Length { found: 0 })
        );
        for i in 0..bytes.len() {
            let mut changed = bytes;
            changed[i] ^= 0x10;
            let expected = match i {
                0..4 => RestoreError::NotASavedState,
                4 => RestoreError::Version {
                    found: VERSION ^ 0x10,
                    readable: VERSION,
                },
                5 => RestoreError::Version {
                    found: VERSION ^ 0x1000,
                    readable: VERSION,
                },
                _ => RestoreError::Corrupted,
            };
            assert_eq!(SavedState::from_bytes(&changed), Err(expected), "byte {i}");
        }
        let mut saved = some();
        saved.numbers[7] = f64::NAN;
        assert_eq!(
            SavedState::from_bytes(&saved.to_bytes()),
            Err(RestoreError::Corrupted)
        );
    }
}
