//! Fill-reducing orderings: minimum degree, elimination tree, postorder.

use crate::error::FactorError;
use crate::nodal_graph::{NodalGraph, summed};
use faer::dyn_stack::MemStack;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

/// Marks an unknown or a node that takes no part.
pub const NONE: u32 = u32::MAX;

/// Lower triangle of a symmetric pattern in compressed columns: rows sorted, diagonal first.
#[derive(Clone, Copy, Debug)]
pub struct Lower<'a> {
    pub indptr: &'a [i64],
    pub indices: &'a [i32],
}

impl<'a> Lower<'a> {
    /// Checks the structure once, so that the rest of the crate may rely on it.
    pub fn new(indptr: &'a [i64], indices: &'a [i32]) -> Result<Self, String> {
        if indptr.len() < 2 {
            return Err("indptr must have n + 1 entries with n >= 1".to_string());
        }
        let n = indptr.len() - 1;
        if n >= i32::MAX as usize || indices.len() >= i32::MAX as usize {
            return Err(format!(
                "at most 2^31 - 2 unknowns and entries, got {n} and {}",
                indices.len()
            ));
        }
        if indptr[0] != 0 || indptr[n] != indices.len() as i64 {
            return Err(format!(
                "indptr must begin with 0 and end with len(indices) = {}, got {} and {}",
                indices.len(),
                indptr[0],
                indptr[n]
            ));
        }
        if let Some(j) = (0..n).find(|&j| indptr[j] >= indptr[j + 1]) {
            return Err(format!(
                "column {j} must hold its diagonal: indptr must increase strictly"
            ));
        }
        for j in 0..n {
            let column = &indices[indptr[j] as usize..indptr[j + 1] as usize];
            if column[0] != j as i32 {
                return Err(format!(
                    "column {j} must begin with its diagonal, got row {}",
                    column[0]
                ));
            }
            if column.windows(2).any(|pair| pair[0] >= pair[1]) {
                return Err(format!("the rows of column {j} must increase strictly"));
            }
            if column[column.len() - 1] >= n as i32 {
                return Err(format!("column {j} has a row outside of 0..{n}"));
            }
        }
        Ok(Self { indptr, indices })
    }

    /// Number of unknowns.
    pub fn n(&self) -> usize {
        self.indptr.len() - 1
    }

    /// Position in `indices` of the first entry of column `j`, its diagonal.
    pub fn start(&self, j: usize) -> usize {
        self.indptr[j] as usize
    }

    /// Positions in `indices` of column `j`.
    pub fn range(&self, j: usize) -> std::ops::Range<usize> {
        self.start(j)..self.start(j + 1)
    }
}

/// Which triangle of a permuted symmetric matrix to build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Triangle {
    Lower,
    Upper,
}

/// One triangle of a permuted matrix in compressed columns, rows unsorted.
#[derive(Debug)]
pub struct Permuted {
    pub col_ptr: Vec<u32>,
    pub row_idx: Vec<u32>,
    /// Position of each entry in the matrix as given.
    pub source: Vec<u32>,
}

/// Permutes symmetrically and keeps one triangle; unknowns whose new number is `NONE` are dropped.
///
/// `inverse[old]` is the new number; the new numbers are `0..n_kept`.
pub fn permuted(lower: Lower, inverse: &[u32], n_kept: usize, triangle: Triangle) -> Permuted {
    let target = |i: i32, j: usize| {
        let (a, b) = (inverse[i as usize], inverse[j]);
        let (small, large) = if a < b { (a, b) } else { (b, a) };
        match triangle {
            _ if large == NONE => None,
            Triangle::Lower => Some((large, small)),
            Triangle::Upper => Some((small, large)),
        }
    };
    let mut col_ptr = vec![0u32; n_kept + 1];
    for j in 0..lower.n() {
        for &i in &lower.indices[lower.range(j)] {
            if let Some((_, column)) = target(i, j) {
                col_ptr[column as usize + 1] += 1;
            }
        }
    }
    for j in 0..n_kept {
        col_ptr[j + 1] += col_ptr[j];
    }
    let n_entries = col_ptr[n_kept] as usize;
    let (mut row_idx, mut source) = (vec![0u32; n_entries], vec![0u32; n_entries]);
    let mut next = col_ptr.clone();
    for j in 0..lower.n() {
        for position in lower.range(j) {
            if let Some((row, column)) = target(lower.indices[position], j) {
                let slot = &mut next[column as usize];
                row_idx[*slot as usize] = row;
                source[*slot as usize] = position as u32;
                *slot += 1;
            }
        }
    }
    Permuted {
        col_ptr,
        row_idx,
        source,
    }
}

