//! The factors against dense elimination on small matrices.

use _core::cholesky::Cholesky;
use _core::error::FactorError;
use _core::ldlt::Ldlt;
use _core::ordering::Lower;
use faer::Mat;

/// A symmetric matrix held dense and as a lower triangle.
struct Sample {
    dense: Mat<f64>,
    indptr: Vec<i64>,
    indices: Vec<i32>,
    values: Vec<f64>,
}

impl Sample {
    fn new(n: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let dense = Mat::from_fn(n, n, |i, j| entry(i.max(j), i.min(j)));
        let (mut indptr, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
        for j in 0..n {
            for i in j..n {
                if i == j || dense[(i, j)] != 0.0 {
                    indices.push(i as i32);
                    values.push(dense[(i, j)]);
                }
            }
            indptr.push(indices.len() as i64);
        }
        Self {
            dense,
            indptr,
            indices,
            values,
        }
    }

    fn lower(&self) -> Lower<'_> {
        Lower::new(&self.indptr, &self.indices).unwrap()
    }

    fn misses(&self, x: &Mat<f64>, rhs: &Mat<f64>) -> f64 {
        let residual = &self.dense * x - rhs;
        residual.norm_max()
    }
}

fn singles(n: usize) -> Vec<i32> {
    (0..n as i32).collect()
}

/// Chain of springs, free at both ends unless `ground` holds the first.
fn chain(n: usize, ground: f64) -> Sample {
    Sample::new(n, |i, j| match i - j {
        0 => {
            f64::from((i > 0) as u8)
                + f64::from((i + 1 < n) as u8)
                + ground * f64::from((i == 0) as u8)
        }
        1 => -1.0,
        _ => 0.0,
    })
}

#[test]
fn springs_in_series_condense_to_one_spring() {
    let sample = chain(11, 0.0);
    let factor = Cholesky::new(
        sample.lower(),
        &sample.values,
        &singles(11),
        &[10, 0],
        u64::MAX,
    )
    .unwrap();
    let schur = factor.schur();
    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let expected = if i == j { 0.1 } else { -0.1 };
        assert!((schur[(i, j)] - expected).abs() < 1e-15);
    }
}

#[test]
fn solving_meets_the_equation_for_many_columns() {
    let sample = chain(50, 1.0);
    let rhs = Mat::from_fn(50, 70, |i, j| ((i * 31 + j * 17) as f64).sin());
    let factor = Cholesky::new(
        sample.lower(),
        &sample.values,
        &singles(50),
        &[3, 40, 7],
        u64::MAX,
    )
    .unwrap();
    assert!(sample.misses(&factor.solve(rhs.as_ref()).unwrap(), &rhs) < 1e-12);
}

#[test]
fn a_pattern_is_analysed_once_for_other_values_but_not_for_other_trailing_unknowns_or_groups() {
    let pairs: Vec<i32> = (0..12).map(|i| i / 2).collect();
    for groups in [singles(12), pairs] {
        for trailing in [vec![], vec![7, 2], vec![2, 7]] {
            for ground in [1.0, 3.0] {
                let sample = chain(12, ground);
                let factor =
                    Cholesky::new(sample.lower(), &sample.values, &groups, &trailing, u64::MAX)
                        .unwrap();
                let kept: Vec<u32> = trailing.iter().map(|&i| i as u32).collect();
                assert_eq!(factor.trailing(), kept);
                let rhs = Mat::from_fn(12, 2, |i, j| (i + j) as f64);
                let x = factor.solve(rhs.as_ref()).unwrap();
                assert!(sample.misses(&x, &rhs) < 1e-11);
            }
        }
    }
}

#[test]
fn an_indefinite_schur_complement_is_exact() {
    // K_ii = 1, K_bi = 1000, K_bb = 1: S = 1 - 1e6
    let sample = Sample::new(2, |i, j| if i == j { 1.0 } else { 1000.0 });
    let factor = Cholesky::new(sample.lower(), &sample.values, &[0, 1], &[1], u64::MAX).unwrap();
    assert!((factor.schur()[(0, 0)] - (1.0 - 1e6)).abs() < 1e-8);
    let error = factor.solve(Mat::<f64>::zeros(2, 1).as_ref()).unwrap_err();
    assert_eq!(error, FactorError::NotPositiveDefinite { unknown: 1 });
}

#[test]
fn a_floating_chain_is_refused() {
    let sample = chain(30, 0.0);
    let error =
        Cholesky::new(sample.lower(), &sample.values, &singles(30), &[], u64::MAX).unwrap_err();
    assert!(matches!(error, FactorError::NotPositiveDefinite { .. }));
}

#[test]
fn a_multiplier_holds_a_floating_chain() {
    // the last unknown ties the first node of the chain
    let free = chain(20, 0.0);
    let sample = Sample::new(21, |i, j| match (i, j) {
        (20, 0) => 1.0,
        (20, _) => 0.0,
        _ => free.dense[(i, j)],
    });
    let rhs = Mat::from_fn(21, 40, |i, j| ((i + 3 * j) as f64).cos());
    let factor = Ldlt::new(sample.lower(), &sample.values, &singles(21), u64::MAX).unwrap();
    assert!(sample.misses(&factor.solve(rhs.as_ref()).unwrap(), &rhs) < 1e-11);
}

#[test]
fn a_singular_matrix_gives_no_solution() {
    let sample = chain(20, 0.0);
    let factor = Ldlt::new(sample.lower(), &sample.values, &singles(20), u64::MAX).unwrap();
    let rhs = Mat::from_fn(20, 1, |i, _| (i as f64).cos());
    assert_eq!(
        factor.solve(rhs.as_ref()).unwrap_err(),
        FactorError::Singular
    );
}
