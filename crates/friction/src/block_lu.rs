//! A sparse matrix of small blocks, factorised without pivoting between blocks.
//!
//! Nodes are groups of coordinates that the same constraints touch. They are eliminated in the order of least degree, which keeps most
//! blocks between nodes empty. The pattern of filled blocks is known before the numbers.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::parts::{MAX_NODE, Parts};
use crate::sparse::SparseProblem;

/// The pattern of a matrix and of its factors.
#[derive(Debug, Clone, Default)]
pub(crate) struct Pattern {
    /// Nodes in the order of elimination.
    nodes: Vec<Node>,
    /// The node of each coordinate; `usize::MAX` if no constraint touches it, or one alone.
    node_of: Vec<usize>,
    /// For each node, its later nodes that share a block with it, ascending; then the first column of each of these.
    later: Vec<usize>,
    starts: Vec<usize>,
    /// Total length of all blocks.
    size: usize,
    /// The Jacobian of every constraint, by nodes.
    pub(crate) parts: Parts,
    /// Start of the block of every pair of parts of one constraint, and the length of its rows.
    places: Vec<(usize, usize)>,
    scratch: Scratch,
}

/// A group of consecutive coordinates.
#[derive(Debug, Clone, Copy, Default)]
struct Node {
    /// Its first coordinate.
    first: usize,
    /// Number of its coordinates.
    size: usize,
    /// Body of the node.
    body: usize,
    /// Range of its later nodes.
    later: (usize, usize),
    /// Number of coordinates of its later nodes.
    width: usize,
    /// Start of its own block. The blocks of its row follow, `size` x `width`, then those of its column, `width` x `size`.
    place: usize,
}

/// Buffers of the ordering.
#[derive(Debug, Clone, Default)]
struct Scratch {
    marks: Vec<u64>,
    /// Number of constraints that touch each coordinate.
    counts: Vec<u32>,
    /// For each constraint, the place among its entries of a coordinate that no other touches.
    alone: Vec<Option<usize>>,
    near: Neighbours,
    touched: Vec<usize>,
}

impl Pattern {
    /// Finds the nodes, their order and the blocks that elimination fills. Returns the multiplications spent, roughly.
    pub(crate) fn find(&mut self, problem: &SparseProblem) -> u64 {
        let count = problem.coordinate_count();
        let Self { nodes, node_of, later, starts, size, scratch, .. } = self;
        let Scratch { marks, counts, alone, near, touched } = scratch;
        counts.clear();
        counts.resize(count, 0);
        problem.entries.iter().for_each(|(coordinate, _)| counts[*coordinate] += 1);
        alone.clear();
        alone.extend(problem.ranges.iter().map(|range| {
            // A root that one constraint alone touches stays one node.
            let entries = &problem.entries[range.clone()];
            let last = entries.iter().rposition(|(coordinate, _)| counts[*coordinate] == 1)?;
            let is_first = last == 0 || counts[entries[last - 1].0] > 1;
            is_first.then_some(last)
        }));
        // Coordinates that the same constraints touch have the same sum of marks. A chance collision only makes a block with zeros.
        marks.clear();
        marks.resize(count, 0);
        for (number, (range, alone)) in problem.ranges.iter().zip(&*alone).enumerate() {
            let mark = (number as u64 + 1)
                .wrapping_mul(0x9e37_79b9_7f4a_7c15)
                .rotate_left(29)
                .wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let entries = problem.entries[range.clone()].iter().enumerate();
            for (_, &(coordinate, _)) in entries.filter(|(place, _)| Some(*place) != *alone) {
                marks[coordinate] = marks[coordinate].wrapping_add(mark | 1);
            }
        }
        nodes.clear();
        node_of.clear();
        node_of.resize(count, usize::MAX);
        for (body, range) in problem.bodies.windows(2).enumerate() {
            for coordinate in range[0]..range[1] {
                if marks[coordinate] == 0 {
                    continue;
                }
                match nodes.last_mut() {
                    Some(node)
                        if node.body == body
                            && node.size < MAX_NODE
                            && node.first + node.size == coordinate
                            && marks[coordinate - 1] == marks[coordinate] =>
                    {
                        node.size += 1;
                    }
                    _ => nodes.push(Node { first: coordinate, size: 1, body, ..Node::default() }),
                }
                node_of[coordinate] = nodes.len() - 1;
            }
        }
        near.clear(nodes.len());
        for range in &problem.ranges {
            touched.clear();
            let nodes = problem.entries[range.clone()].iter().map(|(coordinate, _)| node_of[*coordinate]);
            touched.extend(nodes.filter(|node| *node != usize::MAX));
            touched.dedup();
            near.join(touched);
        }
        let mut work = 0;
        let order = near.order(nodes, &mut work);
        // From here on, nodes are numbered in elimination order.
        let mut place_of = vec![0; nodes.len()];
        order.iter().enumerate().for_each(|(place, &node)| place_of[node] = place);
        let sizes: Vec<usize> = nodes.iter().map(|node| node.size).collect();
        later.clear();
        starts.clear();
        *size = 0;
        let ordered = order.iter().map(|&number| {
            let start = later.len();
            later.extend(near.of(number).map(|other| place_of[other]));
            later[start..].sort_unstable();
            let mut width = 0;
            for &place in &later[start..] {
                starts.push(width);
                width += sizes[order[place]];
            }
            let node = Node { later: (start, later.len()), width, place: *size, ..nodes[number] };
            *size += node.size * (node.size + 2 * width);
            node
        });
        *nodes = ordered.collect();
        node_of.iter_mut().filter(|node| **node != usize::MAX).for_each(|node| *node = place_of[*node]);
        self.find_parts(problem);
        work
    }

