//! A sparse matrix of small blocks, factorised without exchanging blocks.
//!
//! Nodes are groups of coordinates that the same constraints touch. They are eliminated in the order of least degree, which keeps most
//! blocks between nodes empty; which are not is known before any number is.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

use crate::sparse::SparseProblem;

/// The pattern of a matrix and of its factors.
#[derive(Debug, Clone, Default)]
pub(crate) struct Pattern {
    /// Nodes in the order of elimination.
    nodes: Vec<Node>,
    /// The node of each coordinate; `usize::MAX` where no constraint touches it.
    node_of: Vec<usize>,
    /// Later nodes that share a block with each node, ascending.
    later: Vec<usize>,
    /// Numbers of all blocks.
    size: usize,
    /// For every constraint its parts: its entries by node.
    parts: Vec<Part>,
    parts_of: Vec<Range<usize>>,
    /// For every pair of parts of one constraint where their block begins, and the length of its rows.
    places: Vec<(usize, usize)>,
    scratch: Scratch,
}

/// Entries of a constraint that belong to one node.
#[derive(Debug, Clone, Copy)]
struct Part {
    node: usize,
    /// Its entries among those of the constraint.
    start: usize,
    end: usize,
    /// Where the places of its pairs begin.
    places: usize,
}

/// A group of consecutive coordinates.
#[derive(Debug, Clone, Copy, Default)]
struct Node {
    /// Its first coordinate.
    first: usize,
    /// Number of its coordinates.
    size: usize,
    /// The body that it belongs to.
    body: usize,
    /// Its later nodes.
    later: (usize, usize),
    /// Coordinates of its later nodes.
    width: usize,
    /// Where its own block begins; behind it the blocks of its row, `size` x `width`, then those of its column, `width` x `size`.
    place: usize,
}

/// Buffers of the ordering.
#[derive(Debug, Clone, Default)]
struct Scratch {
    marks: Vec<u64>,
    near: Vec<Vec<usize>>,
    touched: Vec<usize>,
}

