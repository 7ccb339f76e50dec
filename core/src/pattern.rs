//! The sparsity pattern of ragged cells, found once, and the scatter of their matrices, done often.
//!
//! Both work by column: the cells that touch unknown `j` are known, so column `j` is gathered from
//! them by one thread alone. Nothing races, and the sum runs in the same order for any number of
//! threads.

use rayon::prelude::*;

/// Parts into which the columns are cut for the threads.
const N_PARTS: usize = 32;
const UNSEEN: u32 = u32::MAX;

/// Cells with the same number of unknowns: `dofs[local * n_cells + cell]`, negative where eliminated.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    pub n_local: usize,
    pub n_cells: usize,
    pub dofs: &'a [i32],
}

/// One unknown of one cell.
#[derive(Clone, Copy, Debug)]
struct Touch {
    cell: u32,
    batch: u16,
    local: u16,
}

/// Unknowns of a batch with those of one cell side by side.
#[derive(Debug)]
struct CellDofs {
    n_local: usize,
    n_cells: usize,
    dofs: Vec<i32>,
}

impl CellDofs {
    fn of(&self, cell: u32) -> &[i32] {
        &self.dofs[cell as usize * self.n_local..][..self.n_local]
    }
}

/// Lower triangle of the assembled pattern, and what is needed to fill it.
#[derive(Debug)]
pub struct Pattern {
    indptr: Vec<i64>,
    indices: Vec<i32>,
    batches: Vec<CellDofs>,
    touch_ptr: Vec<usize>,
    touches: Vec<Touch>,
}

impl Pattern {
    /// Finds the pattern; the diagonal is part of it even where no cell touches an unknown.
    pub fn new(n_dofs: usize, batches: &[Batch]) -> Result<Self, String> {
        check(n_dofs, batches)?;
        let batches: Vec<CellDofs> = batches.iter().map(by_cell).collect();
        let (touch_ptr, touches) = touches_of(n_dofs, &batches);
        let columns: Vec<(Vec<i64>, Vec<i32>)> = parts(n_dofs)
            .into_par_iter()
            .map(|part| columns_of(part, n_dofs, &batches, &touch_ptr, &touches))
            .collect();
        let mut indptr = Vec::with_capacity(n_dofs + 1);
        indptr.push(0);
        let mut end = 0;
        for (lengths, _) in &columns {
            for length in lengths {
                end += length;
                indptr.push(end);
            }
        }
        let mut indices = Vec::with_capacity(end as usize);
        for (_, rows) in columns {
            indices.extend_from_slice(&rows);
        }
        Ok(Self {
            indptr,
            indices,
            batches,
            touch_ptr,
            touches,
        })
    }

    pub fn n_dofs(&self) -> usize {
        self.indptr.len() - 1
    }

    pub fn indptr(&self) -> &[i64] {
        &self.indptr
    }

    pub fn indices(&self) -> &[i32] {
        &self.indices
    }

    /// Number of unknowns of a cell and number of cells, for each batch.
    pub fn shapes(&self) -> Vec<(usize, usize)> {
        self.batches
            .iter()
            .map(|batch| (batch.n_local, batch.n_cells))
            .collect()
    }

    /// Values of the lower triangle: the sum over cells of `matrices[batch][(row * n_local + column) * n_cells + cell]`.
    pub fn scatter(&self, matrices: &[&[f64]]) -> Vec<f64> {
        assert!(matrices.len() == self.batches.len());
        for (batch, matrix) in self.batches.iter().zip(matrices) {
            assert!(matrix.len() == batch.n_local * batch.n_local * batch.n_cells);
        }
        let mut values = vec![0.0; self.indices.len()];
        let mut rest = values.as_mut_slice();
        let mut tasks = Vec::new();
        for part in parts(self.n_dofs()) {
            let length = (self.indptr[part.end] - self.indptr[part.start]) as usize;
            let (head, tail) = rest.split_at_mut(length);
            tasks.push((part, head));
            rest = tail;
        }
        tasks
            .into_par_iter()
            .for_each(|(part, out)| self.gather(part, matrices, out));
        values
    }