    /// Collects the parts of every constraint, and finds the blocks of their pairs.
    fn find_parts(&mut self, problem: &SparseProblem) {
        let Self { nodes, node_of, parts, scratch, .. } = self;
        parts.collect(problem, &scratch.alone, |coordinate| {
            let node = node_of[coordinate];
            (node, nodes[node].first, nodes[node].size)
        });
        let mut places = std::mem::take(&mut self.places);
        places.clear();
        for constraint in 0..self.parts.constraint_count() {
            let parts = self.parts.of(constraint);
            places.extend(parts.iter().flat_map(|own| parts.iter().map(|its| self.block(own.node, its.node))));
        }
        self.places = places;
    }

    /// Sets the blocks of moving bodies to the identity.
    pub(crate) fn start(&self, moves: &[bool], matrix: &mut Vec<f64>) {
        matrix.resize(self.size, 0.0);
        for node in self.nodes.iter().filter(|node| moves[node.body]) {
            let own = &mut matrix[node.place..][..node.size * (node.size + 2 * node.width)];
            own.fill(0.0);
            (0..node.size).for_each(|row| own[row * (node.size + 1)] = 1.0);
        }
    }

    /// Adds the gain of a constraint to the blocks of its coordinates. Returns the multiplications.
    pub(crate) fn add(&self, constraint: usize, gain: &[[f64; 3]; 3], matrix: &mut [f64]) -> u64 {
        self.parts.add(constraint, gain, &self.places, matrix)
    }

    fn later(&self, node: &Node) -> &[usize] {
        &self.later[node.later.0..node.later.1]
    }

    /// Returns the start of the block of two nodes, and the length of its rows. The block must exist.
    fn block(&self, row: usize, column: usize) -> (usize, usize) {
        let (first, second) = (row.min(column), row.max(column));
        let node = &self.nodes[first];
        if row == column {
            return (node.place, node.size);
        }
        let before = self.starts[node.later.0 + self.later(node).partition_point(|&other| other < second)];
        let panel = node.place + node.size * node.size;
        if row == first {
            (panel + before, node.width)
        } else {
            (panel + node.size * node.width + before * node.size, node.size)
        }
    }

