//! What can go wrong in a factorisation.

use faer::sparse::FaerError;

#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FactorError {
    /// The pivot of this unknown (as numbered by the caller) is not positive.
    NotPositiveDefinite { unknown: usize },
    /// The factor needs more than 2^31 - 1 entries or more memory than there is.
    TooLarge,
    /// The factor is not finite, or the solution misses its equation.
    Singular,
}

impl From<FaerError> for FactorError {
    fn from(_: FaerError) -> Self {
        // the two kinds, index overflow and no memory, ask the same of the caller
        Self::TooLarge
    }
}
