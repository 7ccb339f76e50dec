//! The sparsity pattern of ragged cells, found once, and the scatter of their matrices, done often.
//!
//! Both work by column: the cells that touch unknown `j` are known, so column `j` is gathered from
//! them by one thread alone. Nothing races, and the sum runs in the same order for any number of
//! threads. Before that each cell's matrix, which lies far apart in memory with the cells' number
//! last, is packed: its lower triangle by columns, its unknowns in ascending order.

use rayon::prelude::*;

/// Parts into which the columns are cut for the threads.
const N_PARTS: usize = 32;
const UNSEEN: u32 = u32::MAX;
/// Cells whose matrices one task packs: a cache line holds the entries of eight.
const CELLS_A_BLOCK: usize = 64;
/// Up to so many ascending runs are merged one by one; more are sorted together.
const MOST_RUNS: usize = 16;

/// Cells with the same number of unknowns: `dofs[local * n_cells + cell]`, negative where eliminated.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    pub n_local: usize,
    pub n_cells: usize,
    pub dofs: &'a [i32],
}

/// One unknown of one cell; `rank` counts the cell's unknowns in ascending order.
#[derive(Clone, Copy, Debug)]
struct Touch {
    cell: u32,
    batch: u16,
    rank: u16,
}

/// Unknowns of a batch with those of one cell side by side in ascending order.
#[derive(Debug)]
struct CellDofs {
    n_local: usize,
    n_cells: usize,
    dofs: Vec<i32>,
    /// Place of each of them in the cell as given.
    local: Vec<u16>,
}

impl CellDofs {
    fn of(&self, cell: usize) -> &[i32] {
        &self.dofs[cell * self.n_local..][..self.n_local]
    }

    /// Entries of a packed matrix.
    fn n_packed(&self) -> usize {
        self.n_local * (self.n_local + 1) / 2
    }

    /// Where the column of a rank begins in a packed matrix, with its diagonal.
    fn column(&self, rank: usize) -> usize {
        rank * (2 * self.n_local + 1 - rank) / 2
    }

    /// Packs the matrices of cells from `first` on.
    fn pack(&self, first: usize, matrix: &[f64], packed: &mut [f64]) {
        let n = self.n_local;
        for (k, packed) in packed.chunks_exact_mut(self.n_packed()).enumerate() {
            let cell = first + k;
            let (dofs, local) = (self.of(cell), &self.local[cell * n..][..n]);
            let entry = |row: usize, column: usize| {
                matrix[(local[row] as usize * n + local[column] as usize) * self.n_cells + cell]
            };
            let used = dofs.partition_point(|&dof| dof < 0);
            for column in used..n {
                let start = self.column(column);
                for row in column..n {
                    packed[start + row - column] = entry(row, column);
                    if row > column && dofs[row] == dofs[column] {
                        packed[start + row - column] += entry(column, row);
                    }
                }
            }
        }
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
        let batches: Vec<CellDofs> = batches.par_iter().map(by_cell).collect();
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
        let packed: Vec<Vec<f64>> = self
            .batches
            .iter()
            .zip(matrices)
            .map(|(batch, matrix)| packed(batch, matrix))
            .collect();
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
            .for_each(|(part, out)| self.gather(part, &packed, out));
        values
    }

    /// Bytes that a scatter takes: the packed matrices, the values and the work arrays of threads.
    pub fn scatter_bytes(&self) -> u64 {
        let of_batch = |batch: &CellDofs| (batch.n_packed() * batch.n_cells) as u64;
        let n_packed: u64 = self.batches.iter().map(of_batch).sum();
        8 * (n_packed + self.indices.len() as u64) + work_bytes(self.n_dofs())
    }

    /// Sums the columns of one part into `out`.
    fn gather(&self, part: std::ops::Range<usize>, packed: &[Vec<f64>], out: &mut [f64]) {
        let offset = self.indptr[part.start] as usize;
        let mut place = vec![0u32; self.n_dofs()];
        for j in part {
            let (start, end) = (self.indptr[j] as usize, self.indptr[j + 1] as usize);
            for (k, &row) in self.indices[start..end].iter().enumerate() {
                place[row as usize] = k as u32;
            }
            let column = &mut out[start - offset..end - offset];
            for touch in &self.touches[self.touch_ptr[j]..self.touch_ptr[j + 1]] {
                let (batch, rank) = (&self.batches[touch.batch as usize], touch.rank as usize);
                let first = touch.cell as usize * batch.n_packed() + batch.column(rank);
                let rows = &batch.of(touch.cell as usize)[rank..];
                let entries = &packed[touch.batch as usize][first..first + rows.len()];
                for (&row, entry) in rows.iter().zip(entries) {
                    column[place[row as usize] as usize] += entry;
                }
            }
        }
    }
}

/// The matrices of a batch, cell by cell.
fn packed(batch: &CellDofs, matrix: &[f64]) -> Vec<f64> {
    let n_packed = batch.n_packed();
    let mut packed = vec![0.0; n_packed * batch.n_cells];
    packed
        .par_chunks_mut((n_packed * CELLS_A_BLOCK).max(1))
        .enumerate()
        .for_each(|(k, part)| batch.pack(k * CELLS_A_BLOCK, matrix, part));
    packed
}