    /// Factorises a matrix and solves for a right-hand side, both in place, for the coordinates of moving bodies alone. Returns the
    /// multiplications, or `None` if there is no solution.
    pub(crate) fn solve(&self, matrix: &mut [f64], right: &mut [f64], moves: &[bool]) -> Option<u64> {
        let mut work = 0;
        let is_active = |node: &Node| moves[node.body];
        for node in self.nodes.iter().filter(|node| is_active(node)) {
            let Node { first, size, width, place, .. } = *node;
            let (before, after) = matrix.split_at_mut(place + size * (size + 2 * width));
            let own = &mut before[place..];
            let (diagonal, panels) = own.split_at_mut(size * size);
            let (upper, lower) = panels.split_at_mut(size * width);
            if !invert(diagonal, size) {
                return None;
            }
            work += (size * size * size) as u64;
            let mut own_right = [0.0; MAX_NODE];
            own_right[..size].copy_from_slice(&right[first..][..size]);
            let mut row_start = 0;
            for &row in self.later(node) {
                let row_node = &self.nodes[row];
                let start = row_start;
                row_start += row_node.size;
                if !is_active(row_node) {
                    continue;
                }
                // The column's block times the inverse of the diagonal block.
                let block = &mut lower[start * size..][..row_node.size * size];
                scale_block(block, diagonal, size);
                for (to, factors) in right[row_node.first..].iter_mut().zip(block.chunks_exact(size)) {
                    *to -= factors.iter().zip(&own_right).map(|(one, other)| one * other).sum::<f64>();
                }
            }
            let mut offset = 0;
            for (index, &row) in self.later(node).iter().enumerate() {
                let start = offset;
                offset += self.nodes[row].size;
                if !is_active(&self.nodes[row]) {
                    continue;
                }
                // Blocks of this row and column from here on. They have the same places in both panels.
                let target = &self.nodes[row];
                let (mut at, mut slot) = (0, 0);
                let slots = self.later(target);
                let panel = target.place - (place + size * (size + 2 * width));
                let mut column_start = start;
                for &column in &self.later(node)[index..] {
                    let column_node = &self.nodes[column];
                    let from = column_start;
                    column_start += column_node.size;
                    if !is_active(column_node) {
                        continue;
                    }
                    let (rows, columns) = (target.size, column_node.size);
                    work += (rows * columns * size) as u64;
                    if column == row {
                        let block = &mut after[panel..][..rows * rows];
                        subtract(block, rows, &lower[start * size..], size, &upper[from..], width, [rows, size, rows]);
                        continue;
                    }
                    while slots[slot] != column {
                        at += self.nodes[slots[slot]].size;
                        slot += 1;
                    }
                    work += (rows * columns * size) as u64;
                    let begin = panel + rows * rows;
                    let block = &mut after[begin + at..];
                    subtract(
                        block,
                        target.width,
                        &lower[start * size..],
                        size,
                        &upper[from..],
                        width,
                        [rows, size, columns],
                    );
                    let block = &mut after[begin + rows * target.width + at * rows..];
                    subtract(block, rows, &lower[from * size..], size, &upper[start..], width, [columns, size, rows]);
                }
            }
        }
        for node in self.nodes.iter().rev().filter(|node| is_active(node)) {
            let Node { first, size, width, place, .. } = *node;
            let upper = &matrix[place + size * size..][..size * width];
            let mut column = 0;
            for &other in self.later(node) {
                let (other_node, start) = (&self.nodes[other], column);
                column += other_node.size;
                if !is_active(other_node) {
                    continue;
                }
                for row in 0..size {
                    let factors = &upper[row * width + start..][..other_node.size];
                    let known = &right[other_node.first..][..other_node.size];
                    right[first + row] -= factors.iter().zip(known).map(|(one, other)| one * other).sum::<f64>();
                }
            }
            let inverse = &matrix[place..][..size * size];
            let mut solved = [0.0; MAX_NODE];
            for (to, factors) in solved.iter_mut().zip(inverse.chunks_exact(size)) {
                *to = factors.iter().zip(&right[first..][..size]).map(|(one, other)| one * other).sum::<f64>();
            }
            right[first..][..size].copy_from_slice(&solved[..size]);
        }
        Some(work)
    }
}

/// The neighbours of each node, as sets with one bit per node: a few words for the nodes of a heap.
#[derive(Debug, Clone, Default)]
struct Neighbours {
    /// Words per set.
    words: usize,
    bits: Vec<u64>,
    /// The union under construction.
    union: Vec<u64>,
    /// For each bit of the nodes' sizes, the set of nodes that have it.
    sizes: Vec<u64>,
}

impl Neighbours {
    /// Resets the sets for a number of nodes.
    fn clear(&mut self, count: usize) {
        self.words = count.div_ceil(64);
        self.bits.clear();
        self.bits.resize(count * self.words, 0);
    }

    /// Makes every node a neighbour of the others, and of itself.
    fn join(&mut self, nodes: &[usize]) {
        self.union.clear();
        self.union.resize(self.words, 0);
        nodes.iter().for_each(|&node| self.union[node / 64] |= 1 << (node % 64));
        for &node in nodes {
            let own = &mut self.bits[node * self.words..][..self.words];
            own.iter_mut().zip(&self.union).for_each(|(own, union)| *own |= union);
        }
    }

