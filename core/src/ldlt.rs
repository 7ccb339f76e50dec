//! Sparse factor of a symmetric indefinite matrix, and solutions with refinement.
//!
//! Pivots are chosen inside of a supernode only (Bunch and Kaufman, 1977), so the ordering sees to
//! it that an unknown without a diagonal entry (a multiplier) comes after all its neighbours, and
//! every solution is refined with, and checked by, its residual. The matrix is scaled first, by
//! powers of two and so without rounding, until the largest entry of each row is about one: then
//! multipliers and displacements in any units compare.

use crate::error::FactorError;
use crate::memory::{ask, scratch, zeros};
use crate::ordering::{Lower, inverted, minimum_degree, postordered, zero_diagonals_last};
use crate::symbolic::{CHUNK, analysed, analysis_bytes, gathered, numeric_bytes, permuted_values};
use faer::dyn_stack::MemStack;
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::supernodal::{
    SupernodalIntranodeLbltRef, SymbolicSupernodalCholesky,
    factorize_supernodal_numeric_intranode_lblt,
    factorize_supernodal_numeric_intranode_lblt_scratch,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

/// A diagonal entry below this part of the largest entry of its row counts as zero.
const ZERO_DIAGONAL: f64 = 1e-14;
/// Refinement stops at this backward error, which is rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
const MOST_REFINEMENTS: usize = 5;
/// Refinement goes on while it divides the backward error by two.
const LEAST_PROGRESS: f64 = 0.5;
/// A last correction that is still this part of the solution tells that no digit is certain.
const LARGEST_CORRECTION: f64 = 1e-3;
/// A solution whose backward error stays above this, which is round-off, is refused: then no pivot
/// within the supernodes was stable, or the matrix is singular.
const LARGEST_BACKWARD_ERROR: f64 = 16.0 * f64::EPSILON;
/// Norm of the solution beside that of the right-hand side from which the matrix counts as singular.
const LARGEST_GROWTH: f64 = 1e14;
const N_SCALINGS: usize = 4;

/// Factor of a symmetric matrix, with the matrix itself to refine solutions against.
#[derive(Debug)]
pub struct Ldlt {
    indptr: Vec<i64>,
    indices: Vec<i32>,
    /// Of the scaled matrix, as are the row sum and the factor.
    values: Vec<f64>,
    largest_row_sum: f64,
    scale: Vec<f64>,
    /// Old number of each row of the factor, after the pivoting.
    forward: Vec<u32>,
    pivots: (Vec<u32>, Vec<u32>),
    symbolic: SymbolicSupernodalCholesky<u32>,
    factor: Vec<f64>,
    subdiagonal: Vec<f64>,
}

impl Ldlt {
    /// Factorises the matrix in at most so many bytes beyond it; `groups` has been checked by the
    /// caller.
    pub fn new(
        lower: Lower,
        values: &[f64],
        groups: &[i32],
        most_bytes: u64,
    ) -> Result<Self, FactorError> {
        let n = lower.n();
        // the scaled values, and at the end a copy of the matrix to refine solutions with
        let copies = 12 * lower.indices.len() as u64 + 40 * n as u64;
        ask(analysis_bytes(lower) + copies, most_bytes)?;
        let (scale, values) = equilibrated(lower, values);
        let (row_sums, is_zero) = row_facts(lower, &values);
        let order = minimum_degree(lower, groups, &vec![true; n])?;
        let order = postordered(lower, &zero_diagonals_last(lower, &is_zero, &order));
        let inverse = inverted(&order, n);
        let symbolic = analysed(lower, &inverse)?;
        let params = Default::default();
        let need = factorize_supernodal_numeric_intranode_lblt_scratch::<u32, f64>(
            &symbolic,
            Par::Seq,
            params,
        );
        ask(numeric_bytes(lower, &symbolic, need) + copies, most_bytes)?;
        let (matrix, moved) = permuted_values(lower, &values, &inverse);
        let pattern = SymbolicSparseColMatRef::new_unsorted_checked(
            n,
            n,
            &matrix.col_ptr,
            None,
            &matrix.row_idx,
        );
        let mut factor = zeros(symbolic.len_val())?;
        let mut subdiagonal = vec![0.0; n];
        let mut pivots = (vec![0u32; n], vec![0u32; n]);
        let mut buffer = scratch(need)?;
        factorize_supernodal_numeric_intranode_lblt(
            &mut factor,
            &mut subdiagonal,
            &mut pivots.0,
            &mut pivots.1,
            SparseColMatRef::new(pattern, moved.as_slice()),
            &symbolic,
            Par::Seq,
            MemStack::new(&mut buffer),
            params,
        );
        Ok(Self {
            indptr: lower.indptr.to_vec(),
            indices: lower.indices.to_vec(),
            values,
            largest_row_sum: row_sums.into_iter().fold(0.0, f64::max),
            scale,
            forward: pivots.0.iter().map(|&p| order[p as usize]).collect(),
            pivots,
            symbolic,
            factor,
            subdiagonal,
        })
    }

    pub fn n(&self) -> usize {
        self.forward.len()
    }

    /// Solves and refines; fails where the equation is missed all the same.
    pub fn solve(&self, rhs: MatRef<f64>) -> Result<Mat<f64>, FactorError> {
        let scaled = |matrix: MatRef<f64>| {
            Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
                self.scale[i] * matrix[(i, j)]
            })
        };
        let rhs = scaled(rhs);
        let mut x = Mat::zeros(rhs.nrows(), rhs.ncols());
        x.as_mut()
            .par_col_chunks_mut(CHUNK)
            .zip(rhs.par_col_chunks(CHUNK))
            .try_for_each(|(x, rhs)| self.refined(x, rhs))?;
        Ok(scaled(x.as_ref()))
    }

    /// Solves a few columns, with one correction at least.
    fn refined(&self, mut x: MatMut<f64>, rhs: MatRef<f64>) -> Result<(), FactorError> {
        x.copy_from(self.applied(rhs)?);
        let mut best = f64::INFINITY;
        let mut certain = false;
        let mut kept = x.to_owned();
        for step in 0..=MOST_REFINEMENTS {
            let residual = self.residual(x.as_ref(), rhs);
            let error = self.backward_error(x.as_ref(), rhs, residual.as_ref());
            let progress = error <= LEAST_PROGRESS * best;
            if error < best {
                best = error;
                kept.copy_from(x.as_ref());
            }
            if !progress || step == MOST_REFINEMENTS {
                break; // not a number makes no progress
            }
            if certain && best <= ROUNDING {
                break;
            }
            let correction = self.applied(residual.as_ref())?;
            certain = (0..x.ncols()).all(|j| {
                largest(correction.as_ref(), j) <= LARGEST_CORRECTION * largest(x.as_ref(), j)
            });
            x += &correction;
        }
        if best > LARGEST_BACKWARD_ERROR || !certain {
            return Err(FactorError::Singular);
        }
        x.copy_from(&kept);
        let grown = (0..x.ncols()).any(|j| {
            let size = self.largest_row_sum * largest(x.as_ref(), j);
            size > LARGEST_GROWTH * largest(rhs, j)
        });
        match grown {
            true => Err(FactorError::Singular),
            false => Ok(()),
        }
    }

    /// Applies the factor alone.
    fn applied(&self, rhs: MatRef<f64>) -> Result<Mat<f64>, FactorError> {
        let n = self.n();
        let mut y = gathered(rhs, |new| self.forward[new] as usize);
        let mut buffer = scratch(
            self.symbolic
                .solve_in_place_scratch::<f64>(rhs.ncols(), Par::Seq),
        )?;
        SupernodalIntranodeLbltRef::new(
            &self.symbolic,
            &self.factor,
            &self.subdiagonal,
            PermRef::new_checked(&self.pivots.0, &self.pivots.1, n),
        )
        .solve_in_place_no_numeric_permute_with_conj(
            Conj::No,
            y.as_mut(),
            Par::Seq,
            MemStack::new(&mut buffer),
        );
        let inverse = inverted(&self.forward, n);
        Ok(gathered(y.as_ref(), |old| inverse[old] as usize))
    }

    fn residual(&self, x: MatRef<f64>, rhs: MatRef<f64>) -> Mat<f64> {
        let lower = Lower {
            indptr: &self.indptr,
            indices: &self.indices,
        };
        let mut residual = rhs.to_owned();
        for column in 0..x.ncols() {
            for j in 0..lower.n() {
                for position in lower.range(j) {
                    let (i, value) = (self.indices[position] as usize, self.values[position]);
                    residual[(i, column)] -= value * x[(j, column)];
                    if i != j {
                        residual[(j, column)] -= value * x[(i, column)];
                    }
                }
            }
        }
        residual
    }

    /// Largest normwise backward error of the columns (Rigal and Gaches, 1967); NaN if not finite.
    fn backward_error(&self, x: MatRef<f64>, rhs: MatRef<f64>, residual: MatRef<f64>) -> f64 {
        let mut worst = 0.0f64;
        for j in 0..x.ncols() {
            let missed = largest(residual, j);
            let scale = self.largest_row_sum * largest(x, j) + largest(rhs, j);
            if !missed.is_finite() || !scale.is_finite() {
                return f64::NAN;
            }
            if missed > 0.0 {
                worst = worst.max(missed / scale);
            }
        }
        worst
    }
}

