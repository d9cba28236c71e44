//! Linear least squares of a few numbers, with intervals.

use nalgebra::{SMatrix, SVector};

/// Sums of the normal equations.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit<const N: usize> {
    squares: SMatrix<f64, N, N>,
    products: SVector<f64, N>,
    measured: f64,
    rows: usize,
}

/// The numbers and their covariance.
pub(super) struct Solution<const N: usize> {
    pub(super) values: SVector<f64, N>,
    /// Covariance if what was measured has a variance of 1.
    pub(super) covariance: SMatrix<f64, N, N>,
    /// Standard deviation of what the numbers leave.
    pub(super) deviation: f64,
    /// Rows beyond the numbers.
    freedom: f64,
}

impl<const N: usize> Fit<N> {
    pub(super) fn new() -> Self {
        Self { squares: SMatrix::zeros(), products: SVector::zeros(), measured: 0.0, rows: 0 }
    }

    /// Adds a row: what each number contributes for a value of 1, and what was measured.
    pub(super) fn add(&mut self, parts: [f64; N], measured: f64) {
        let parts = SVector::from(parts);
        self.squares += parts * parts.transpose();
        self.products += parts * measured;
        self.measured += measured * measured;
        self.rows += 1;
    }

    /// Solves for the numbers. One without any part is 0 and has no interval.
    pub(super) fn solve(&self) -> Solution<N> {
        let told = self.squares.diagonal().map(|square| square > 0.0);
        // A number without parts is taken out; the others' rows stay as they are.
        let filled: SMatrix<f64, N, N> =
            SMatrix::from_fn(|row, column| if row == column && !told[row] { 1.0 } else { self.squares[(row, column)] });
        let inverse = filled.try_inverse().unwrap_or_else(|| SMatrix::from_element(f64::INFINITY));
        let values = inverse * self.products;
        let freedom = self.rows.saturating_sub(told.iter().filter(|&&it| it).count()).max(1) as f64;
        let left = (self.measured - values.dot(&self.products)).max(0.0);
        let deviation = (left / freedom).sqrt();
        Solution { values, covariance: inverse, deviation, freedom }
    }
}

impl<const N: usize> Solution<N> {
    /// Returns a number and half of its 95 % interval, infinite if the rows do not tell it.
    pub(super) fn number(&self, number: usize) -> [f64; 2] {
        // Student's quantile for 97.5 %, within 1 % from 4 degrees of freedom on.
        let quantile = 1.96 + 2.37 / self.freedom + 2.8 / (self.freedom * self.freedom);
        let (value, variance) = (self.values[number], self.covariance[(number, number)] * self.deviation.powi(2));
        let is_told = value != 0.0 && value.is_finite();
        [value, if is_told { quantile * variance.sqrt() } else { f64::INFINITY }]
    }
}