    /// Returns the neighbours of a node, ascending.
    fn of(&self, node: usize) -> impl Iterator<Item = usize> + '_ {
        members(&self.bits[node * self.words..][..self.words])
    }

    /// Counts the coordinates of a set. `sizes` has, for each bit of `used`, the nodes whose size has that bit.
    fn size_of(set: &[u64], sizes: &[u64], used: usize) -> usize {
        let bits = (0..usize::BITS).filter(|bit| used >> bit & 1 == 1);
        let count = |nodes: &[u64]| {
            set.iter().zip(nodes).map(|(one, other)| (one & other).count_ones() as usize).sum::<usize>()
        };
        sizes.chunks_exact(set.len()).zip(bits).map(|(nodes, bit)| count(nodes) << bit).sum()
    }

    /// Orders nodes by least degree. On return each set holds the nodes that are eliminated later and share a block with its node.
    fn order(&mut self, nodes: &[Node], work: &mut u64) -> Vec<usize> {
        let Self { words, bits, union, sizes } = self;
        let words = *words;
        sizes.clear();
        let used = nodes.iter().fold(0, |used, node| used | node.size);
        for bit in (0..usize::BITS).filter(|bit| used >> bit & 1 == 1) {
            let start = sizes.len();
            sizes.resize(start + words, 0);
            for (number, _) in nodes.iter().enumerate().filter(|(_, node)| node.size >> bit & 1 == 1) {
                sizes[start + number / 64] |= 1 << (number % 64);
            }
        }
        for number in 0..nodes.len() {
            bits[number * words + number / 64] &= !(1 << (number % 64));
        }
        let mut degrees: Vec<usize> =
            (0..nodes.len()).map(|node| Self::size_of(&bits[node * words..][..words], sizes, used)).collect();
        let mut queue: BinaryHeap<Reverse<(usize, usize)>> =
            degrees.iter().enumerate().map(|(node, &degree)| Reverse((degree, node))).collect();
        let mut order = Vec::with_capacity(nodes.len());
        let mut is_done = vec![false; nodes.len()];
        while let Some(Reverse((known, node))) = queue.pop() {
            if is_done[node] || degrees[node] != known {
                // A degree that has grown is queued again with its new value.
                if !is_done[node] && degrees[node] > known {
                    queue.push(Reverse((degrees[node], node)));
                }
                continue;
            }
            is_done[node] = true;
            order.push(node);
            union.clear();
            union.extend_from_slice(&bits[node * words..][..words]);
            for other in members(union) {
                let own = &mut bits[other * words..][..words];
                own.iter_mut().zip(&*union).for_each(|(own, union)| *own |= union);
                own[node / 64] &= !(1 << (node % 64));
                own[other / 64] &= !(1 << (other % 64));
                *work += words as u64;
                let degree = Self::size_of(own, sizes, used);
                if degree < degrees[other] {
                    queue.push(Reverse((degree, other)));
                }
                degrees[other] = degree;
            }
        }
        order
    }
}

/// Returns the members of a set, ascending.
fn members(set: &[u64]) -> impl Iterator<Item = usize> + '_ {
    set.iter().enumerate().flat_map(|(word, &bits)| {
        let mut left = bits;
        std::iter::from_fn(move || {
            let bit = (left != 0).then(|| left.trailing_zeros() as usize)?;
            left &= left - 1;
            Some(64 * word + bit)
        })
    })
}

/// Subtracts a product: `to` (rows x columns) less `one` (rows x inner) times `other` (inner x columns). Each has its own row length.
#[inline]
fn subtract(
    to: &mut [f64],
    to_width: usize,
    one: &[f64],
    one_width: usize,
    other: &[f64],
    other_width: usize,
    [rows, inner, columns]: [usize; 3],
) {
    match (inner, columns) {
        (6, 6) => subtract_of::<6, 6>(to, to_width, one, one_width, other, other_width, rows),
        (1, 6) => subtract_of::<1, 6>(to, to_width, one, one_width, other, other_width, rows),
        (2, 6) => subtract_of::<2, 6>(to, to_width, one, one_width, other, other_width, rows),
        (1, 1) => subtract_of::<1, 1>(to, to_width, one, one_width, other, other_width, rows),
        _ => {
            for row in 0..rows {
                let (to, factors) = (&mut to[row * to_width..][..columns], &one[row * one_width..][..inner]);
                for (factor, from) in factors.iter().zip(other.chunks(other_width)) {
                    to.iter_mut().zip(from).for_each(|(to, from)| *to -= factor * from);
                }
            }
        }
    }
}

