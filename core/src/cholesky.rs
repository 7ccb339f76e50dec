//! Sparse Cholesky factor with some unknowns kept last, and their Schur complement.
//!
//! With the interior `i` first and the trailing unknowns `b` last, the factor of the interior
//! columns gives at once the condensed right-hand side and the recovery of the interior, and the
//! trailing block of the factor gives the Schur complement `S = K_bb - K_bi K_ii^-1 K_ib`.
//!
//! `S` may be singular (a body that floats until its trailing unknowns are held), so the factor is
//! of `K` with the diagonal of `K_bb` raised by itself, and that is subtracted from `S` again. Each
//! unknown has a shift of its own size, so the rounding is that of its own entries. Only the
//! interior columns of the factor are used for solving; `S` is factorised when first asked to.

use crate::error::FactorError;
use crate::memory::{ask, scratch, zeros};
use crate::ordering::{Lower, Permuted, Triangle, inverted, minimum_degree, permuted, postordered};
use crate::symbolic::{CHUNK, analysed, analysis_bytes, gathered, numeric_bytes};
use faer::dyn_stack::{MemStack, StackReq};
use faer::linalg::cholesky::llt::factor as dense;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::sparse::linalg::cholesky::supernodal::{
    SupernodalLltRef, SymbolicSupernodalCholesky, factorize_supernodal_numeric_llt,
    factorize_supernodal_numeric_llt_scratch,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;
use std::sync::{Arc, Mutex, OnceLock};

/// Smallest pivot of a small matrix, beside the diagonal entry that it began as.
const RELATIVE_PIVOT: f64 = 1e-13;
/// Growth of the shift when the trailing block is still indefinite with it.
const SHIFT_GROWTH: f64 = 16.0;
const MOST_SHIFTS: usize = 20;
/// Columns of right-hand sides up to which each is solved by itself: few are bound by reading the factor.
const NARROW: usize = 8;
/// The dense Schur complement of more unknowns has more than 2^31 - 1 entries.
const MOST_TRAILING: usize = 46_340;
/// Analyses that are kept, and entries of a pattern up to which its analysis is: 60 bytes an entry.
const MOST_KEPT: usize = 4;
const MOST_KEPT_ENTRIES: usize = 1_000_000;

/// Analyses of the last patterns, the latest first.
static KEPT: Mutex<Vec<Arc<Analysis>>> = Mutex::new(Vec::new());

/// What the pattern alone determines: the order of the unknowns and the structure of the factor.
///
/// Matrices of one pattern with other values follow each other, as those of many wavenumbers do:
/// analysing them anew takes half of the time.
#[derive(Debug)]
struct Analysis {
    indptr: Vec<i64>,
    indices: Vec<i32>,
    groups: Vec<i32>,
    trailing: Vec<i32>,
    forward: Vec<u32>,
    n_interior: usize,
    matrix: Permuted,
    symbolic: SymbolicSupernodalCholesky<u32>,
}

impl Analysis {
    /// That of a pattern, kept from before or made in at most so many bytes.
    fn of(
        lower: Lower,
        groups: &[i32],
        trailing: &[i32],
        most_bytes: u64,
    ) -> Result<Arc<Self>, FactorError> {
        let kept = || KEPT.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let before: Vec<Arc<Self>> = kept().clone();
        if let Some(found) = before.iter().find(|a| a.is_of(lower, groups, trailing)) {
            return Ok(found.clone());
        }
        ask(analysis_bytes(lower), most_bytes)?;
        let n = lower.n();
        let mut inner = vec![true; n];
        for &unknown in trailing {
            inner[unknown as usize] = false;
        }
        let mut forward = postordered(lower, &minimum_degree(lower, groups, &inner)?);
        let n_interior = forward.len();
        forward.extend(trailing.iter().map(|&unknown| unknown as u32));
        let inverse = inverted(&forward, n);
        let found = Arc::new(Self {
            indptr: lower.indptr.to_vec(),
            indices: lower.indices.to_vec(),
            groups: groups.to_vec(),
            trailing: trailing.to_vec(),
            forward,
            n_interior,
            matrix: permuted(lower, &inverse, n, Triangle::Lower),
            symbolic: analysed(lower, &inverse)?,
        });
        if lower.indices.len() <= MOST_KEPT_ENTRIES {
            let mut latest = kept();
            latest.insert(0, found.clone());
            latest.truncate(MOST_KEPT);
        }
        Ok(found)
    }

    fn is_of(&self, lower: Lower, groups: &[i32], trailing: &[i32]) -> bool {
        self.indptr == lower.indptr
            && self.groups == groups
            && self.trailing == trailing
            && self.indices == lower.indices
    }
}

/// Factor of a symmetric matrix whose interior block is positive definite.
#[derive(Debug)]
pub struct Cholesky {
    analysis: Arc<Analysis>,
    factor: Vec<f64>,
    schur: Mat<f64>,
    peak_bytes: u64,
    trailing_diagonal: Vec<f64>,
    schur_factor: OnceLock<Result<Mat<f64>, usize>>,
}

impl Cholesky {
    /// Factorises the matrix in at most so many bytes beyond it; `groups` and `trailing` have been
    /// checked by the caller.
    pub fn new(
        lower: Lower,
        values: &[f64],
        groups: &[i32],
        trailing: &[i32],
        most_bytes: u64,
    ) -> Result<Self, FactorError> {
        if trailing.len() > MOST_TRAILING {
            return Err(FactorError::TooLarge);
        }
        // two dense matrices of the trailing unknowns exist at a time
        let dense_bytes = 16 * (trailing.len() as u64).pow(2);
        ask(analysis_bytes(lower) + dense_bytes, most_bytes)?;
        let analysis = Analysis::of(lower, groups, trailing, most_bytes)?;
        let (forward, n_interior) = (&analysis.forward, analysis.n_interior);
        let diagonal: Vec<f64> = forward
            .iter()
            .map(|&old| values[lower.start(old as usize)])
            .collect();
        if let Some(k) = (0..n_interior).find(|&k| diagonal[k] <= 0.0) {
            return Err(not_positive(forward, k));
        }
        let need = numeric_scratch(&analysis.symbolic);
        let numeric_bytes = numeric_bytes(lower, &analysis.symbolic, need) + dense_bytes;
        ask(numeric_bytes, most_bytes)?;
        let source = analysis.matrix.source.iter();
        let mut numeric = Numeric {
            matrix: &analysis.matrix,
            values: source.map(|&p| values[p as usize]).collect(),
            diagonal,
            n_interior,
        };
        let (factor, schur) = numeric.factorised(&analysis.symbolic, forward)?;
        let trailing_diagonal = numeric.diagonal.split_off(n_interior);
        Ok(Self {
            analysis,
            factor,
            schur,
            peak_bytes: numeric_bytes.max(analysis_bytes(lower) + dense_bytes),
            trailing_diagonal,
            schur_factor: OnceLock::new(),
        })
    }

    fn forward(&self) -> &[u32] {
        &self.analysis.forward
    }

    fn n_interior(&self) -> usize {
        self.analysis.n_interior
    }

    pub fn n(&self) -> usize {
        self.forward().len()
    }

    pub fn n_trailing(&self) -> usize {
        self.n() - self.n_interior()
    }

    /// Entries stored for the factor, the padding of the supernodes included.
    pub fn factor_nonzeros(&self) -> usize {
        self.factor.len()
    }

    /// Bytes that the factorisation was expected to take at its peak, and for which it asked.
    pub fn peak_bytes(&self) -> u64 {
        self.peak_bytes
    }

    /// Unknowns kept last, as numbered by the caller.
    pub fn trailing(&self) -> &[u32] {
        &self.forward()[self.n_interior()..]
    }

    /// Schur complement of the trailing unknowns, both triangles.
    pub fn schur(&self) -> MatRef<'_, f64> {
        self.schur.as_ref()
    }

    /// Solves with the whole matrix, which must be positive definite.
    pub fn solve(&self, rhs: MatRef<f64>) -> Result<Mat<f64>, FactorError> {
        let held = self
            .schur_factor
            .get_or_init(|| {
                let tolerance = relative_pivot(self.n());
                factorised_dense(self.schur(), &self.trailing_diagonal, tolerance)
            })
            .as_ref()
            .map_err(|&k| not_positive(self.forward(), self.n_interior() + k))?;
        let mut x = gathered(rhs, |new| self.forward()[new] as usize);
        self.by_chunks(&mut x, |mut x| {
            self.eliminate(x.as_mut());
            let mut trailing = x.as_mut().subrows_mut(self.n_interior(), self.n_trailing());
            solve_lower_triangular_in_place(held.as_ref(), trailing.as_mut(), Par::Seq);
            solve_upper_triangular_in_place(held.transpose(), trailing, Par::Seq);
            self.substitute(x);
        });
        Ok(self.scattered(&x))
    }

    /// Right-hand side of the trailing unknowns once the interior is eliminated.
    pub fn condense(&self, rhs: MatRef<f64>) -> Mat<f64> {
        let mut x = gathered(rhs, |new| self.forward()[new] as usize);
        self.by_chunks(&mut x, |x| self.eliminate(x));
        x.subrows(self.n_interior(), self.n_trailing()).to_owned()
    }

    /// Whole solution from the trailing unknowns and the right-hand side of the interior.
    pub fn recover(&self, trailing_values: MatRef<f64>, rhs: MatRef<f64>) -> Mat<f64> {
        let mut x = gathered(rhs, |new| self.forward()[new] as usize);
        self.by_chunks(&mut x, |x| self.eliminate(x));
        x.as_mut()
            .subrows_mut(self.n_interior(), self.n_trailing())
            .copy_from(trailing_values);
        self.by_chunks(&mut x, |x| self.substitute(x));
        self.scattered(&x)
    }

    fn by_chunks(&self, x: &mut Mat<f64>, work: impl Fn(MatMut<f64>) + Sync + Send) {
        if x.ncols() <= CHUNK {
            work(x.as_mut());
        } else {
            x.as_mut().par_col_chunks_mut(CHUNK).for_each(work);
        }
    }

    fn scattered(&self, x: &Mat<f64>) -> Mat<f64> {
        let inverse = inverted(self.forward(), self.n());
        gathered(x.as_ref(), |old| inverse[old] as usize)
    }

    /// Forward solution of the interior columns: leaves `y_i = L_ii^-1 f_i` and `f_b - L_bi y_i`.
    fn eliminate(&self, mut x: MatMut<f64>) {
        let mut update = Vec::new();
        for panel in self.panels() {
            if x.ncols() <= NARROW {
                each_column(x.as_mut(), |column| panel.eliminate(column, &mut update));
                continue;
            }
            let mut top = x.as_mut().subrows_mut(panel.start, panel.n_columns);
            solve_lower_triangular_in_place(panel.top, top.as_mut(), Par::Seq);
            let mut update = Mat::zeros(panel.below.nrows(), top.ncols());
            matmul(&mut update, Accum::Replace, panel.below, top, 1.0, Par::Seq);
            for j in 0..x.ncols() {
                for (k, row) in panel.rows().enumerate() {
                    x[(row, j)] -= update[(k, j)];
                }
            }
        }
    }

    /// Backward solution of the interior columns, the trailing rows given.
    fn substitute(&self, mut x: MatMut<f64>) {
        let mut known = Vec::new();
        for panel in self.panels().rev() {
            if x.ncols() <= NARROW {
                each_column(x.as_mut(), |column| panel.substitute(column, &mut known));
                continue;
            }
            let mut known = Mat::zeros(panel.below.nrows(), x.ncols());
            for j in 0..x.ncols() {
                for (k, row) in panel.rows().enumerate() {
                    known[(k, j)] = x[(row, j)];
                }
            }
            let mut top = x.as_mut().subrows_mut(panel.start, panel.n_columns);
            matmul(
                top.as_mut(),
                Accum::Add,
                panel.below.transpose(),
                &known,
                -1.0,
                Par::Seq,
            );
            solve_upper_triangular_in_place(panel.top.transpose(), top, Par::Seq);
        }
    }

    /// Interior columns of each supernode; the last one may reach into the trailing block.
    fn panels(&self) -> impl DoubleEndedIterator<Item = Panel<'_>> {
        let begins = self.analysis.symbolic.supernode_begin();
        let n_panels = begins.partition_point(|&begin| (begin as usize) < self.n_interior());
        let factor = SupernodalLltRef::new(&self.analysis.symbolic, &self.factor);
        (0..n_panels).map(move |s| {
            let node = factor.supernode(s);
            let n_columns = node.val().ncols().min(self.n_interior() - node.start());
            let (top, below) = node.val().subcols(0, n_columns).split_at_row(n_columns);
            Panel {
                start: node.start(),
                n_columns,
                end: node.start() + node.val().ncols(),
                pattern: node.pattern(),
                top,
                below,
            }
        })
    }
}

