//! What can go wrong in a factorisation.

use faer::sparse::FaerError;

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FactorError {
    /// The pivot of this unknown (as numbered by the caller) is not positive.
    NotPositiveDefinite { unknown: usize },
    /// The factor needs more than 2^31 - 1 entries.
    TooLarge,
    /// The work needs this many bytes, more than allowed or than there are.
    NoMemory { needed: u64 },
    /// The factor is not finite, or the solution misses its equation.
    Singular,
}

impl From<FaerError> for FactorError {
    fn from(error: FaerError) -> Self {
        match error {
            FaerError::OutOfMemory => Self::NoMemory { needed: 0 },
            _ => Self::TooLarge,
        }
    }
}
