//! Problems of many bodies, of which each touches only a few others.

use std::ops::Range;

use crate::problem::Constraint;

/// Constraints of many bodies, by what an impulse does to each body.
///
/// A body has coordinates: velocities in which its inertia is the identity, so that an impulse changes each by the row's entry. Memory
/// grows with the entries; the Delassus matrix is never formed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SparseProblem {
    /// The first coordinate of every body, and behind them the number of all coordinates.
    pub bodies: Vec<usize>,
    /// Constraints; rows are ordered constraint by constraint.
    pub constraints: Vec<Constraint>,
    /// Right-hand side of each row: target velocity minus free velocity, m/s.
    pub missing: Vec<f64>,
    /// Velocity by which each row gives way under an impulse of 1 N s, m/s. Positive.
    pub compliance: Vec<f64>,
    /// The entries of each constraint: those of one body or two, the lower number first.
    pub ranges: Vec<Range<usize>>,
    /// Coordinates with the velocity that a unit of each gives on the rows of a constraint. Within a constraint they ascend.
    pub entries: Vec<(usize, [f64; 3])>,
}

impl SparseProblem {
    /// Empties the problem and keeps its memory.
    pub fn clear(&mut self) {
        let Self { bodies, constraints, missing, compliance, ranges, entries } = self;
        bodies.clear();
        constraints.clear();
        missing.clear();
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

    /// Adds the change that the impulses of a constraint make to the coordinates.
    pub(crate) fn push(&self, constraint: usize, impulses: &[f64; 3], coordinates: &mut [f64]) {
        for &(coordinate, [x, y, z]) in self.entries_of(constraint) {
            coordinates[coordinate] += x * impulses[0] + y * impulses[1] + z * impulses[2];
        }
    }

    /// Returns the velocity that the coordinates give on the rows of a constraint, m/s.
    pub(crate) fn pull(&self, constraint: usize, coordinates: &[f64]) -> [f64; 3] {
        let mut velocity = [0.0; 3];
        for &(coordinate, entry) in self.entries_of(constraint) {
            let speed = coordinates[coordinate];
            (0..3).for_each(|row| velocity[row] += entry[row] * speed);
        }
        velocity
    }
}

/// The rows of one constraint.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rows {
    pub(crate) constraint: Constraint,
    /// First row among all.
    pub(crate) first: usize,
    pub(crate) count: usize,
    /// Velocity that an impulse of 1 N s gives on its own row, m/s.
    pub(crate) own: [f64; 3],
    /// Target velocity minus free velocity, m/s.
    pub(crate) missing: [f64; 3],
    /// Velocity per impulse by which the row gives way, m/s.
    pub(crate) compliance: [f64; 3],
    /// The bodies that it touches; twice the same where it is one.
    pub(crate) bodies: [usize; 2],
}

impl Rows {
    /// Collects the rows of every constraint. Returns the unit of velocity by which residuals are measured, m/s.
    pub(crate) fn collect(problem: &SparseProblem, rows: &mut Vec<Self>) -> f64 {
        rows.clear();
        let mut first = 0;
        rows.extend(problem.constraints.iter().enumerate().map(|(number, &constraint)| {
            let count = constraint.rows();
            let of = |list: &[f64]| std::array::from_fn(|row| if row < count { list[first + row] } else { 0.0 });
            let (missing, compliance): ([f64; 3], [f64; 3]) = (of(&problem.missing), of(&problem.compliance));
            let entries = problem.entries_of(number);
            let mut own = compliance;
            for (_, entry) in entries {
                (0..count).for_each(|row| own[row] += entry[row] * entry[row]);
            }
            let ends = [entries.first(), entries.last()].map(|entry| entry.map_or(0, |(coordinate, _)| *coordinate));
            let bodies = ends.map(|coordinate| problem.bodies.partition_point(|&start| start <= coordinate) - 1);
            first += count;
            Self { constraint, first: first - count, count, own, missing, compliance, bodies }
        }));
        problem.missing.iter().fold(f64::MIN_POSITIVE, |most, missing| most.max(missing.abs()))
    }

    /// Returns its part of all impulses, 0 on rows that it does not have.
    pub(crate) fn of(&self, impulses: &[f64]) -> [f64; 3] {
        std::array::from_fn(|row| if row < self.count { impulses[self.first + row] } else { 0.0 })
    }

    /// Returns the residual velocity with an impulse, m/s, where the coordinates give `velocity`.
    pub(crate) fn residual_velocity(&self, velocity: [f64; 3], impulse: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|row| velocity[row] + self.compliance[row] * impulse[row] - self.missing[row])
    }

    /// Returns how far the constraint is from holding, m/s: as [`crate::Residual`], the worse of both.
    pub(crate) fn residual(&self, impulse: &[f64; 3], velocity: &[f64; 3]) -> f64 {
        let own = &self.own;
        match self.constraint {
            Constraint::Within(most) => {
                let wanted = (impulse[0] - velocity[0] / own[0]).clamp(-most, most);
                (impulse[0] - wanted).abs() * own[0]
            }
            Constraint::Contact { friction, tangents } => {
                let normal = (impulse[0] * own[0]).min(velocity[0]).abs();
                if tangents == 0 {
                    return normal;
                }
                let own = own[1..=tangents].iter().copied().fold(f64::INFINITY, f64::min);
                let most = friction * impulse[0].max(0.0);
                let wanted = [1, 2].map(|row| impulse[row] - velocity[row] / own);
                let length = if tangents == 1 {
                    wanted[0].abs()
                } else {
                    (wanted[0] * wanted[0] + wanted[1] * wanted[1]).sqrt()
                };
                let share = if length > most { most / length } else { 1.0 };
                let off = |row: usize| impulse[row] - wanted[row - 1] * share;
                let off = if tangents == 1 { off(1).abs() } else { (off(1).powi(2) + off(2).powi(2)).sqrt() };
                normal.max(off * own)
            }
        }
    }
}