/// Inverse of a partial permutation of `0..n`: `NONE` where `forward` does not lead.
pub fn inverted(forward: &[u32], n: usize) -> Vec<u32> {
    let mut inverse = vec![NONE; n];
    for (new, &old) in forward.iter().enumerate() {
        inverse[old as usize] = new as u32;
    }
    inverse
}

/// Orders the kept unknowns by approximate minimum degree (Amestoy, Davis and Duff, 1996) on the
/// graph of those nodes that follow no other one. Returns the old number of each new one.
pub fn minimum_degree(
    lower: Lower,
    groups: &[i32],
    kept: &[bool],
) -> Result<Vec<u32>, FactorError> {
    let mut graph = NodalGraph::new(lower, groups, kept);
    let n_nodes = graph.n();
    let first = graph.merge_alike();
    let followers = graph.followers();
    let mut leads: Vec<bool> = (0..n_nodes as u32)
        .map(|a| first[a as usize] == a)
        .collect();
    for &(follower, _) in &followers {
        leads[follower as usize] = false;
    }
    let leaders: Vec<u32> = (0..n_nodes as u32).filter(|&a| leads[a as usize]).collect();
    // a follower comes just before the first of the leaders that it could follow
    let mut place = vec![NONE; n_nodes];
    for (position, &a) in by_degree(&mut graph, &leaders)?.iter().enumerate() {
        place[a as usize] = 2 * position as u32 + 1;
    }
    for &(follower, a) in followers.iter().filter(|(_, a)| leads[*a as usize]) {
        place[follower as usize] = place[follower as usize].min(place[a as usize] - 1);
    }
    let mut starts = vec![0u32; 2 * leaders.len() + 1];
    let place_of = |a: usize| place[first[a] as usize] as usize;
    (0..n_nodes).for_each(|a| starts[place_of(a) + 1] += 1);
    summed(&mut starts);
    let mut order = vec![0u32; n_nodes];
    for a in 0..n_nodes {
        let start = &mut starts[place_of(a)];
        order[*start as usize] = a as u32;
        *start += 1;
    }
    Ok(order
        .iter()
        .flat_map(|&a| graph.members(a).iter().copied())
        .collect())
}

/// Some nodes of a graph, which loses its neighbours, by approximate minimum degree.
fn by_degree(graph: &mut NodalGraph, nodes: &[u32]) -> Result<Vec<u32>, FactorError> {
    if nodes.is_empty() {
        return Ok(Vec::new());
    }
    let number = inverted(nodes, graph.n());
    let (mut col_ptr, mut row_idx) = (vec![0u32], Vec::new());
    for (a, &node) in nodes.iter().enumerate() {
        let others = graph.of(node).iter().map(|&b| number[b as usize]);
        row_idx.extend(others.filter(|&b| b != NONE && b as usize > a));
        col_ptr.push(row_idx.len() as u32);
    }
    graph.neighbours = Vec::new(); // memory for the ordering
    let n = nodes.len();
    let symbolic = SymbolicSparseColMatRef::new_unsorted_checked(n, n, &col_ptr, None, &row_idx);
    let scratch = amd::order_maybe_unsorted_scratch::<u32>(n, row_idx.len());
    let mut buffer = crate::memory::scratch(scratch)?;
    let (mut forward, mut inverse) = (vec![0u32; n], vec![0u32; n]);
    amd::order_maybe_unsorted(
        &mut forward,
        &mut inverse,
        symbolic,
        amd::Control::default(),
        MemStack::new(&mut buffer),
    )?;
    Ok(forward.iter().map(|&a| nodes[a as usize]).collect())
}