    /// Sums the columns of one part into `out`.
    fn gather(&self, part: std::ops::Range<usize>, matrices: &[&[f64]], out: &mut [f64]) {
        let offset = self.indptr[part.start] as usize;
        let mut place = vec![0u32; self.n_dofs()];
        for j in part {
            let (start, end) = (self.indptr[j] as usize, self.indptr[j + 1] as usize);
            for (k, &row) in self.indices[start..end].iter().enumerate() {
                place[row as usize] = k as u32;
            }
            let column = &mut out[start - offset..end - offset];
            for touch in &self.touches[self.touch_ptr[j]..self.touch_ptr[j + 1]] {
                let batch = &self.batches[touch.batch as usize];
                let matrix = matrices[touch.batch as usize];
                let first = touch.local as usize * batch.n_cells + touch.cell as usize;
                let stride = batch.n_local * batch.n_cells;
                for (k, &row) in batch.of(touch.cell).iter().enumerate() {
                    if row >= j as i32 {
                        column[place[row as usize] as usize] += matrix[k * stride + first];
                    }
                }
            }
        }
    }
}

fn check(n_dofs: usize, batches: &[Batch]) -> Result<(), String> {
    if n_dofs == 0 || n_dofs >= i32::MAX as usize {
        return Err(format!("n_dofs must be in 1..2^31 - 1, got {n_dofs}"));
    }
    if batches.len() > u16::MAX as usize {
        return Err(format!("at most 65535 batches, got {}", batches.len()));
    }
    for (b, batch) in batches.iter().enumerate() {
        if batch.n_local > u16::MAX as usize || batch.n_cells >= u32::MAX as usize {
            return Err(format!(
                "batch {b}: at most 65535 unknowns a cell and 2^32 - 2 cells, got {} and {}",
                batch.n_local, batch.n_cells
            ));
        }
        assert!(batch.dofs.len() == batch.n_local * batch.n_cells);
        if let Some(k) = batch.dofs.iter().position(|&dof| dof >= n_dofs as i32) {
            return Err(format!(
                "batch {b}, cell {}: unknown {} is outside of 0..{n_dofs}",
                k % batch.n_cells,
                batch.dofs[k]
            ));
        }
    }
    Ok(())
}

fn by_cell(batch: &Batch) -> CellDofs {
    let mut dofs = vec![0; batch.dofs.len()];
    for (local, row) in batch.dofs.chunks_exact(batch.n_cells.max(1)).enumerate() {
        for (cell, &dof) in row.iter().enumerate() {
            dofs[cell * batch.n_local + local] = dof;
        }
    }
    CellDofs {
        n_local: batch.n_local,
        n_cells: batch.n_cells,
        dofs,
    }
}

/// For each unknown the cells that touch it, in the order of batches and cells.
fn touches_of(n_dofs: usize, batches: &[CellDofs]) -> (Vec<usize>, Vec<Touch>) {
    let mut touch_ptr = vec![0usize; n_dofs + 1];
    for batch in batches {
        for &dof in batch.dofs.iter().filter(|&&dof| dof >= 0) {
            touch_ptr[dof as usize + 1] += 1;
        }
    }
    for j in 0..n_dofs {
        touch_ptr[j + 1] += touch_ptr[j];
    }
    let nowhere = Touch {
        cell: 0,
        batch: 0,
        local: 0,
    };
    let mut touches = vec![nowhere; touch_ptr[n_dofs]];
    let mut next = touch_ptr.clone();
    for (b, batch) in batches.iter().enumerate() {
        for cell in 0..batch.n_cells as u32 {
            for (local, &dof) in batch.of(cell).iter().enumerate().filter(|(_, d)| **d >= 0) {
                touches[next[dof as usize]] = Touch {
                    cell,
                    batch: b as u16,
                    local: local as u16,
                };
                next[dof as usize] += 1;
            }
        }
    }
    (touch_ptr, touches)
}