/// Largest absolute entry of a column; NaN if one is NaN.
fn largest(matrix: MatRef<f64>, j: usize) -> f64 {
    (0..matrix.nrows()).fold(0.0, |m: f64, i| match matrix[(i, j)].abs() {
        value if value > m || value.is_nan() => value,
        _ => m,
    })
}

/// Scale of each unknown and the scaled values: rows and columns are divided by the root of
/// their largest entry, over and over (Ruiz, 2001), to the next power of two.
fn equilibrated(lower: Lower, values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let n = lower.n();
    let mut scale = vec![1.0f64; n];
    let mut scaled = values.to_vec();
    for _ in 0..N_SCALINGS {
        let mut largest = vec![0.0f64; n];
        for j in 0..n {
            for position in lower.range(j) {
                let (i, value) = (lower.indices[position] as usize, scaled[position].abs());
                largest[i] = largest[i].max(value);
                largest[j] = largest[j].max(value);
            }
        }
        for (factor, &size) in scale.iter_mut().zip(&largest) {
            if size > 0.0 {
                *factor *= (-0.5 * size.log2()).round().exp2();
            }
        }
        for j in 0..n {
            for position in lower.range(j) {
                let i = lower.indices[position] as usize;
                scaled[position] = values[position] * scale[i] * scale[j];
            }
        }
    }
    (scale, scaled)
}

/// Sum of the absolute entries of each row, and whether its diagonal entry counts as zero.
fn row_facts(lower: Lower, values: &[f64]) -> (Vec<f64>, Vec<bool>) {
    let n = lower.n();
    let (mut sums, mut largest) = (vec![0.0; n], vec![0.0f64; n]);
    for j in 0..n {
        for position in lower.range(j) {
            let (i, value) = (lower.indices[position] as usize, values[position].abs());
            sums[i] += value;
            largest[i] = largest[i].max(value);
            if i != j {
                sums[j] += value;
                largest[j] = largest[j].max(value);
            }
        }
    }
    let is_zero = (0..n)
        .map(|j| values[lower.start(j)].abs() <= ZERO_DIAGONAL * largest[j])
        .collect();
    (sums, is_zero)
}
