//! Python face of the sparse machinery: checks of dtype, shape, contiguity and finite values.

pub mod cholesky;
pub mod error;
pub mod ldlt;
pub mod memory;
mod nodal_graph;
pub mod ordering;
pub mod pattern;
pub mod symbolic;

use error::FactorError;
use faer::{Mat, MatRef};
use numpy::ndarray::{Array2, ArrayView1, Ix1, Ix2, Ix3};
use numpy::{
    Element, IntoPyArray, PyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray,
    PyUntypedArray, PyUntypedArrayMethods,
};
use ordering::Lower;
use pyo3::exceptions::{PyArithmeticError, PyMemoryError, PyValueError};
use pyo3::prelude::*;

pyo3::create_exception!(
    flangeway._core,
    NotPositiveDefiniteError,
    PyArithmeticError,
    "A pivot is not positive; the arguments are the message and the number of the unknown."
);
pyo3::create_exception!(
    flangeway._core,
    SingularMatrixError,
    PyArithmeticError,
    "The matrix is singular, or so close to it that no solution meets its equation."
);
pyo3::create_exception!(
    flangeway._core,
    FactorTooLargeError,
    PyMemoryError,
    "Too many entries or too little memory; the arguments are the message and the bytes needed, or None."
);

impl From<FactorError> for PyErr {
    fn from(error: FactorError) -> Self {
        match error {
            FactorError::NotPositiveDefinite { unknown } => NotPositiveDefiniteError::new_err((
                format!(
                    "the matrix is not positive definite: the pivot of unknown {unknown} is not positive"
                ),
                unknown,
            )),
            FactorError::TooLarge => FactorTooLargeError::new_err((
                "the factor has more than 2^31 - 1 entries",
                None::<u64>,
            )),
            FactorError::NoMemory { needed } => FactorTooLargeError::new_err((
                format!("{needed} bytes are needed, more than there are or may be used"),
                Some(needed),
            )),
            FactorError::Singular => SingularMatrixError::new_err(
                "the matrix is singular to working precision: the solution misses its equation",
            ),
        }
    }
}

/// Name of the dtype and shape of what was given, for messages.
fn described(object: &Bound<PyAny>) -> String {
    match object.cast::<PyUntypedArray>() {
        Ok(array) => format!("{} of shape {:?}", array.dtype(), array.shape()),
        Err(_) => format!("an object of {}", object.get_type()),
    }
}

/// The array as `T` with the dimension `D`; the message contains `wanted`.
fn typed<'py, T: Element, D: numpy::ndarray::Dimension>(
    object: &Bound<'py, PyAny>,
    name: &str,
    wanted: &str,
) -> PyResult<PyReadonlyArray<'py, T, D>> {
    object
        .cast::<PyArray<T, D>>()
        .ok()
        .and_then(|array| array.try_readonly().ok())
        .ok_or_else(|| {
            PyValueError::new_err(format!(
                "{name} must be {wanted}, got {}",
                described(object)
            ))
        })
}

/// Contents of an array that lies in memory in C order.
fn contiguous<'a, T: Element, D: numpy::ndarray::Dimension>(
    array: &'a PyReadonlyArray<'_, T, D>,
    name: &str,
) -> PyResult<&'a [T]> {
    if !array.is_c_contiguous() {
        return Err(PyValueError::new_err(format!(
            "{name} must be contiguous in C order; numpy.ascontiguousarray makes it so"
        )));
    }
    array
        .as_slice()
        .map_err(|error| PyValueError::new_err(format!("{name}: {error}")))
}

fn finite<'a>(mut values: impl Iterator<Item = &'a f64>, name: &str) -> PyResult<()> {
    match values.all(|value| value.is_finite()) {
        true => Ok(()),
        false => Err(PyValueError::new_err(format!(
            "{name} must be finite, got NaN or infinity"
        ))),
    }
}

/// A column or a matrix of right-hand sides, copied; the flag tells a column.
fn dense(object: &Bound<PyAny>, name: &str, n: usize) -> PyResult<(Mat<f64>, bool)> {
    let wanted = format!("float64 of shape ({n},) or ({n}, m)");
    let (matrix, is_column) = match typed::<f64, Ix1>(object, name, &wanted) {
        Ok(array) => {
            let view = array.as_array();
            (Mat::from_fn(view.len(), 1, |i, _| view[i]), true)
        }
        Err(_) => {
            let array = typed::<f64, Ix2>(object, name, &wanted)?;
            let view = array.as_array();
            (
                Mat::from_fn(view.nrows(), view.ncols(), |i, j| view[(i, j)]),
                false,
            )
        }
    };
    if matrix.nrows() != n {
        return Err(PyValueError::new_err(format!(
            "{name} must be {wanted}, got {}",
            described(object)
        )));
    }
    Ok((matrix, is_column))
}