/// Lengths and sorted rows of the columns of one part.
fn columns_of(
    part: std::ops::Range<usize>,
    n_dofs: usize,
    batches: &[CellDofs],
    touch_ptr: &[usize],
    touches: &[Touch],
) -> (Vec<i64>, Vec<i32>) {
    let (mut lengths, mut rows) = (Vec::with_capacity(part.len()), Vec::new());
    let mut seen_by = vec![UNSEEN; n_dofs];
    for j in part {
        let start = rows.len();
        rows.push(j as i32);
        seen_by[j] = j as u32;
        for touch in &touches[touch_ptr[j]..touch_ptr[j + 1]] {
            for &row in batches[touch.batch as usize].of(touch.cell) {
                if row > j as i32 && seen_by[row as usize] != j as u32 {
                    seen_by[row as usize] = j as u32;
                    rows.push(row);
                }
            }
        }
        rows[start..].sort_unstable();
        lengths.push((rows.len() - start) as i64);
    }
    (lengths, rows)
}

fn parts(n_dofs: usize) -> Vec<std::ops::Range<usize>> {
    // small problems stay in one part: every part has a work array of its own
    let size = n_dofs.div_ceil(N_PARTS).max(4096);
    (0..n_dofs)
        .step_by(size)
        .map(|start| start..(start + size).min(n_dofs))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_bars_share_an_unknown() {
        let dofs = [0, 1, 1, 2];
        let batch = Batch {
            n_local: 2,
            n_cells: 2,
            dofs: &dofs,
        };
        let pattern = Pattern::new(3, &[batch]).unwrap();
        assert_eq!(pattern.indptr(), [0, 2, 4, 5]);
        assert_eq!(pattern.indices(), [0, 1, 1, 2, 2]);
        // stiffness 1 and 10, cell index last
        let matrix = [1.0, 10.0, -1.0, -10.0, -1.0, -10.0, 1.0, 10.0];
        assert_eq!(pattern.scatter(&[&matrix]), [1.0, -1.0, 11.0, -10.0, 10.0]);
    }

    #[test]
    fn eliminated_unknowns_are_skipped_and_untouched_diagonals_kept() {
        let dofs = [2, -1];
        let batch = Batch {
            n_local: 2,
            n_cells: 1,
            dofs: &dofs,
        };
        let pattern = Pattern::new(3, &[batch]).unwrap();
        assert_eq!(pattern.indices(), [0, 1, 2]);
        assert_eq!(pattern.scatter(&[&[5.0, 7.0, 7.0, 9.0]]), [0.0, 0.0, 5.0]);
    }

    #[test]
    fn only_the_lower_triangle_is_read() {
        let dofs = [1, 0];
        let batch = Batch {
            n_local: 2,
            n_cells: 1,
            dofs: &dofs,
        };
        let pattern = Pattern::new(2, &[batch]).unwrap();
        // row 1, column 0 is the local entry (0, 1)
        assert_eq!(
            pattern.scatter(&[&[1.0, 2.0, f64::NAN, 4.0]]),
            [4.0, 2.0, 1.0]
        );
    }

    #[test]
    fn the_number_of_threads_does_not_matter() {
        let n_cells = 20_000;
        let dofs: Vec<i32> = (0..3 * n_cells)
            .map(|k| ((k as i64 * 7919 + 13) % 9_973) as i32 - 1)
            .collect();
        let matrix: Vec<f64> = (0..9 * n_cells).map(|k| (k as f64).sin()).collect();
        let batch = Batch {
            n_local: 3,
            n_cells,
            dofs: &dofs,
        };
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let pattern = Pattern::new(9_973, &[batch]).unwrap();
                (pattern.indices().to_vec(), pattern.scatter(&[&matrix]))
            })
        };
        assert!(run(1) == run(4));
    }

    #[test]
    fn unknowns_out_of_range_are_refused() {
        let batch = Batch {
            n_local: 1,
            n_cells: 2,
            dofs: &[0, 5],
        };
        let message = Pattern::new(3, &[batch]).unwrap_err();
        assert!(message.contains("cell 1") && message.contains("unknown 5"));
        assert!(Pattern::new(0, &[]).is_err());
    }
}
