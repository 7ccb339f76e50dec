//! What Cholesky and LDLT share: symbolic analysis, storage, permutation of right-hand sides.

use crate::error::FactorError;
use crate::memory::scratch;
use crate::ordering::{Lower, Permuted, Triangle, permuted};
use faer::Mat;
use faer::MatRef;
use faer::dyn_stack::{MemStack, StackReq};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SymbolicSupernodalParams;
use faer::sparse::linalg::cholesky::{simplicial, supernodal};
use supernodal::SymbolicSupernodalCholesky;

/// Columns of right-hand sides that one task takes: fixed, so that results do not depend on threads.
pub const CHUNK: usize = 32;

/// Measured at the peak of ordering and analysis with one unknown a node, on triangles of order 1
/// and 2; with two unknowns a node it is about half.
const BYTES_AN_ENTRY: u64 = 18;
const BYTES_AN_UNKNOWN: u64 = 160;

/// Supernodal structure of the factor of the permuted matrix.
pub fn analysed(
    lower: Lower,
    inverse: &[u32],
) -> Result<SymbolicSupernodalCholesky<u32>, FactorError> {
    let n = lower.n();
    let upper = permuted(lower, inverse, n, Triangle::Upper);
    let pattern =
        SymbolicSparseColMatRef::new_unsorted_checked(n, n, &upper.col_ptr, None, &upper.row_idx);
    let mut buffer = scratch(StackReq::any_of(&[
        simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(n, upper.row_idx.len()),
        supernodal::factorize_supernodal_symbolic_cholesky_scratch::<u32>(n),
    ]))?;
    let stack = MemStack::new(&mut buffer);
    let (mut tree, mut counts) = (vec![0i32; n], vec![0u32; n]);
    let tree = simplicial::prefactorize_symbolic_cholesky(&mut tree, &mut counts, pattern, stack);
    if counts.iter().map(|&count| u64::from(count)).sum::<u64>() > i32::MAX as u64 {
        return Err(FactorError::TooLarge);
    }
    Ok(supernodal::factorize_supernodal_symbolic_cholesky(
        pattern,
        tree,
        &counts,
        stack,
        SymbolicSupernodalParams::default(),
    )?)
}

/// Lower triangle of the permuted matrix with its values.
pub fn permuted_values(lower: Lower, values: &[f64], inverse: &[u32]) -> (Permuted, Vec<f64>) {
    let matrix = permuted(lower, inverse, lower.n(), Triangle::Lower);
    let moved = matrix.source.iter().map(|&p| values[p as usize]).collect();
    (matrix, moved)
}

/// Bytes for the ordering and the analysis: graphs of the pattern and their work arrays.
pub fn analysis_bytes(lower: Lower) -> u64 {
    let (n, n_entries) = (lower.n() as u64, lower.indices.len() as u64);
    BYTES_AN_ENTRY * n_entries + BYTES_AN_UNKNOWN * n
}

/// Bytes for the numbers: the factor, what computes it, and the permuted matrix.
pub fn numeric_bytes(
    lower: Lower,
    symbolic: &SymbolicSupernodalCholesky<u32>,
    need: StackReq,
) -> u64 {
    let n_entries = lower.indices.len() as u64;
    let permuted = 16 * n_entries + 4 * lower.n() as u64;
    8 * symbolic.len_val() as u64 + permuted + need.size_bytes() as u64
}

/// Row `new` of the result is row `order(new)` of `matrix`.
pub fn gathered(matrix: MatRef<f64>, order: impl Fn(usize) -> usize) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(order(i), j)])
}