fn finite_columns(matrix: &Mat<f64>, name: &str) -> PyResult<()> {
    (0..matrix.ncols()).try_for_each(|j| finite(matrix.col(j).iter(), name))
}

/// Asks for the memory of a solution, of whose size four matrices exist at a time, and for threads.
fn ask_for_columns(object: &Bound<PyAny>) -> PyResult<()> {
    let array = object.cast::<PyUntypedArray>();
    let shape = array.map_or(&[][..], |array| array.shape());
    let n_entries: usize = shape.iter().product();
    let n_tasks = shape.get(1).copied().unwrap_or(1).div_ceil(symbolic::CHUNK);
    memory::start_threads()?;
    let n_threads = rayon::current_num_threads().min(n_tasks) as u64;
    memory::ask_for_threads(32 * n_entries as u64, u64::MAX, n_threads)?;
    Ok(())
}

/// The result in the shape of the right-hand side.
fn given_back<'py>(py: Python<'py>, matrix: &Mat<f64>, is_column: bool) -> Bound<'py, PyAny> {
    if is_column {
        PyArray1::from_iter(py, matrix.col(0).iter().copied()).into_any()
    } else {
        as_array(py, matrix.as_ref()).into_any()
    }
}

fn as_array<'py>(py: Python<'py>, matrix: MatRef<f64>) -> Bound<'py, PyArray2<f64>> {
    let shape = (matrix.nrows(), matrix.ncols());
    Array2::from_shape_fn(shape, |(i, j)| matrix[(i, j)]).into_pyarray(py)
}

/// Read-only array over memory that `owner` holds and never changes.
fn view_of<'py, T: Element>(values: &[T], owner: Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    // SAFETY: the classes are frozen, so the memory neither moves nor changes while the owner lives
    let array = unsafe { PyArray1::borrow_from_array(&ArrayView1::from(values), owner) }.into_any();
    array.getattr("flags")?.setattr("writeable", false)?;
    Ok(array)
}

/// The arguments that Cholesky and LDLT share.
struct Matrix<'py> {
    indptr: PyReadonlyArray<'py, i64, Ix1>,
    indices: PyReadonlyArray<'py, i32, Ix1>,
    values: PyReadonlyArray<'py, f64, Ix1>,
    groups: PyReadonlyArray<'py, i32, Ix1>,
}

impl<'py> Matrix<'py> {
    fn new(
        indptr: &Bound<'py, PyAny>,
        indices: &Bound<'py, PyAny>,
        values: &Bound<'py, PyAny>,
        groups: &Bound<'py, PyAny>,
    ) -> PyResult<Self> {
        Ok(Self {
            indptr: typed(indptr, "indptr", "int64 of shape (n + 1,)")?,
            indices: typed(indices, "indices", "int32 of shape (n_entries,)")?,
            values: typed(values, "values", "float64 of shape (n_entries,)")?,
            groups: typed(groups, "groups", "int32 of shape (n,)")?,
        })
    }

    /// Structure, values and groups, checked.
    fn parts(&self) -> PyResult<(Lower<'_>, &[f64], &[i32])> {
        let indptr = contiguous(&self.indptr, "indptr")?;
        let indices = contiguous(&self.indices, "indices")?;
        let values = contiguous(&self.values, "values")?;
        let groups = contiguous(&self.groups, "groups")?;
        let lower = Lower::new(indptr, indices).map_err(PyValueError::new_err)?;
        for (name, given, wanted) in [
            ("values", values.len(), indices.len()),
            ("groups", groups.len(), lower.n()),
        ] {
            if given != wanted {
                return Err(PyValueError::new_err(format!(
                    "{name} must have {wanted} entries, got {given}"
                )));
            }
        }
        finite(values.iter(), "values")?;
        Ok((lower, values, groups))
    }
}

/// Refuses trailing unknowns that are out of range or named twice.
fn check_trailing(trailing: &[i32], n: usize) -> PyResult<()> {
    let mut seen = vec![false; n];
    for &unknown in trailing {
        if unknown < 0 || unknown as usize >= n {
            return Err(PyValueError::new_err(format!(
                "trailing must hold unknowns in 0..{n}, got {unknown}"
            )));
        }
        if std::mem::replace(&mut seen[unknown as usize], true) {
            return Err(PyValueError::new_err(format!(
                "trailing must name each unknown once, got {unknown} twice"
            )));
        }
    }
    Ok(())
}

