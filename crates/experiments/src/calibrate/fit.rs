//! Linear least squares of two numbers, with intervals. With one number the other's parts are 0.

use nalgebra::{Matrix2, Vector2};

/// Sums of the normal equations.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Fit {
    squares: Matrix2<f64>,
    products: Vector2<f64>,
    measured: f64,
    rows: usize,
}

/// The numbers and their covariance.
pub(super) struct Solution {
    values: Vector2<f64>,
    covariance: Matrix2<f64>,
    /// Standard deviation of what the numbers leave.
    pub(super) deviation: f64,
    /// Rows beyond the numbers.
    freedom: f64,
}

impl Fit {
    /// Adds a row: what each number contributes for a value of 1, and what was measured.
    pub(super) fn add(&mut self, parts: [f64; 2], measured: f64) {
        let parts = Vector2::from(parts);
        self.squares += parts * parts.transpose();
        self.products += parts * measured;
        self.measured += measured * measured;
        self.rows += 1;
    }

    /// Solves for the numbers. One without any part is 0 and has no interval.
    pub(super) fn solve(&self) -> Solution {
        let told = self.squares.diagonal().map(|square| square > 0.0);
        // A number without parts is taken out; the others' rows stay as they are.
        let filled =
            Matrix2::from_fn(|row, column| if row == column && !told[row] { 1.0 } else { self.squares[(row, column)] });
        let inverse = filled.try_inverse().unwrap_or_else(|| Matrix2::from_element(f64::INFINITY));
        let values = inverse * self.products;
        let freedom = self.rows.saturating_sub(told.iter().filter(|&&it| it).count()).max(1) as f64;
        let left = (self.measured - values.dot(&self.products)).max(0.0);
        let deviation = (left / freedom).sqrt();
        Solution { values, covariance: inverse * (deviation * deviation), deviation, freedom }
    }
}

impl Solution {
    /// Returns a number and half of its 95 % interval, infinite if the rows do not tell it.
    pub(super) fn number(&self, number: usize) -> [f64; 2] {
        // Student's quantile for 97.5 %, within 1 % from 4 degrees of freedom on.
        let quantile = 1.96 + 2.37 / self.freedom + 2.8 / (self.freedom * self.freedom);
        let (value, variance) = (self.values[number], self.covariance[(number, number)]);
        let is_told = value != 0.0 && value.is_finite();
        [value, if is_told { quantile * variance.sqrt() } else { f64::INFINITY }]
    }
}