/// Calls `work` with each column.
fn each_column(mut x: MatMut<f64>, mut work: impl FnMut(&mut [f64])) {
    for j in 0..x.ncols() {
        let column = x.as_mut().col_mut(j).try_as_col_major_mut();
        work(column.expect("columns are contiguous").as_slice_mut());
    }
}

/// Interior columns of one supernode: a triangle on top and the rows below it.
struct Panel<'a> {
    start: usize,
    n_columns: usize,
    end: usize,
    pattern: &'a [u32],
    top: MatRef<'a, f64>,
    below: MatRef<'a, f64>,
}

impl<'a> Panel<'a> {
    /// Rows of `below`: what is left of the diagonal block, then the pattern.
    fn rows(&self) -> impl Iterator<Item = usize> {
        (self.start + self.n_columns..self.end).chain(self.pattern.iter().map(|&row| row as usize))
    }

    /// Column k from its diagonal on: the rest of the triangle, and the rows below.
    fn column(&self, k: usize) -> (f64, &'a [f64], &'a [f64]) {
        let column = |part: MatRef<'a, f64>| {
            let whole = part.col(k).try_as_col_major();
            whole.expect("columns are contiguous").as_slice()
        };
        let top = &column(self.top)[k..];
        (top[0], &top[1..], column(self.below))
    }

    /// Forward solution of one right-hand side by this panel, faster than products of small matrices.
    fn eliminate(&self, x: &mut [f64], update: &mut Vec<f64>) {
        update.clear();
        update.resize(self.below.nrows(), 0.0);
        for k in 0..self.n_columns {
            let (diagonal, triangle, below) = self.column(k);
            let (solved, rest) = x[self.start + k..]
                .split_first_mut()
                .expect("a row of the panel");
            *solved /= diagonal;
            for (entry, l) in rest.iter_mut().zip(triangle) {
                *entry -= l * *solved;
            }
            for (entry, l) in update.iter_mut().zip(below) {
                *entry += l * *solved;
            }
        }
        for (row, entry) in self.rows().zip(update) {
            x[row] -= *entry;
        }
    }

    /// Backward solution of one right-hand side by this panel.
    fn substitute(&self, x: &mut [f64], known: &mut Vec<f64>) {
        known.clear();
        known.extend(self.rows().map(|row| x[row]));
        for k in (0..self.n_columns).rev() {
            let (diagonal, triangle, below) = self.column(k);
            let (solved, rest) = x[self.start + k..]
                .split_first_mut()
                .expect("a row of the panel");
            *solved = (*solved - dot(triangle, rest) - dot(below, known)) / diagonal;
        }
    }
}

