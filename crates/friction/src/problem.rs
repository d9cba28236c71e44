//! The problem of contacts, and the residual of an answer.

/// Rows that belong together, with the bounds of their impulses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Constraint {
    /// A contact: its normal row, then its tangent rows. A surface has two tangents. A free roller has one, along its axis. The end of a
    /// joint has none. The normal impulse is at least 0. The tangent impulse is at most the coefficient of friction times the normal one.
    Contact {
        /// Coefficient of friction.
        friction: f64,
        /// Number of tangents, 0 to 2.
        tangents: usize,
    },
    /// One row whose impulse is bounded in both directions, N s: dry friction of a joint, or a coupling if the bound is infinite.
    Within(f64),
}

impl Constraint {
    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        match self {
            Self::Contact { tangents, .. } => 1 + tangents,
            Self::Within(_) => 1,
        }
    }

    /// Returns the inverse of the least response of the tangents; 0 without tangents. With the responses of all rows, m/s for 1 N s.
    pub(crate) fn grip(self, own: &[f64; 3]) -> f64 {
        let tangents = &own[1..self.rows()];
        if tangents.is_empty() { 0.0 } else { 1.0 / tangents.iter().copied().fold(f64::INFINITY, f64::min) }
    }

    /// Computes the squares of the residual's two parts, (m/s)²: of the normal and of the tangents. That of a contact that holds needs no root.
    /// `own` is the velocity that an impulse of 1 N s gives on its own row, and `grip` is [`Self::grip`]. Then come the impulses and the
    /// residual velocities. Missing rows have zeros.
    #[inline]
    pub(crate) fn squared_residual(
        self,
        own: &[f64; 3],
        grip: f64,
        impulse: &[f64; 3],
        velocity: &[f64; 3],
    ) -> [f64; 2] {
        match self {
            Self::Within(most) => {
                let wanted = (impulse[0] - velocity[0] / own[0]).clamp(-most, most);
                [0.0, ((impulse[0] - wanted) * own[0]).powi(2)]
            }
            Self::Contact { friction, tangents } => {
                // Impulses are scaled by their response to velocities. Complementarity: the smaller of the two must be 0.
                let normal = (impulse[0] * own[0]).min(velocity[0]).powi(2);
                if tangents == 0 {
                    return [normal, 0.0];
                }
                // The tangent impulse is the projection onto its disc of itself less the slip (De Saxcé).
                let most = friction * impulse[0].max(0.0);
                let wanted = [1, 2].map(|row| impulse[row] - velocity[row] * grip);
                let squared = wanted[0] * wanted[0] + wanted[1] * wanted[1];
                if squared <= most * most {
                    return [normal, velocity[1] * velocity[1] + velocity[2] * velocity[2]];
                }
                let share = most / squared.sqrt();
                let off = [1, 2].map(|row| impulse[row] - wanted[row - 1] * share);
                [normal, (off[0] * off[0] + off[1] * off[1]) / (grip * grip)]
            }
        }
    }
}

/// Constraints of bodies that interact. Rows are ordered constraint by constraint.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Problem {
    /// Delassus matrix, row after row: the velocity that an impulse of 1 N s on a row gives on each row, m/s. It is symmetric and positive
    /// definite. The compliance of a constraint, as of a servo or spring, is on the diagonal.
    pub delassus: Vec<f64>,
    /// Right-hand side of each row: target velocity minus free velocity, m/s. The target is the least permitted normal velocity, and no
    /// slip.
    pub right_side: Vec<f64>,
    /// The constraints.
    pub constraints: Vec<Constraint>,
}

/// Residual of the constraint with the largest one, relative to the largest entry of the right-hand side.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Residual {
    /// Violation by a contact that pulls or penetrates further.
    pub normal: f64,
    /// Violation by a contact that exceeds its friction, or slides without full friction against its slip.
    pub tangent: f64,
}

impl Residual {
    /// Returns the larger of both.
    pub fn worst(self) -> f64 {
        self.normal.max(self.tangent)
    }
}

impl Problem {
    /// Returns every constraint with its first row.
    pub(crate) fn constraints(&self) -> impl Iterator<Item = (usize, Constraint)> {
        let mut next = 0;
        self.constraints.iter().map(move |&constraint| {
            let row = next;
            next += constraint.rows();
            (row, constraint)
        })
    }

    /// Returns a row of the Delassus matrix, m/s for an impulse of 1 N s.
    pub(crate) fn of_row(&self, row: usize) -> &[f64] {
        let count = self.right_side.len();
        &self.delassus[row * count..][..count]
    }

    /// Returns the diagonal entry of a row, m/s for an impulse of 1 N s.
    pub(crate) fn own(&self, row: usize) -> f64 {
        self.delassus[row * (self.right_side.len() + 1)]
    }

    /// Returns the unit of velocity for residuals: the largest entry of the right-hand side, m/s.
    pub fn scale(&self) -> f64 {
        self.right_side.iter().fold(f64::MIN_POSITIVE, |most, right_side| most.max(right_side.abs()))
    }

    /// Stores in `velocity` the residual velocity of every row, m/s: the velocity with impulses minus its target.
    pub(crate) fn velocity(&self, impulses: &[f64], velocity: &mut Vec<f64>) {
        let count = self.right_side.len();
        velocity.clear();
        velocity.extend(self.right_side.iter().map(|right_side| -right_side));
        // The matrix is symmetric, so its columns are its rows. Four sums at a time stay in registers.
        let (fours, rest) = velocity.as_chunks_mut::<4>();
        let first_of_rest = 4 * fours.len();
        for (number, sums) in fours.iter_mut().enumerate() {
            let mut sum = *sums;
            for (column, impulse) in self.delassus.chunks_exact(count).zip(impulses) {
                let column = column.as_chunks::<4>().0[number];
                (0..4).for_each(|lane| sum[lane] += column[lane] * impulse);
            }
            *sums = sum;
        }
        for (row, sum) in rest.iter_mut().enumerate() {
            *sum += dot(self.of_row(first_of_rest + row), impulses);
        }
    }

    /// Computes the residual of impulses, N s.
    pub fn residual(&self, impulses: &[f64]) -> Residual {
        let mut velocity = Vec::new();
        self.velocity(impulses, &mut velocity);
        self.residual_at(impulses, &velocity, self.scale())
    }

    /// Computes the residual of impulses whose residual velocity is known, with the unit of velocity.
    pub(crate) fn residual_at(&self, impulses: &[f64], velocity: &[f64], scale: f64) -> Residual {
        let mut worst = [0.0_f64; 2];
        for (row, constraint) in self.constraints() {
            let count = constraint.rows();
            let of = |list: &[f64]| std::array::from_fn(|it| if it < count { list[row + it] } else { 0.0 });
            let own: [f64; 3] = std::array::from_fn(|it| if it < count { self.own(row + it) } else { 0.0 });
            let grip = constraint.grip(&own);
            let squares = constraint.squared_residual(&own, grip, &of(impulses), &of(velocity));
            worst.iter_mut().zip(squares).for_each(|(worst, square)| *worst = worst.max(square));
        }
        let [normal, tangent] = worst.map(|square| square.sqrt() / scale);
        Residual { normal, tangent }
    }
}

/// Returns the dot product, in four sums for SIMD.
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