#[inline]
fn subtract_of<const INNER: usize, const COLUMNS: usize>(
    to: &mut [f64],
    to_width: usize,
    one: &[f64],
    one_width: usize,
    other: &[f64],
    other_width: usize,
    rows: usize,
) {
    let from: [[f64; COLUMNS]; INNER] =
        std::array::from_fn(|row| *other[row * other_width..].first_chunk().unwrap_or(&[0.0; COLUMNS]));
    for row in 0..rows {
        let (Some(to), Some(factors)) =
            (to[row * to_width..].first_chunk_mut::<COLUMNS>(), one[row * one_width..].first_chunk::<INNER>())
        else {
            return;
        };
        let mut sum = *to;
        for (factor, from) in factors.iter().zip(&from) {
            sum.iter_mut().zip(from).for_each(|(sum, from)| *sum -= factor * from);
        }
        *to = sum;
    }
}

/// Multiplies the rows of a block by a square matrix, in place.
fn scale_block(block: &mut [f64], square: &[f64], size: usize) {
    match size {
        1 => block.iter_mut().for_each(|it| *it *= square[0]),
        // Most nodes are a free body's six coordinates.
        6 => scale_block_of::<6>(block, square),
        _ => {
            for row in block.chunks_exact_mut(size) {
                let mut scaled = [0.0; MAX_NODE];
                for (factor, from) in row.iter().zip(square.chunks_exact(size)) {
                    scaled[..size].iter_mut().zip(from).for_each(|(to, from)| *to += factor * from);
                }
                row.copy_from_slice(&scaled[..size]);
            }
        }
    }
}

/// Multiplies rows of a constant length, which is faster.
fn scale_block_of<const SIZE: usize>(block: &mut [f64], square: &[f64]) {
    let (square, _) = square.as_chunks::<SIZE>();
    for row in block.as_chunks_mut::<SIZE>().0 {
        let mut scaled = [0.0; SIZE];
        for (factor, from) in row.iter().zip(square) {
            (0..SIZE).for_each(|column| scaled[column] += factor * from[column]);
        }
        *row = scaled;
    }
}

/// Inverts a square matrix in place. Returns false if it has no inverse.
fn invert(matrix: &mut [f64], size: usize) -> bool {
    match size {
        1 => {
            matrix[0] = 1.0 / matrix[0];
            matrix[0].is_finite()
        }
        6 => invert_of(matrix, 6),
        _ => invert_of(matrix, size),
    }
}

/// Inverts by Gauss-Jordan elimination with row exchange.
#[inline(always)]
fn invert_of(matrix: &mut [f64], size: usize) -> bool {
    let mut swaps = [0; MAX_NODE];
    for pivot in 0..size {
        let mut chosen = pivot;
        for row in pivot + 1..size {
            if matrix[row * size + pivot].abs() > matrix[chosen * size + pivot].abs() {
                chosen = row;
            }
        }
        swaps[pivot] = chosen;
        if chosen != pivot {
            (0..size).for_each(|column| matrix.swap(chosen * size + column, pivot * size + column));
        }
        let inverse = 1.0 / matrix[pivot * size + pivot];
        if !inverse.is_finite() {
            return false;
        }
        let mut used = [0.0; MAX_NODE];
        let row = &mut matrix[pivot * size..][..size];
        row[pivot] = 1.0;
        row.iter_mut().for_each(|it| *it *= inverse);
        used[..size].copy_from_slice(row);
        for (number, row) in matrix.chunks_exact_mut(size).enumerate() {
            if number != pivot {
                let factor = std::mem::take(&mut row[pivot]);
                row.iter_mut().zip(&used).for_each(|(to, from)| *to -= factor * from);
            }
        }
    }
    for (pivot, &chosen) in swaps[..size].iter().enumerate().rev() {
        matrix.chunks_exact_mut(size).for_each(|row| row.swap(pivot, chosen));
    }
    true
}