/// Number of threads that share the work.
#[pyfunction]
fn n_threads() -> PyResult<usize> {
    memory::start_threads()?;
    Ok(rayon::current_num_threads())
}

/// Sparsity pattern of ragged cells, found once; their matrices are summed into it many times.
#[pyclass(frozen, module = "flangeway._core")]
struct Pattern {
    inner: pattern::Pattern,
}

#[pymethods]
impl Pattern {
    #[new]
    fn new(py: Python<'_>, n_dofs: usize, batches: Vec<Bound<'_, PyAny>>) -> PyResult<Self> {
        let arrays = batches
            .iter()
            .enumerate()
            .map(|(b, batch)| {
                typed::<i32, Ix2>(
                    batch,
                    &format!("batches[{b}]"),
                    "int32 of shape (n_local, n_cells)",
                )
            })
            .collect::<PyResult<Vec<_>>>()?;
        let cells = arrays
            .iter()
            .enumerate()
            .map(|(b, array)| {
                Ok(pattern::Batch {
                    n_local: array.shape()[0],
                    n_cells: array.shape()[1],
                    dofs: contiguous(array, &format!("batches[{b}]"))?,
                })
            })
            .collect::<PyResult<Vec<_>>>()?;
        memory::start_threads()?;
        memory::ask(pattern::pattern_bytes(n_dofs, &cells), u64::MAX)?;
        let inner = py
            .detach(|| pattern::Pattern::new(n_dofs, &cells))
            .map_err(PyValueError::new_err)?;
        Ok(Self { inner })
    }

    #[getter]
    fn n_dofs(&self) -> usize {
        self.inner.n_dofs()
    }

    #[getter]
    fn indptr<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        view_of(slf.get().inner.indptr(), slf.clone().into_any())
    }

    #[getter]
    fn indices<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        view_of(slf.get().inner.indices(), slf.clone().into_any())
    }

    fn scatter<'py>(
        &self,
        py: Python<'py>,
        matrices: Vec<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let shapes = self.inner.shapes();
        if matrices.len() != shapes.len() {
            return Err(PyValueError::new_err(format!(
                "matrices must hold one array for each of the {} batches, got {}",
                shapes.len(),
                matrices.len()
            )));
        }
        let arrays = matrices
            .iter()
            .zip(&shapes)
            .enumerate()
            .map(|(b, (matrix, &(n_local, n_cells)))| {
                let name = format!("matrices[{b}]");
                let wanted = format!("float64 of shape ({n_local}, {n_local}, {n_cells})");
                let array = typed::<f64, Ix3>(matrix, &name, &wanted)?;
                match array.shape() == [n_local, n_local, n_cells] {
                    true => Ok(array),
                    false => Err(PyValueError::new_err(format!(
                        "{name} must be {wanted}, got {}",
                        described(matrix)
                    ))),
                }
            })
            .collect::<PyResult<Vec<_>>>()?;
        let slices = arrays
            .iter()
            .enumerate()
            .map(|(b, array)| contiguous(array, &format!("matrices[{b}]")))
            .collect::<PyResult<Vec<_>>>()?;
        memory::start_threads()?;
        memory::ask(self.inner.scatter_bytes(), u64::MAX)?;
        let values = py.detach(|| self.inner.scatter(&slices));
        // the sums are fewer than the terms, and not finite where a term is not
        finite(values.iter(), "the sum of the matrices")?;
        Ok(values.into_pyarray(py))
    }
}

/// Sparse Cholesky factor with some unknowns kept last, and their Schur complement.
#[pyclass(frozen, module = "flangeway._core")]
struct Cholesky {
    inner: cholesky::Cholesky,
}

#[pymethods]
impl Cholesky {
    #[new]
    #[pyo3(signature = (indptr, indices, values, groups, trailing, most_bytes = u64::MAX))]
    fn new(
        py: Python<'_>,
        indptr: &Bound<'_, PyAny>,
        indices: &Bound<'_, PyAny>,
        values: &Bound<'_, PyAny>,
        groups: &Bound<'_, PyAny>,
        trailing: &Bound<'_, PyAny>,
        most_bytes: u64,
    ) -> PyResult<Self> {
        let matrix = Matrix::new(indptr, indices, values, groups)?;
        let trailing = typed::<i32, Ix1>(trailing, "trailing", "int32 of shape (n_trailing,)")?;
        let trailing = contiguous(&trailing, "trailing")?;
        let (lower, values, groups) = matrix.parts()?;
        check_trailing(trailing, lower.n())?;
        let inner =
            py.detach(|| cholesky::Cholesky::new(lower, values, groups, trailing, most_bytes))?;
        Ok(Self { inner })
    }

