//! Jacobians of constraints in blocks: for each node that a constraint touches, its three rows over the node's coordinates.
//!
//! Most nodes are a free body's six coordinates, or one joint. Their products have constant sizes, which compilers unroll.
//!
//! A coordinate that one constraint alone touches, as a wheel that stands on the ground, is in no node. It follows from its constraint, so
//! Newton's method leaves it out: see [`Alone`].

use std::ops::Range;

use crate::sparse::SparseProblem;

/// Most coordinates of a node.
pub(crate) const MAX_NODE: usize = 16;

/// The blocks of all constraints.
#[derive(Debug, Clone, Default)]
pub(crate) struct Parts {
    parts: Vec<Part>,
    of_constraint: Vec<Range<usize>>,
    /// Values of the blocks, row after row. Missing rows are zero.
    values: Vec<f64>,
    /// For each constraint, its coordinate that no other touches.
    alone: Vec<Option<Alone>>,
}

/// A coordinate that one constraint alone touches.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Alone {
    pub(crate) coordinate: usize,
    /// Velocity that a unit of it gives on the rows of the constraint.
    pub(crate) entry: [f64; 3],
}

/// One constraint's block of one node.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    pub(crate) node: usize,
    /// First coordinate of the node, and number of its coordinates.
    first: usize,
    size: usize,
    /// Start of its values.
    start: usize,
    /// Start of its pairs with the parts of its constraint, in the caller's list.
    pub(crate) pairs: usize,
}

impl Parts {
    /// Collects the parts of every constraint. `node_of` gives the node of a coordinate, with its first coordinate and size. `alone` has, for
    /// each constraint, the place of its coordinate that no other touches among its entries.
    pub(crate) fn collect(
        &mut self,
        problem: &SparseProblem,
        alone: &[Option<usize>],
        node_of: impl Fn(usize) -> (usize, usize, usize),
    ) {
        let Self { parts, of_constraint, values, alone: of_alone } = self;
        of_alone.clear();
        parts.clear();
        of_constraint.clear();
        values.clear();
        let mut pairs = 0;
        for (range, alone) in problem.ranges.iter().zip(alone) {
            let begin = parts.len();
            let entries = &problem.entries[range.clone()];
            of_alone.push(alone.map(|place| Alone { coordinate: entries[place].0, entry: entries[place].1 }));
            for (_, &(coordinate, entry)) in entries.iter().enumerate().filter(|(place, _)| Some(*place) != *alone) {
                let (node, first, size) = node_of(coordinate);
                if parts[begin..].last().is_none_or(|part: &Part| part.node != node) {
                    parts.push(Part { node, first, size, start: values.len(), pairs: 0 });
                    values.resize(values.len() + 3 * size, 0.0);
                }
                let start = parts[parts.len() - 1].start + coordinate - first;
                (0..3).for_each(|row| values[start + row * size] = entry[row]);
            }
            let count = parts.len() - begin;
            for part in &mut parts[begin..] {
                part.pairs = pairs;
                pairs += count;
            }
            of_constraint.push(begin..parts.len());
        }
    }

    /// Returns the parts of a constraint.
    pub(crate) fn of(&self, constraint: usize) -> &[Part] {
        &self.parts[self.of_constraint[constraint].clone()]
    }

    /// Returns the number of constraints.
    pub(crate) fn constraint_count(&self) -> usize {
        self.of_constraint.len()
    }

    fn values(&self, part: &Part) -> &[f64] {
        &self.values[part.start..][..3 * part.size]
    }

    /// Returns the coordinate that no other constraint touches.
    pub(crate) fn alone(&self, constraint: usize) -> Option<Alone> {
        self.alone[constraint]
    }

    /// Adds the changes of the coordinates by the impulses of a constraint.
    pub(crate) fn push(&self, constraint: usize, impulses: &[f64; 3], coordinates: &mut [f64]) {
        self.push_nodes(constraint, impulses, coordinates);
        if let Some(Alone { coordinate, entry: [x, y, z] }) = self.alone[constraint] {
            coordinates[coordinate] += x * impulses[0] + y * impulses[1] + z * impulses[2];
        }
    }

    /// Returns the velocity that the coordinates give on the rows of a constraint, m/s.
    pub(crate) fn pull(&self, constraint: usize, coordinates: &[f64]) -> [f64; 3] {
        let mut velocity = self.pull_nodes(constraint, coordinates);
        if let Some(Alone { coordinate, entry }) = self.alone[constraint] {
            velocity.iter_mut().zip(entry).for_each(|(velocity, entry)| *velocity += entry * coordinates[coordinate]);
        }
        velocity
    }

