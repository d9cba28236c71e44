//! What is to be solved, and how well an answer solves it.

use nalgebra::{DMatrix, DVector, Vector2};

use crate::ROWS;

/// A contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Coefficient of friction.
    pub friction: f64,
    /// Whether friction acts along both tangents, or along the first alone, as at a free roller, whose axis that is.
    pub is_isotropic: bool,
}

impl Contact {
    /// In how many directions friction acts.
    pub(crate) fn tangents(&self) -> usize {
        if self.is_isotropic { 2 } else { 1 }
    }
}

/// Contacts of bodies that act on each other. Rows are ordered contact by contact: normal, first and second tangent.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// The velocity that an impulse of 1 N s on a row gives on each row, m/s: symmetric and positive definite. What a contact itself
    /// gives way, as a servo or a spring does, is on the diagonal.
    pub response: DMatrix<f64>,
    /// The velocity that is missing on each row without impulses, m/s: to the least normal velocity that is allowed, and to no slip.
    pub missing: DVector<f64>,
    /// The contacts.
    pub contacts: Vec<Contact>,
}

/// By how much an answer misses, at the contact where it misses most; relative to the greatest velocity that was missing.
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
    /// The velocity that an impulse of 1 N s along a tangent of a contact gives there, m/s: of the tangent that gives way less.
    pub(crate) fn tangent_response(&self, contact: usize) -> f64 {
        let tangents = 1..=self.contacts[contact].tangents();
        let own = |tangent| self.response[(contact * ROWS + tangent, contact * ROWS + tangent)];
        tangents.map(own).fold(f64::INFINITY, f64::min)
    }

    /// What velocities are measured by: the greatest that is missing, m/s.
    pub fn scale(&self) -> f64 {
        self.missing.amax().max(f64::MIN_POSITIVE)
    }

    /// How well impulses solve it, N s.
    pub fn residual(&self, impulses: &DVector<f64>) -> Residual {
        let velocity = &self.response * impulses - &self.missing;
        let scale = self.scale();
        let mut worst = Residual::default();
        for (number, contact) in self.contacts.iter().enumerate() {
            let row = number * ROWS;
            // An impulse in terms of the velocity that it gives its own contact.
            let own = self.response[(row, row)];
            let (pushed, gap) = (impulses[row] * own, velocity[row]);
            // Complementarity: the one that is not positive is to be 0.
            worst.normal = worst.normal.max(pushed.min(gap).abs() / scale);
            let own = self.tangent_response(number);
            let tangents = contact.tangents();
            let part = |of: &DVector<f64>| {
                Vector2::from_fn(|tangent, _| if tangent < tangents { of[row + 1 + tangent] } else { 0.0 })
            };
            let (push, slip) = (part(impulses), part(&velocity));
            // The impulse is the point of its disc nearest to itself less the slip (De Saxcé's projection).
            let most = contact.friction * impulses[row].max(0.0);
            let wanted = push - slip / own;
            let wanted = if wanted.norm() > most { wanted * (most / wanted.norm()) } else { wanted };
            worst.tangent = worst.tangent.max((push - wanted).norm() * own / scale);
        }
        worst
    }
}