/// Sum of products over the shorter length, in eight parts, which the compiler vectorises.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let b = &b[..a.len()];
    let mut sums = [0.0; 8];
    for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    let rest = a.len() / 8 * 8;
    sums.iter().sum::<f64>()
        + a[rest..]
            .iter()
            .zip(&b[rest..])
            .map(|(a, b)| a * b)
            .sum::<f64>()
}

/// The permuted matrix while it is factorised.
struct Numeric<'a> {
    matrix: &'a Permuted,
    values: Vec<f64>,
    diagonal: Vec<f64>,
    n_interior: usize,
}

impl Numeric<'_> {
    /// The factor with a shifted trailing diagonal, and the Schur complement without the shift.
    fn factorised(
        &mut self,
        symbolic: &SymbolicSupernodalCholesky<u32>,
        forward: &[u32],
    ) -> Result<(Vec<f64>, Mat<f64>), FactorError> {
        let mut factor = zeros(symbolic.len_val())?;
        let mut shift = self.first_shift();
        let begins = symbolic.supernode_begin();
        let mut failed = None;
        for _ in 0..MOST_SHIFTS {
            failed = self.attempt(symbolic, &shift, &mut factor)?;
            // pivots of a supernode that was left half-way are not final
            let complete = failed.map_or(self.n_interior, |k| {
                let after = begins.partition_point(|&begin| begin as usize <= k);
                (begins[after - 1] as usize).min(self.n_interior)
            });
            if let Some(k) = self.small_pivot(symbolic, &factor, complete) {
                return Err(not_positive(forward, k));
            }
            match failed {
                None => {
                    let schur = self.schur(symbolic, &factor, &shift);
                    return Ok((factor, schur));
                }
                Some(k) if k < self.n_interior => break,
                // an indefinite Schur complement: its size is that of the shift or more
                Some(_) => shift.iter_mut().for_each(|s| *s *= SHIFT_GROWTH),
            }
        }
        Err(not_positive(forward, failed.unwrap_or(self.n_interior)))
    }

    fn first_shift(&self) -> Vec<f64> {
        let largest = self.values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let otherwise = if largest > 0.0 { largest } else { 1.0 };
        self.diagonal[self.n_interior..]
            .iter()
            .map(|&d| if d > 0.0 { d } else { otherwise })
            .collect()
    }

    /// Factorises once; `Some(k)` tells the column whose pivot was not positive.
    fn attempt(
        &mut self,
        symbolic: &SymbolicSupernodalCholesky<u32>,
        shift: &[f64],
        factor: &mut [f64],
    ) -> Result<Option<usize>, FactorError> {
        let n = self.diagonal.len();
        for (k, s) in shift.iter().enumerate() {
            let column = self.n_interior + k;
            let range =
                self.matrix.col_ptr[column] as usize..self.matrix.col_ptr[column + 1] as usize;
            for position in range {
                if self.matrix.row_idx[position] as usize == column {
                    self.values[position] = self.diagonal[column] + s;
                }
            }
        }
        let pattern = SymbolicSparseColMatRef::new_unsorted_checked(
            n,
            n,
            &self.matrix.col_ptr,
            None,
            &self.matrix.row_idx,
        );
        let params = Default::default();
        let mut buffer = scratch(numeric_scratch(symbolic))?;
        let outcome = factorize_supernodal_numeric_llt(
            factor,
            SparseColMatRef::new(pattern, self.values.as_slice()),
            dense::LltRegularization::default(),
            symbolic,
            Par::Seq,
            MemStack::new(&mut buffer),
            params,
        );
        Ok(match outcome {
            Ok(_) => None,
            Err(dense::LltError::NonPositivePivot { index }) => Some(index),
        })
    }

    /// First of the columns `0..complete` whose pivot is too small beside its diagonal entry.
    fn small_pivot(
        &self,
        symbolic: &SymbolicSupernodalCholesky<u32>,
        factor: &[f64],
        complete: usize,
    ) -> Option<usize> {
        let factor = SupernodalLltRef::new(symbolic, factor);
        let tolerance = relative_pivot(self.diagonal.len());
        for (s, &begin) in symbolic.supernode_begin().iter().enumerate() {
            let begin = begin as usize;
            if begin >= complete {
                break;
            }
            let block = factor.supernode(s).val();
            for k in 0..block.ncols().min(complete - begin) {
                let pivot = block[(k, k)] * block[(k, k)];
                if pivot.is_nan() || pivot <= tolerance * self.diagonal[begin + k] {
                    return Some(begin + k);
                }
            }
        }
        None
    }

    /// `S = L_bb L_bb^T` without the shift.
    fn schur(
        &self,
        symbolic: &SymbolicSupernodalCholesky<u32>,
        factor: &[f64],
        shift: &[f64],
    ) -> Mat<f64> {
        let (n_interior, n_trailing) = (self.n_interior, shift.len());
        let factor = SupernodalLltRef::new(symbolic, factor);
        let mut block = Mat::<f64>::zeros(n_trailing, n_trailing);
        for s in 0..symbolic.n_supernodes() {
            let (node, start) = (factor.supernode(s), factor.supernode(s).start());
            let n_columns = node.val().ncols();
            for k in n_interior.saturating_sub(start)..n_columns {
                let column = start + k - n_interior;
                for i in k..n_columns {
                    block[(start + i - n_interior, column)] = node.val()[(i, k)];
                }
                for (i, &row) in node.pattern().iter().enumerate() {
                    block[(row as usize - n_interior, column)] = node.val()[(n_columns + i, k)];
                }
            }
        }
        let mut schur = Mat::<f64>::zeros(n_trailing, n_trailing);
        triangular::matmul(
            schur.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Replace,
            block.as_ref(),
            BlockStructure::TriangularLower,
            block.transpose(),
            BlockStructure::TriangularUpper,
            1.0,
            Par::Seq,
        );
        for j in 0..n_trailing {
            schur[(j, j)] -= shift[j];
            for i in 0..j {
                schur[(i, j)] = schur[(j, i)];
            }
        }
        schur
    }
}