/// Parent of each column in the elimination tree (Liu, 1990), `NONE` at a root; needs the upper triangle.
pub fn elimination_tree(upper: &Permuted) -> Vec<u32> {
    let n = upper.col_ptr.len() - 1;
    let (mut parent, mut ancestor) = (vec![NONE; n], vec![NONE; n]);
    for j in 0..n {
        for &row in &upper.row_idx[upper.col_ptr[j] as usize..upper.col_ptr[j + 1] as usize] {
            let mut i = row;
            while i != NONE && (i as usize) < j {
                let above = ancestor[i as usize];
                ancestor[i as usize] = j as u32;
                if above == NONE {
                    parent[i as usize] = j as u32;
                }
                i = above;
            }
        }
    }
    parent
}

/// Postorder of a forest in which a parent's number exceeds its children's.
pub fn postorder(parent: &[u32]) -> Vec<u32> {
    let n = parent.len();
    let (mut first_child, mut sibling) = (vec![NONE; n], vec![NONE; n]);
    for i in (0..n).rev() {
        if parent[i] != NONE {
            sibling[i] = first_child[parent[i] as usize];
            first_child[parent[i] as usize] = i as u32;
        }
    }
    let (mut order, mut stack) = (Vec::with_capacity(n), Vec::new());
    for root in (0..n).filter(|&i| parent[i] == NONE) {
        stack.push(root as u32);
        while let Some(&top) = stack.last() {
            let child = first_child[top as usize];
            if child == NONE {
                order.push(top);
                stack.pop();
            } else {
                first_child[top as usize] = sibling[child as usize];
                stack.push(child);
            }
        }
    }
    order
}

/// Renumbers an ordering by the postorder of its elimination tree: same fill, contiguous subtrees.
pub fn postordered(lower: Lower, forward: &[u32]) -> Vec<u32> {
    let inverse = inverted(forward, lower.n());
    let upper = permuted(lower, &inverse, forward.len(), Triangle::Upper);
    postorder(&elimination_tree(&upper))
        .iter()
        .map(|&new| forward[new as usize])
        .collect()
}

