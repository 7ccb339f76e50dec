//! The graph of nodes, and which of them are eliminated with a neighbour.
//!
//! Several unknowns sit at one node (two displacements, say), and their rows have nearly the same
//! pattern. Ordering the graph of nodes instead of the graph of unknowns is several times cheaper
//! and keeps the unknowns of a node together, which makes the supernodes wide.
//!
//! Many nodes need no ordering of their own. Nodes with the same neighbours are one (moments inside
//! a cell, nodes of one edge). A node all of whose neighbours are also those of another one, such
//! as the middle of an edge beside its ends, fills nothing when it is eliminated just before it.

use crate::ordering::{Lower, NONE};

/// Neighbours of each node, each once, without the node itself; and the unknowns of each node.
pub struct NodalGraph {
    pub pointers: Vec<u32>,
    pub neighbours: Vec<u32>,
    member_ptr: Vec<u32>,
    members: Vec<u32>,
}

impl NodalGraph {
    /// Graph of the kept unknowns, whose nodes have the numbers `groups`.
    pub fn new(lower: Lower, groups: &[i32], kept: &[bool]) -> Self {
        let n = lower.n();
        let mut numbers: Vec<i32> = (0..n).filter(|&i| kept[i]).map(|i| groups[i]).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let node: Vec<u32> = (0..n)
            .map(|i| match kept[i] {
                true => numbers
                    .binary_search(&groups[i])
                    .expect("every kept group is listed") as u32,
                false => NONE,
            })
            .collect();
        let n_nodes = numbers.len();
        let mut pointers = vec![0u32; n_nodes + 1];
        each_pair(lower, &node, |a, b| {
            pointers[a as usize + 1] += 1;
            pointers[b as usize + 1] += 1;
        });
        summed(&mut pointers);
        let mut neighbours = vec![0u32; pointers[n_nodes] as usize];
        let mut next = pointers.clone();
        each_pair(lower, &node, |a, b| {
            for (from, to) in [(a, b), (b, a)] {
                neighbours[next[from as usize] as usize] = to;
                next[from as usize] += 1;
            }
        });
        let mut member_ptr = vec![0u32; n_nodes + 1];
        for &a in node.iter().filter(|&&a| a != NONE) {
            member_ptr[a as usize + 1] += 1;
        }
        summed(&mut member_ptr);
        let mut members = vec![0u32; member_ptr[n_nodes] as usize];
        let mut next = member_ptr.clone();
        for (i, &a) in node.iter().enumerate().filter(|(_, a)| **a != NONE) {
            members[next[a as usize] as usize] = i as u32;
            next[a as usize] += 1;
        }
        let mut graph = Self {
            pointers,
            neighbours,
            member_ptr,
            members,
        };
        let mut seen_by = vec![NONE; n_nodes];
        graph.keep(|a, b| std::mem::replace(&mut seen_by[b as usize], a) != a);
        graph
    }

    pub fn n(&self) -> usize {
        self.pointers.len() - 1
    }

    pub fn of(&self, a: u32) -> &[u32] {
        let a = a as usize;
        &self.neighbours[self.pointers[a] as usize..self.pointers[a + 1] as usize]
    }

    pub fn members(&self, a: u32) -> &[u32] {
        let a = a as usize;
        &self.members[self.member_ptr[a] as usize..self.member_ptr[a + 1] as usize]
    }

    /// Drops the neighbours b of a of which `kept(a, b)` is false.
    fn keep(&mut self, mut kept: impl FnMut(u32, u32) -> bool) {
        let mut end = 0;
        for a in 0..self.n() {
            let range = self.pointers[a] as usize..self.pointers[a + 1] as usize;
            self.pointers[a] = end as u32;
            for position in range {
                let b = self.neighbours[position];
                if kept(a as u32, b) {
                    self.neighbours[end] = b;
                    end += 1;
                }
            }
        }
        let n = self.n();
        self.pointers[n] = end as u32;
        self.neighbours.truncate(end);
    }

    /// First of the nodes with the same neighbours as each node, which are left without its followers.
    pub fn merge_alike(&mut self) -> Vec<u32> {
        let mixed = |a: u32| (u64::from(a) + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let sums: Vec<u64> = (0..self.n() as u32)
            .map(|a| {
                let all = self.of(a).iter().chain([&a]);
                all.fold(0u64, |sum, &b| {
                    sum.wrapping_add(mixed(b) ^ (mixed(b) >> 29))
                })
            })
            .collect();
        let mut first: Vec<u32> = (0..self.n() as u32).collect();
        let mut marked_by = vec![NONE; self.n()];
        for a in 0..self.n() as u32 {
            if first[a as usize] != a {
                continue;
            }
            let alike = |b: u32| {
                b > a
                    && sums[a as usize] == sums[b as usize]
                    && self.of(a).len() == self.of(b).len()
            };
            if !self.of(a).iter().any(|&b| alike(b)) {
                continue;
            }
            mark(self, a, &mut marked_by);
            for &b in self.of(a) {
                if alike(b) && self.of(b).iter().all(|&c| marked_by[c as usize] == a) {
                    first[b as usize] = a;
                }
            }
        }
        self.keep(|a, b| first[a as usize] == a && first[b as usize] == b);
        first
    }

    /// Pairs of a node and of one that is a neighbour of all its neighbours and has more of them.
    pub fn followers(&self) -> Vec<(u32, u32)> {
        let rank = |a: u32| (self.of(a).len(), a);
        let mut pairs = Vec::new();
        let mut marked_by = vec![NONE; self.n()];
        for a in 0..self.n() as u32 {
            mark(self, a, &mut marked_by);
            for &b in self.of(a) {
                if rank(b) < rank(a) && self.of(b).iter().all(|&c| marked_by[c as usize] == a) {
                    pairs.push((b, a));
                }
            }
        }
        pairs
    }
}

/// Pairs of different nodes that have an entry.
fn each_pair(lower: Lower, node: &[u32], mut take: impl FnMut(u32, u32)) {
    for (j, &a) in node.iter().enumerate().filter(|(_, a)| **a != NONE) {
        for &i in &lower.indices[lower.range(j)] {
            let b = node[i as usize];
            if b != NONE && b != a {
                take(a, b);
            }
        }
    }
}

/// Marks a node and its neighbours.
fn mark(graph: &NodalGraph, a: u32, marked_by: &mut [u32]) {
    marked_by[a as usize] = a;
    for &b in graph.of(a) {
        marked_by[b as usize] = a;
    }
}

/// Counts, each behind its number, become the starts.
pub fn summed(counts: &mut [u32]) {
    for a in 1..counts.len() {
        counts[a] += counts[a - 1];
    }
}
