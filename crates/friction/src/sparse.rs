//! Problems of many bodies, each of which touches only a few others.

use std::ops::Range;

use crate::problem::Constraint;

/// Constraints of many bodies, given by the effect of an impulse on each body.
///
/// A body has coordinates: velocities in which its inertia is the identity, so an impulse changes each by the row's entry. Memory grows
/// with the entries, as the Delassus matrix is never formed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SparseProblem {
    /// First coordinate of every body, followed by the number of all coordinates.
    pub bodies: Vec<usize>,
    /// Constraints; rows are ordered constraint by constraint.
    pub constraints: Vec<Constraint>,
    /// Right-hand side of each row: target velocity minus free velocity, m/s.
    pub right_side: Vec<f64>,
    /// Compliance of each row: velocity per impulse of 1 N s, m/s. Positive.
    pub compliance: Vec<f64>,
    /// Ranges of the entries of each constraint. They belong to one body or to two, the lower number first.
    pub ranges: Vec<Range<usize>>,
    /// Coordinates, each with the velocity that a unit of it gives on the rows of a constraint. They ascend within a constraint.
    pub entries: Vec<(usize, [f64; 3])>,
}

impl SparseProblem {
    /// Empties the problem and keeps its memory.
    pub fn clear(&mut self) {
        let Self { bodies, constraints, right_side, compliance, ranges, entries } = self;
        bodies.clear();
        constraints.clear();
        right_side.clear();
        compliance.clear();
        ranges.clear();
        entries.clear();
    }

    pub(crate) fn coordinate_count(&self) -> usize {
        self.bodies.last().copied().unwrap_or(0)
    }

    pub(crate) fn entries_of(&self, constraint: usize) -> &[(usize, [f64; 3])] {
        &self.entries[self.ranges[constraint].clone()]
    }
}

/// The rows of one constraint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rows {
    pub(crate) constraint: Constraint,
    /// First row among all.
    pub(crate) first: usize,
    pub(crate) count: usize,
    /// Velocity that an impulse of 1 N s gives on its own row, with the compliance, m/s.
    pub(crate) own: [f64; 3],
    /// Target velocity minus free velocity, m/s.
    pub(crate) right_side: [f64; 3],
    /// Velocity per impulse of 1 N s by which the row gives way, m/s.
    pub(crate) compliance: [f64; 3],
    /// Inverses of the least and of the largest response of the tangents. With the least one a holding contact could be taken for a
    /// sliding one.
    pub(crate) grip: [f64; 2],
    /// The two bodies of the constraint; equal if there is only one.
    pub(crate) bodies: [usize; 2],
}

impl Rows {
    /// Collects the rows of every constraint. Returns the unit of velocity for residuals, m/s.
    pub(crate) fn collect(problem: &SparseProblem, rows: &mut Vec<Self>) -> f64 {
        rows.clear();
        let mut first = 0;
        rows.extend(problem.constraints.iter().enumerate().map(|(number, &constraint)| {
            let count = constraint.rows();
            let of = |list: &[f64]| std::array::from_fn(|row| if row < count { list[first + row] } else { 0.0 });
            let (right_side, compliance): ([f64; 3], [f64; 3]) = (of(&problem.right_side), of(&problem.compliance));
            let entries = problem.entries_of(number);
            let mut own = compliance;
            for (_, entry) in entries {
                (0..count).for_each(|row| own[row] += entry[row] * entry[row]);
            }
            let ends = [entries.first(), entries.last()].map(|entry| entry.map_or(0, |(coordinate, _)| *coordinate));
            let bodies = ends.map(|coordinate| problem.bodies.partition_point(|&start| start <= coordinate) - 1);
            first += count;
            let most = own[1..count].iter().copied().fold(0.0, f64::max);
            let grip = [constraint.grip(&own), if most > 0.0 { 1.0 / most } else { 0.0 }];
            Self { constraint, first: first - count, count, own, right_side, compliance, grip, bodies }
        }));
        problem.right_side.iter().fold(f64::MIN_POSITIVE, |most, right_side| most.max(right_side.abs()))
    }

    /// Returns the constraint's impulses out of all. They are 0 on missing rows.
    pub(crate) fn of(&self, impulses: &[f64]) -> [f64; 3] {
        std::array::from_fn(|row| if row < self.count { impulses[self.first + row] } else { 0.0 })
    }

    /// Returns the residual velocity, m/s, with an impulse and the `velocity` of the coordinates.
    pub(crate) fn residual_velocity(&self, velocity: [f64; 3], impulse: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|row| velocity[row] + self.compliance[row] * impulse[row] - self.right_side[row])
    }

    /// Returns the tangent impulses with which the contact would hold, estimated from its impulse and residual velocity. If they exceed its
    /// friction, the contact slides and friction has their direction.
    pub(crate) fn holding(&self, impulse: &[f64; 3], velocity: &[f64; 3]) -> [f64; 2] {
        // Missing rows have neither.
        [1, 2].map(|row| impulse[row] - velocity[row] * self.grip[1])
    }

    /// Returns the square of the residual of the constraint, (m/s)²: of the larger of [`crate::Residual`]'s two.
    pub(crate) fn squared_residual(&self, impulse: &[f64; 3], velocity: &[f64; 3]) -> f64 {
        let [normal, tangent] = self.constraint.squared_residual(&self.own, self.grip[0], impulse, velocity);
        normal.max(tangent)
    }
}