/// Most bytes that finding a pattern takes, where no two cells share an entry.
pub fn pattern_bytes(n_dofs: usize, batches: &[Batch]) -> u64 {
    let of_batch = |batch: &Batch| {
        let (n_local, n_cells) = (batch.n_local as u64, batch.n_cells as u64);
        // unknowns twice and touches; rows by parts and together
        n_cells * (14 * n_local + 4 * n_local * (n_local + 1))
    };
    32 * n_dofs as u64 + work_bytes(n_dofs) + batches.iter().map(of_batch).sum::<u64>()
}

/// Bytes of the work arrays, one for each part that a thread has at hand.
fn work_bytes(n_dofs: usize) -> u64 {
    4 * (n_dofs as u64) * rayon::current_num_threads() as u64
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
    let (n_local, n_cells) = (batch.n_local, batch.n_cells);
    let (mut dofs, mut local) = (vec![0; batch.dofs.len()], vec![0; batch.dofs.len()]);
    let mut pairs = Vec::with_capacity(n_local);
    for cell in 0..n_cells {
        pairs.clear();
        pairs.extend((0..n_local).map(|k| (batch.dofs[k * n_cells + cell], k as u16)));
        pairs.sort_unstable();
        for (rank, &(dof, k)) in pairs.iter().enumerate() {
            dofs[cell * n_local + rank] = dof;
            local[cell * n_local + rank] = k;
        }
    }
    CellDofs {
        n_local,
        n_cells,
        dofs,
        local,
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
        rank: 0,
    };
    let mut touches = vec![nowhere; touch_ptr[n_dofs]];
    let mut next = touch_ptr.clone();
    for (b, batch) in batches.iter().enumerate() {
        for cell in 0..batch.n_cells {
            for (rank, &dof) in batch.of(cell).iter().enumerate().filter(|(_, d)| **d >= 0) {
                touches[next[dof as usize]] = Touch {
                    cell: cell as u32,
                    batch: b as u16,
                    rank: rank as u16,
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
    let (mut seen_by, mut run) = (vec![UNSEEN; n_dofs], Vec::new());
    for j in part {
        let start = rows.len();
        rows.push(j as i32);
        seen_by[j] = j as u32;
        let touching = &touches[touch_ptr[j]..touch_ptr[j + 1]];
        for touch in touching {
            let new = rows.len();
            let cell = batches[touch.batch as usize].of(touch.cell as usize);
            for &row in &cell[touch.rank as usize + 1..] {
                if seen_by[row as usize] != j as u32 {
                    seen_by[row as usize] = j as u32;
                    rows.push(row);
                }
            }
            if touching.len() <= MOST_RUNS {
                merge(&mut rows[start..], new - start, &mut run);
            }
        }
        if touching.len() > MOST_RUNS {
            rows[start..].sort_unstable();
        }
        lengths.push((rows.len() - start) as i64);
    }
    (lengths, rows)
}

/// Merges the ascending `rows[..middle]` and `rows[middle..]`; `run` is space to work in.
fn merge(rows: &mut [i32], middle: usize, run: &mut Vec<i32>) {
    if middle == rows.len() || rows[middle - 1] < rows[middle] {
        return;
    }
    run.clear();
    run.extend_from_slice(&rows[middle..]);
    let (mut left, mut right) = (middle, run.len());
    while right > 0 {
        if left > 0 && rows[left - 1] > run[right - 1] {
            rows[left + right - 1] = rows[left - 1];
            left -= 1;
        } else {
            rows[left + right - 1] = run[right - 1];
            right -= 1;
        }
    }
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
    fn an_unknown_that_a_cell_names_twice_collects_all_its_entries() {
        let batch = Batch {
            n_local: 3,
            n_cells: 1,
            dofs: &[0, 1, 0],
        };
        let pattern = Pattern::new(2, &[batch]).unwrap();
        let matrix = [1.0, 2.0, 3.0, 2.0, 10.0, 4.0, 3.0, 4.0, 100.0];
        assert_eq!(pattern.indices(), [0, 1, 1]);
        assert_eq!(pattern.scatter(&[&matrix]), [107.0, 6.0, 10.0]);
    }

    #[test]
    fn rows_of_many_cells_ascend() {
        // a fan around unknown 40, its other unknowns out of order
        for n_cells in [3usize, MOST_RUNS, 30] {
            let mut dofs = vec![40i32; n_cells];
            dofs.extend((0..n_cells).map(|c| 41 + (7 * c % 31) as i32));
            dofs.extend((0..n_cells).map(|c| 41 + (7 * (c + 1) % 31) as i32));
            let batch = Batch {
                n_local: 3,
                n_cells,
                dofs: &dofs,
            };
            let pattern = Pattern::new(80, &[batch]).unwrap();
            let indptr = pattern.indptr();
            let rows = &pattern.indices()[indptr[40] as usize..indptr[41] as usize];
            assert!(rows.windows(2).all(|pair| pair[0] < pair[1]));
            assert_eq!(rows.len(), n_cells + 2);
        }
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