    /// Adds the changes of the coordinates of nodes by the impulses of a constraint.
    pub(crate) fn push_nodes(&self, constraint: usize, impulses: &[f64; 3], coordinates: &mut [f64]) {
        for part in self.of(constraint) {
            let (values, to) = (self.values(part), &mut coordinates[part.first..][..part.size]);
            match part.size {
                6 => push::<6>(values, impulses, to),
                1 => push::<1>(values, impulses, to),
                _ => {
                    for (row, impulse) in values.chunks_exact(part.size).zip(impulses) {
                        to.iter_mut().zip(row).for_each(|(to, entry)| *to += entry * impulse);
                    }
                }
            }
        }
    }

    /// Returns the velocity that the coordinates of nodes give on the rows of a constraint, m/s.
    pub(crate) fn pull_nodes(&self, constraint: usize, coordinates: &[f64]) -> [f64; 3] {
        let mut velocity = [0.0; 3];
        for part in self.of(constraint) {
            let (values, from) = (self.values(part), &coordinates[part.first..][..part.size]);
            match part.size {
                6 => pull::<6>(values, from, &mut velocity),
                1 => pull::<1>(values, from, &mut velocity),
                _ => {
                    for (row, velocity) in values.chunks_exact(part.size).zip(&mut velocity) {
                        *velocity += row.iter().zip(from).map(|(entry, speed)| entry * speed).sum::<f64>();
                    }
                }
            }
        }
        velocity
    }

    /// Adds `J' gain J` of a constraint to a matrix. `places` has, for each pair of parts, the start of its block and the length of the
    /// block's rows. Returns the multiplications.
    pub(crate) fn add(
        &self,
        constraint: usize,
        gain: &[[f64; 3]; 3],
        places: &[(usize, usize)],
        matrix: &mut [f64],
    ) -> u64 {
        let parts = self.of(constraint);
        let mut work = 0;
        for own in parts {
            let values = self.values(own);
            let mut gained = [0.0; 3 * MAX_NODE];
            let gained = &mut gained[..3 * own.size];
            for (to, column) in gained.chunks_exact_mut(own.size).zip(0..) {
                for (row, gain) in values.chunks_exact(own.size).zip(gain) {
                    to.iter_mut().zip(row).for_each(|(to, entry)| *to += entry * gain[column]);
                }
            }
            for (its, &(place, width)) in parts.iter().zip(&places[own.pairs..]) {
                let (other, to) = (self.values(its), &mut matrix[place..]);
                work += (3 * own.size * its.size) as u64;
                match (own.size, its.size) {
                    (6, 6) => add::<6, 6>(gained, other, to, width),
                    (6, 1) => add::<6, 1>(gained, other, to, width),
                    (1, 6) => add::<1, 6>(gained, other, to, width),
                    (1, 1) => add::<1, 1>(gained, other, to, width),
                    (size, columns) => {
                        for (row, to) in to.chunks_mut(width).take(size).enumerate() {
                            for (gained, its) in gained.chunks_exact(size).zip(other.chunks_exact(columns)) {
                                to.iter_mut().zip(its).for_each(|(to, entry)| *to += gained[row] * entry);
                            }
                        }
                    }
                }
            }
        }
        work
    }
}

#[inline(always)]
fn push<const SIZE: usize>(values: &[f64], impulses: &[f64; 3], to: &mut [f64]) {
    let (rows, _) = values.as_chunks::<SIZE>();
    if let ([one, two, three], Some(to)) = (rows, to.first_chunk_mut::<SIZE>()) {
        for place in 0..SIZE {
            to[place] += one[place] * impulses[0] + two[place] * impulses[1] + three[place] * impulses[2];
        }
    }
}

#[inline(always)]
fn pull<const SIZE: usize>(values: &[f64], from: &[f64], velocity: &mut [f64; 3]) {
    let (rows, _) = values.as_chunks::<SIZE>();
    if let Some(from) = from.first_chunk::<SIZE>() {
        for (row, velocity) in rows.iter().zip(velocity) {
            for place in 0..SIZE {
                *velocity += row[place] * from[place];
            }
        }
    }
}

/// Adds the product of two blocks, the first transposed.
#[inline(always)]
fn add<const ROWS: usize, const COLUMNS: usize>(gained: &[f64], its: &[f64], to: &mut [f64], width: usize) {
    let ((gained, _), (its, _)) = (gained.as_chunks::<ROWS>(), its.as_chunks::<COLUMNS>());
    let ([one, two, three], [first, second, third]) = (gained, its) else { return };
    for row in 0..ROWS {
        let Some(to) = to[row * width..].first_chunk_mut::<COLUMNS>() else { return };
        for column in 0..COLUMNS {
            to[column] += one[row] * first[column] + two[row] * second[column] + three[row] * third[column];
        }
    }
}