fn numeric_scratch(symbolic: &SymbolicSupernodalCholesky<u32>) -> StackReq {
    factorize_supernodal_numeric_llt_scratch::<u32, f64>(symbolic, Par::Seq, Default::default())
}

/// A pivot below this part of the diagonal entry that it began as counts as zero.
///
/// Rounding makes the pivots of a body that floats about `n / 2` units large instead of zero
/// (elastic grids of 32 to 320,000 unknowns), so a pivot of that size says nothing.
fn relative_pivot(n: usize) -> f64 {
    RELATIVE_PIVOT.max(2.0 * f64::EPSILON * n as f64)
}

/// Dense Cholesky factor, or the first column whose pivot is not positive.
fn factorised_dense(
    matrix: MatRef<f64>,
    diagonal: &[f64],
    tolerance: f64,
) -> Result<Mat<f64>, usize> {
    let n = matrix.nrows();
    let mut factor = matrix.to_owned();
    let params = Default::default();
    let need = dense::cholesky_in_place_scratch::<f64>(n, Par::Seq, params);
    let outcome = dense::cholesky_in_place(
        factor.as_mut(),
        dense::LltRegularization::default(),
        Par::Seq,
        MemStack::new(&mut faer::dyn_stack::MemBuffer::new(need)),
        params,
    );
    let failed = match outcome {
        Ok(_) => n,
        Err(dense::LltError::NonPositivePivot { index }) => index,
    };
    let small = |k: &usize| {
        let pivot = factor[(*k, *k)] * factor[(*k, *k)];
        pivot.is_nan() || pivot <= tolerance * diagonal[*k]
    };
    match (0..failed).find(small) {
        Some(k) => Err(k),
        None if failed < n => Err(failed),
        None => Ok(factor),
    }
}

fn not_positive(forward: &[u32], k: usize) -> FactorError {
    FactorError::NotPositiveDefinite {
        unknown: forward[k] as usize,
    }
}