    #[getter]
    fn n(&self) -> usize {
        self.inner.n()
    }

    #[getter]
    fn n_trailing(&self) -> usize {
        self.inner.n_trailing()
    }

    #[getter]
    fn factor_nonzeros(&self) -> usize {
        self.inner.factor_nonzeros()
    }

    #[getter]
    fn peak_bytes(&self) -> u64 {
        self.inner.peak_bytes()
    }

    fn schur<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        memory::ask(8 * (self.inner.n_trailing() as u64).pow(2), u64::MAX)?;
        Ok(as_array(py, self.inner.schur()))
    }

    fn solve<'py>(&self, py: Python<'py>, rhs: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        ask_for_columns(rhs)?;
        let (rhs, is_column) = dense(rhs, "rhs", self.inner.n())?;
        finite_columns(&rhs, "rhs")?;
        let solution = py.detach(|| self.inner.solve(rhs.as_ref()))?;
        Ok(given_back(py, &solution, is_column))
    }

    fn condense<'py>(
        &self,
        py: Python<'py>,
        rhs: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        ask_for_columns(rhs)?;
        let (rhs, is_column) = dense(rhs, "rhs", self.inner.n())?;
        finite_columns(&rhs, "rhs")?;
        let condensed = py.detach(|| self.inner.condense(rhs.as_ref()));
        Ok(given_back(py, &condensed, is_column))
    }

    fn recover<'py>(
        &self,
        py: Python<'py>,
        trailing_values: &Bound<'py, PyAny>,
        rhs: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyAny>> {
        ask_for_columns(rhs)?;
        let (given, given_is_column) =
            dense(trailing_values, "trailing_values", self.inner.n_trailing())?;
        let (mut rhs, is_column) = dense(rhs, "rhs", self.inner.n())?;
        if given_is_column != is_column || given.ncols() != rhs.ncols() {
            return Err(PyValueError::new_err(
                "trailing_values and rhs must both be vectors or have equally many columns",
            ));
        }
        for j in 0..rhs.ncols() {
            for &unknown in self.inner.trailing() {
                rhs[(unknown as usize, j)] = 0.0;
            }
        }
        finite_columns(&given, "trailing_values")?;
        finite_columns(&rhs, "rhs")?;
        let solution = py.detach(|| self.inner.recover(given.as_ref(), rhs.as_ref()));
        Ok(given_back(py, &solution, is_column))
    }
}

/// Sparse factor of a symmetric indefinite matrix, such as a tangent with multipliers.
#[pyclass(frozen, module = "flangeway._core")]
struct Ldlt {
    inner: ldlt::Ldlt,
}

#[pymethods]
impl Ldlt {
    #[new]
    #[pyo3(signature = (indptr, indices, values, groups, most_bytes = u64::MAX))]
    fn new(
        py: Python<'_>,
        indptr: &Bound<'_, PyAny>,
        indices: &Bound<'_, PyAny>,
        values: &Bound<'_, PyAny>,
        groups: &Bound<'_, PyAny>,
        most_bytes: u64,
    ) -> PyResult<Self> {
        let matrix = Matrix::new(indptr, indices, values, groups)?;
        let (lower, values, groups) = matrix.parts()?;
        let inner = py.detach(|| ldlt::Ldlt::new(lower, values, groups, most_bytes))?;
        Ok(Self { inner })
    }

    #[getter]
    fn n(&self) -> usize {
        self.inner.n()
    }

    fn solve<'py>(&self, py: Python<'py>, rhs: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        ask_for_columns(rhs)?;
        let (rhs, is_column) = dense(rhs, "rhs", self.inner.n())?;
        finite_columns(&rhs, "rhs")?;
        let solution = py.detach(|| self.inner.solve(rhs.as_ref()))?;
        Ok(given_back(py, &solution, is_column))
    }
}

#[pymodule]
mod _core {
    #[pymodule_export]
    use super::{
        Cholesky, FactorTooLargeError, Ldlt, NotPositiveDefiniteError, Pattern,
        SingularMatrixError, n_threads,
    };
}