/// Moves each unknown with a zero diagonal behind all its neighbours, whose elimination then
/// gives it a pivot.
pub fn zero_diagonals_last(lower: Lower, is_zero: &[bool], forward: &[u32]) -> Vec<u32> {
    let position = inverted(forward, lower.n());
    let mut key: Vec<u32> = position.clone();
    for j in 0..lower.n() {
        for &i in &lower.indices[lower.range(j)] {
            let i = i as usize;
            if is_zero[i] && !is_zero[j] {
                key[i] = key[i].max(position[j]);
            } else if is_zero[j] && !is_zero[i] {
                key[j] = key[j].max(position[i]);
            }
        }
    }
    let mut order = forward.to_vec();
    order.sort_by_key(|&i| (key[i as usize], is_zero[i as usize], position[i as usize]));
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lower triangle of a path graph on `n` unknowns.
    fn path(n: usize) -> (Vec<i64>, Vec<i32>) {
        let (mut indptr, mut indices) = (vec![0], Vec::new());
        for j in 0..n {
            indices.push(j as i32);
            if j + 1 < n {
                indices.push(j as i32 + 1);
            }
            indptr.push(indices.len() as i64);
        }
        (indptr, indices)
    }

    fn is_permutation(order: &[u32], n: usize) -> bool {
        let mut sorted = order.to_vec();
        sorted.sort_unstable();
        sorted == (0..n as u32).collect::<Vec<_>>()
    }

    #[test]
    fn structure_is_checked() {
        assert!(Lower::new(&[0, 2, 3], &[0, 1, 1]).is_ok());
        assert!(Lower::new(&[0], &[]).is_err());
        assert!(Lower::new(&[0, 1, 1], &[0]).is_err());
        assert!(Lower::new(&[0, 1, 2], &[1, 1]).is_err());
        assert!(Lower::new(&[0, 2, 3], &[0, 2, 1]).is_err());
        assert!(Lower::new(&[0, 3, 4], &[0, 1, 1, 1]).is_err());
        assert!(Lower::new(&[0, 2, 4], &[0, 1, 1]).is_err());
    }

    #[test]
    fn tree_of_a_path_is_a_chain() {
        let (indptr, indices) = path(4);
        let lower = Lower::new(&indptr, &indices).unwrap();
        let upper = permuted(lower, &[0, 1, 2, 3], 4, Triangle::Upper);
        assert_eq!(elimination_tree(&upper), [1, 2, 3, NONE]);
    }

    #[test]
    fn tree_of_an_arrow_joins_at_its_tip() {
        // unknowns 0, 1, 2 meet only unknown 3
        let lower = Lower::new(&[0, 2, 4, 6, 7], &[0, 3, 1, 3, 2, 3, 3]).unwrap();
        let upper = permuted(lower, &[0, 1, 2, 3], 4, Triangle::Upper);
        assert_eq!(elimination_tree(&upper), [3, 3, 3, NONE]);
        assert_eq!(postorder(&[3, 3, 3, NONE]), [0, 1, 2, 3]);
    }

    #[test]
    fn postorder_makes_subtrees_contiguous() {
        // 0 and 3 belong to 4, 1 to 2, 2 and 4 to 5
        assert_eq!(postorder(&[4, 2, 5, 4, 5, NONE]), [1, 2, 0, 3, 4, 5]);
    }

    #[test]
    fn permuted_triangles_are_transposed_and_point_to_their_source() {
        let (indptr, indices) = path(4);
        let lower = Lower::new(&indptr, &indices).unwrap();
        let inverse = [2, NONE, 0, 1];
        let low = permuted(lower, &inverse, 3, Triangle::Lower);
        let up = permuted(lower, &inverse, 3, Triangle::Upper);
        assert_eq!(low.col_ptr, [0, 2, 3, 4]);
        assert_eq!(low.row_idx, [0, 1, 1, 2]);
        assert_eq!(low.source, [4, 5, 6, 0]);
        assert_eq!(up.col_ptr, [0, 1, 3, 4]);
    }

    #[test]
    fn nodes_stay_together_and_dropped_unknowns_are_absent() {
        let (indptr, indices) = path(7);
        let lower = Lower::new(&indptr, &indices).unwrap();
        let groups = [9, 9, 4, 4, 7, 7, 5];
        let kept = [true, true, true, true, true, true, false];
        let order = minimum_degree(lower, &groups, &kept).unwrap();
        assert!(is_permutation(&order, 6));
        for pair in order.chunks(2) {
            assert_eq!(groups[pair[0] as usize], groups[pair[1] as usize]);
            assert!(pair[0] < pair[1]);
        }
    }

    #[test]
    fn minimum_degree_takes_the_tip_of_a_star_late() {
        // the hub is unknown 0; eliminating it first would fill the matrix
        let (mut indptr, mut indices) = (vec![0], (0..9).collect::<Vec<i32>>());
        indptr.push(9);
        for j in 1..9 {
            indices.push(j);
            indptr.push(indices.len() as i64);
        }
        let lower = Lower::new(&indptr, &indices).unwrap();
        let groups: Vec<i32> = (0..9).collect();
        let order = minimum_degree(lower, &groups, &[true; 9]).unwrap();
        assert!(is_permutation(&order, 9));
        assert!(order[7..].contains(&0));
        assert!(is_permutation(&postordered(lower, &order), 9));
    }

    #[test]
    fn zero_diagonals_follow_their_neighbours() {
        let (indptr, indices) = path(5);
        let lower = Lower::new(&indptr, &indices).unwrap();
        let order =
            zero_diagonals_last(lower, &[false, false, true, false, false], &[2, 0, 1, 3, 4]);
        assert_eq!(order, [0, 1, 3, 2, 4]);
    }
}