impl Pattern {
    /// Finds nodes, their order and the blocks that their elimination fills. Returns the multiplications that took, roughly.
    pub(crate) fn find(&mut self, problem: &SparseProblem) -> u64 {
        let count = problem.bodies.last().copied().unwrap_or(0);
        let Self { nodes, node_of, later, size, scratch, .. } = self;
        let Scratch { marks, near, touched } = scratch;
        // Coordinates that the same constraints touch have the same sum of marks. Two that share one by chance make a block with zeros.
        marks.clear();
        marks.resize(count, 0);
        for (number, range) in problem.ranges.iter().enumerate() {
            let mark = (number as u64 + 1)
                .wrapping_mul(0x9e37_79b9_7f4a_7c15)
                .rotate_left(29)
                .wrapping_mul(0xbf58_476d_1ce4_e5b9);
            for &(coordinate, _) in &problem.entries[range.clone()] {
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
        near.iter_mut().for_each(Vec::clear);
        near.resize_with(near.len().max(nodes.len()), Vec::new);
        for range in &problem.ranges {
            touched.clear();
            touched.extend(problem.entries[range.clone()].iter().map(|(coordinate, _)| node_of[*coordinate]));
            touched.dedup();
            for &one in touched.iter() {
                near[one].extend(touched.iter().filter(|&&other| other != one));
            }
        }
        near.iter_mut().for_each(|near| {
            near.sort_unstable();
            near.dedup();
        });
        let mut work = 0;
        let order = order(nodes, near, &mut work);
        // From here on nodes are numbered in that order.
        let mut place_of = vec![0; nodes.len()];
        order.iter().enumerate().for_each(|(place, &node)| place_of[node] = place);
        let sizes: Vec<usize> = nodes.iter().map(|node| node.size).collect();
        later.clear();
        *size = 0;
        let ordered = order.iter().map(|&number| {
            let start = later.len();
            later.extend(near[number].iter().map(|&other| place_of[other]));
            later[start..].sort_unstable();
            let width = near[number].iter().map(|&other| sizes[other]).sum();
            let node = Node { later: (start, later.len()), width, place: *size, ..nodes[number] };
            *size += node.size * (node.size + 2 * width);
            node
        });
        *nodes = ordered.collect();
        node_of.iter_mut().filter(|node| **node != usize::MAX).for_each(|node| *node = place_of[*node]);
        self.find_parts(problem);
        work
    }

    /// Finds the parts of every constraint and the blocks of their pairs.
    fn find_parts(&mut self, problem: &SparseProblem) {
        let (mut parts, mut parts_of) = (std::mem::take(&mut self.parts), std::mem::take(&mut self.parts_of));
        let mut places = std::mem::take(&mut self.places);
        parts.clear();
        parts_of.clear();
        places.clear();
        for constraint in 0..problem.constraints.len() {
            let first = parts.len();
            for (number, (coordinate, _)) in problem.entries_of(constraint).iter().enumerate() {
                let node = self.node_of[*coordinate];
                match parts[first..].last_mut() {
                    Some(Part { node: known, end, .. }) if *known == node => *end = number + 1,
                    _ => parts.push(Part { node, start: number, end: number + 1, places: 0 }),
                }
            }
            let count = parts.len() - first;
            for own in first..parts.len() {
                parts[own].places = places.len();
                for its in first..first + count {
                    places.push(self.block(parts[own].node, parts[its].node));
                }
            }
            parts_of.push(first..first + count);
        }
        (self.parts, self.parts_of, self.places) = (parts, parts_of, places);
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

    /// Adds the gain of a constraint between the coordinates that it touches. Returns the multiplications.
    pub(crate) fn add(
        &self,
        constraint: usize,
        entries: &[(usize, [f64; 3])],
        gain: &[[f64; 3]; 3],
        matrix: &mut [f64],
    ) -> u64 {
        let parts = &self.parts[self.parts_of[constraint].clone()];
        for own in parts {
            let own_first = self.nodes[own.node].first;
            for (coordinate, entry) in &entries[own.start..own.end] {
                let mut pushed = [0.0; 3];
                for row in 0..3 {
                    (0..3).for_each(|column| pushed[column] += entry[row] * gain[row][column]);
                }
                for (its, &(place, width)) in parts.iter().zip(&self.places[own.places..]) {
                    let line = &mut matrix[place + (coordinate - own_first) * width..];
                    // Its coordinates are consecutive.
                    let its_entries = &entries[its.start..its.end];
                    let first = its_entries[0].0 - self.nodes[its.node].first;
                    for (to, (_, entry)) in line[first..].iter_mut().zip(its_entries) {
                        *to += pushed[0] * entry[0] + pushed[1] * entry[1] + pushed[2] * entry[2];
                    }
                }
            }
        }
        (entries.len() * (entries.len() + 3) * 3) as u64
    }

    fn later(&self, node: &Node) -> &[usize] {
        &self.later[node.later.0..node.later.1]
    }

    /// Returns where the block of two nodes begins, and the length of its rows. There has to be one.
    fn block(&self, row: usize, column: usize) -> (usize, usize) {
        let (first, second) = (row.min(column), row.max(column));
        let node = &self.nodes[first];
        if row == column {
            return (node.place, node.size);
        }
        let before: usize =
            self.later(node).iter().take_while(|&&other| other < second).map(|&other| self.nodes[other].size).sum();
        let panel = node.place + node.size * node.size;
        if row == first {
            (panel + before, node.width)
        } else {
            (panel + node.size * node.width + before * node.size, node.size)
        }
    }

    /// Factorises a matrix in place and solves for a right-hand side in place, for the coordinates of moving bodies alone. Returns the
    /// multiplications, or `None` without an answer.
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
                // The column's block times the inverse of the node's own.
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
                // Blocks of this row and of this column from here on: the same places in both panels.
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

/// Most coordinates of a node.
const MAX_NODE: usize = 16;

/// Orders nodes by least degree. Leaves each with the nodes that are eliminated after it and share a block with it.
fn order(nodes: &[Node], near: &mut [Vec<usize>], work: &mut u64) -> Vec<usize> {
    let degree = |near: &[usize]| near.iter().map(|&other| nodes[other].size).sum::<usize>();
    let mut queue: BinaryHeap<Reverse<(usize, usize)>> =
        (0..nodes.len()).map(|node| Reverse((degree(&near[node]), node))).collect();
    let (mut order, mut merged) = (Vec::with_capacity(nodes.len()), Vec::new());
    let mut is_done = vec![false; nodes.len()];
    while let Some(Reverse((known, node))) = queue.pop() {
        if is_done[node] || degree(&near[node]) != known {
            continue;
        }
        is_done[node] = true;
        order.push(node);
        let own = std::mem::take(&mut near[node]);
        *work += (own.len() * own.len()) as u64;
        for &other in &own {
            merged.clear();
            merge(&near[other], &own, &mut merged);
            merged.retain(|&it| it != node && it != other);
            if near[other] != merged {
                std::mem::swap(&mut near[other], &mut merged);
                queue.push(Reverse((degree(&near[other]), other)));
            }
        }
        near[node] = own;
    }
    order
}

/// Merges two ascending lists.
fn merge(one: &[usize], other: &[usize], merged: &mut Vec<usize>) {
    let (mut left, mut right) = (one.iter().peekable(), other.iter().peekable());
    while let (Some(&&a), Some(&&b)) = (left.peek(), right.peek()) {
        merged.push(a.min(b));
        if a <= b {
            left.next();
        }
        if b <= a {
            right.next();
        }
    }
    merged.extend(left);
    merged.extend(right);
}

/// Subtracts a product: `to` (rows x columns) less `one` (rows x inner) times `other` (inner x columns), each with its length of rows.
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
    if let ([], Some(square), 6) = (block.as_chunks::<6>().1, square.as_chunks::<6>().0.first_chunk::<6>(), size) {
        for row in block.as_chunks_mut::<6>().0 {
            let mut scaled = [0.0; 6];
            for (factor, from) in row.iter().zip(square) {
                scaled.iter_mut().zip(from).for_each(|(to, from)| *to += factor * from);
            }
            *row = scaled;
        }
        return;
    }
    if size == 1 {
        return block.iter_mut().for_each(|it| *it *= square[0]);
    }
    let mut scaled = [0.0; MAX_NODE];
    for row in block.chunks_exact_mut(size) {
        let scaled = &mut scaled[..size];
        scaled.fill(0.0);
        for (factor, from) in row.iter().zip(square.chunks_exact(size)) {
            scaled.iter_mut().zip(from).for_each(|(to, from)| *to += factor * from);
        }
        row.copy_from_slice(scaled);
    }
}

/// Inverts a square matrix in place, with exchange of rows. Returns false if it has no inverse.
fn invert(matrix: &mut [f64], size: usize) -> bool {
    match size {
        1 => {
            matrix[0] = 1.0 / matrix[0];
            matrix[0].is_finite()
        }
        6 => matrix.as_chunks_mut::<6>().0.first_chunk_mut::<6>().is_some_and(invert_six),
        _ => invert_any(matrix, size),
    }
}

/// [`invert_any`] for a free body's six coordinates, most of all nodes.
fn invert_six(matrix: &mut [[f64; 6]; 6]) -> bool {
    let mut swaps = [0; 6];
    for pivot in 0..6 {
        let mut chosen = pivot;
        for row in pivot + 1..6 {
            if matrix[row][pivot].abs() > matrix[chosen][pivot].abs() {
                chosen = row;
            }
        }
        swaps[pivot] = chosen;
        matrix.swap(chosen, pivot);
        let inverse = 1.0 / matrix[pivot][pivot];
        if !inverse.is_finite() {
            return false;
        }
        matrix[pivot][pivot] = 1.0;
        matrix[pivot].iter_mut().for_each(|it| *it *= inverse);
        let used = matrix[pivot];
        for (number, row) in matrix.iter_mut().enumerate() {
            if number != pivot {
                let factor = std::mem::take(&mut row[pivot]);
                row.iter_mut().zip(&used).for_each(|(to, from)| *to -= factor * from);
            }
        }
    }
    for (pivot, &chosen) in swaps.iter().enumerate().rev() {
        matrix.iter_mut().for_each(|row| row.swap(pivot, chosen));
    }
    true
}

/// Gauss-Jordan elimination.
fn invert_any(matrix: &mut [f64], size: usize) -> bool {
    let mut swaps = [0; MAX_NODE];
    for pivot in 0..size {
        let by_size = |&row: &usize| matrix[row * size + pivot].abs();
        let mut chosen = pivot;
        for row in pivot + 1..size {
            if by_size(&row) > by_size(&chosen) {
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
        matrix[pivot * size + pivot] = 1.0;
        matrix[pivot * size..][..size].iter_mut().for_each(|it| *it *= inverse);
        for row in (0..size).filter(|&row| row != pivot) {
            let factor = matrix[row * size + pivot];
            matrix[row * size + pivot] = 0.0;
            for column in 0..size {
                matrix[row * size + column] -= factor * matrix[pivot * size + column];
            }
        }
    }
    for pivot in (0..size).rev() {
        let chosen = swaps[pivot];
        if chosen != pivot {
            (0..size).for_each(|row| matrix.swap(row * size + chosen, row * size + pivot));
        }
    }
    true
}
