//! What is to be solved, and how well an answer solves it.

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
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Problem {
    /// The velocity that an impulse of 1 N s on a row gives on each row, m/s, row after row: symmetric and positive definite. What a
    /// constraint itself gives way, as a servo or a spring does, is on the diagonal.
    pub response: Vec<f64>,
    /// The velocity that is missing on each row without impulses, m/s: to the least normal velocity that is allowed, and to no slip.
    pub missing: Vec<f64>,
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

    /// What an impulse on a row gives on every one, m/s.
    pub(crate) fn of_row(&self, row: usize) -> &[f64] {
        let count = self.missing.len();
        &self.response[row * count..][..count]
    }

    /// What an impulse on a row gives on itself, m/s.
    pub(crate) fn own(&self, row: usize) -> f64 {
        self.response[row * (self.missing.len() + 1)]
    }

    /// The velocity that an impulse of 1 N s along a tangent gives there, m/s: of so many from a row on the one that gives way less.
    pub(crate) fn tangent_response(&self, first: usize, tangents: usize) -> f64 {
        (first..first + tangents).map(|row| self.own(row)).fold(f64::INFINITY, f64::min)
    }

    /// What velocities are measured by: the greatest that is missing, m/s.
    pub fn scale(&self) -> f64 {
        self.missing.iter().fold(f64::MIN_POSITIVE, |most, missing| most.max(missing.abs()))
    }

    /// Puts the velocity on every row with impulses, m/s, beside what was to be reached, in the place of `velocity`.
    pub(crate) fn velocity(&self, impulses: &[f64], velocity: &mut Vec<f64>) {
        velocity.clear();
        velocity
            .extend(self.missing.iter().enumerate().map(|(row, missing)| dot(self.of_row(row), impulses) - missing));
    }

    /// How well impulses solve it, N s.
    pub fn residual(&self, impulses: &[f64]) -> Residual {
        let mut velocity = Vec::new();
        self.velocity(impulses, &mut velocity);
        self.residual_at(impulses, &velocity)
    }

    /// The same for impulses whose velocity is known.
    pub(crate) fn residual_at(&self, impulses: &[f64], velocity: &[f64]) -> Residual {
        let scale = self.scale();
        let mut worst = Residual::default();
        for (row, constraint) in self.constraints() {
            match constraint {
                Constraint::Within(most) => {
                    let own = self.own(row);
                    let wanted = (impulses[row] - velocity[row] / own).clamp(-most, most);
                    worst.tangent = worst.tangent.max((impulses[row] - wanted).abs() * own / scale);
                }
                Constraint::Contact { friction, tangents } => {
                    // An impulse in terms of the velocity that it gives its own contact.
                    let (pushed, gap) = (impulses[row] * self.own(row), velocity[row]);
                    // Complementarity: the one that is not positive is to be 0.
                    worst.normal = worst.normal.max(pushed.min(gap).abs() / scale);
                    if tangents == 0 {
                        continue;
                    }
                    let own = self.tangent_response(row + 1, tangents);
                    // The impulse is the point of its disc nearest to itself less the slip (De Saxcé's projection).
                    let most = friction * impulses[row].max(0.0);
                    let wanted = |row: usize| impulses[row] - velocity[row] / own;
                    let rows = row + 1..=row + tangents;
                    let length = rows.clone().map(|row| wanted(row).powi(2)).sum::<f64>().sqrt();
                    let share = if length > most { most / length } else { 1.0 };
                    let off = rows.map(|row| (impulses[row] - wanted(row) * share).powi(2)).sum::<f64>();
                    worst.tangent = worst.tangent.max(off.sqrt() * own / scale);
                }
            }
        }
        worst
    }
}

/// The sum of products, in four sums that a processor can make at once.
pub(crate) fn dot(one: &[f64], other: &[f64]) -> f64 {
    let (fours, rest) = one.as_chunks::<4>();
    let (other_fours, other_rest) = other.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (one, other) in fours.iter().zip(other_fours) {
        (0..4).for_each(|lane| sums[lane] += one[lane] * other[lane]);
    }
    let rest: f64 = rest.iter().zip(other_rest).map(|(one, other)| one * other).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
