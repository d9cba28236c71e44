//! What is to be solved, and how well an answer solves it.

use nalgebra::{DMatrix, DVector};

/// Rows that belong together, and what their impulses may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Constraint {
    /// A contact: its normal, then so many tangents. Two at a surface; one at a free roller, whose axis it is; none at the end of a
    /// joint. The normal impulse is 0 or more, that of the tangents together at most the coefficient of friction times as much.
    Contact {
        /// Coefficient of friction.
        friction: f64,
        /// 0 to 2.
        tangents: usize,
    },
    /// One row whose impulse is at most so much either way, N s: dry friction of a joint, or a coupling where it is infinite.
    Within(f64),
}

impl Constraint {
    /// How many rows it has.
    pub fn rows(&self) -> usize {
        match self {
            Self::Contact { tangents, .. } => 1 + tangents,
            Self::Within(_) => 1,
        }
    }
}

/// Constraints of bodies that act on each other. Rows are ordered constraint by constraint.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// The velocity that an impulse of 1 N s on a row gives on each row, m/s: symmetric and positive definite. What a constraint
    /// itself gives way, as a servo or a spring does, is on the diagonal.
    pub response: DMatrix<f64>,
    /// The velocity that is missing on each row without impulses, m/s: to the least normal velocity that is allowed, and to no slip.
    pub missing: DVector<f64>,
    /// The constraints.
    pub constraints: Vec<Constraint>,
}

/// By how much an answer misses, at the constraint where it misses most; relative to the greatest velocity that was missing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Residual {
    /// A contact pulls or goes on to penetrate.
    pub normal: f64,
    /// A contact pushes aside with more than its friction, or slides without pushing against its slip with all of it.
    pub tangent: f64,
}

impl Residual {
    /// The worse of both.
    pub fn worst(self) -> f64 {
        self.normal.max(self.tangent)
    }
}

impl Problem {
    /// Every constraint with its first row.
    pub(crate) fn constraints(&self) -> impl Iterator<Item = (usize, Constraint)> {
        let mut next = 0;
        self.constraints.iter().map(move |&constraint| {
            let row = next;
            next += constraint.rows();
            (row, constraint)
        })
    }

    /// The velocity that an impulse of 1 N s along a tangent gives there, m/s: of so many from a row on the one that gives way less.
    pub(crate) fn tangent_response(&self, first: usize, tangents: usize) -> f64 {
        (first..first + tangents).map(|row| self.response[(row, row)]).fold(f64::INFINITY, f64::min)
    }

    /// What velocities are measured by: the greatest that is missing, m/s.
    pub fn scale(&self) -> f64 {
        self.missing.amax().max(f64::MIN_POSITIVE)
    }

    /// The velocity on every row with impulses, m/s, beside what was to be reached.
    pub(crate) fn velocity(&self, impulses: &DVector<f64>) -> DVector<f64> {
        &self.response * impulses - &self.missing
    }

    /// How well impulses solve it, N s.
    pub fn residual(&self, impulses: &DVector<f64>) -> Residual {
        self.residual_at(impulses, &self.velocity(impulses))
    }

    /// The same for impulses whose velocity is known.
    pub(crate) fn residual_at(&self, impulses: &DVector<f64>, velocity: &DVector<f64>) -> Residual {
        let scale = self.scale();
        let mut worst = Residual::default();
        for (row, constraint) in self.constraints() {
            match constraint {
                Constraint::Within(most) => {
                    let own = self.response[(row, row)];
                    let wanted = (impulses[row] - velocity[row] / own).clamp(-most, most);
                    worst.tangent = worst.tangent.max((impulses[row] - wanted).abs() * own / scale);
                }
                Constraint::Contact { friction, tangents } => {
                    // An impulse in terms of the velocity that it gives its own contact.
                    let (pushed, gap) = (impulses[row] * self.response[(row, row)], velocity[row]);
                    // Complementarity: the one that is not positive is to be 0.
                    worst.normal = worst.normal.max(pushed.min(gap).abs() / scale);
                    if tangents == 0 {
                        continue;
                    }
                    let own = self.tangent_response(row + 1, tangents);
                    // The impulse is the point of its disc nearest to itself less the slip (De Saxcé's projection).
                    let most = friction * impulses[row].max(0.0);
                    let (push, slip) = (impulses.rows(row + 1, tangents), velocity.rows(row + 1, tangents));
                    let wanted = |tangent: usize| push[tangent] - slip[tangent] / own;
                    let length = (0..tangents).map(|tangent| wanted(tangent).powi(2)).sum::<f64>().sqrt();
                    let share = if length > most { most / length } else { 1.0 };
                    let off =
                        (0..tangents).map(|tangent| (push[tangent] - wanted(tangent) * share).powi(2)).sum::<f64>();
                    worst.tangent = worst.tangent.max(off.sqrt() * own / scale);
                }
            }
        }
        worst
    }
}
