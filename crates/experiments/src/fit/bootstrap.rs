//! Confidence intervals of the fitted values.

use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::measured::Measured;
use super::search::Search;
use super::{Fit, FitError, mean, parts};
use crate::run::Step;

/// Half width of the difference for a derivative, as a fraction of the range.
const DIFFERENCE: f64 = 0.02;
/// Number of resampled sets of measurements.
const RESAMPLES: usize = 2000;
/// Least number of blocks for drawing whole runs; with fewer runs, steps are drawn.
const LEAST_BLOCKS: usize = 8;

/// Result of resampling the measurements.
pub(super) struct Bootstrap {
    /// Intervals of the active parameters.
    pub(super) intervals: Vec<[f64; 2]>,
    pub(super) correlation: DMatrix<f64>,
    pub(super) resampled: &'static str,
}

/// Estimates how the result varies over other measurements of the same kind. It draws the measured runs or steps, and the samples
/// of the simulation, again with replacement. For each draw it solves the least squares with the derivatives at the best values.
pub(super) fn bootstrap<P: Fn(f64) -> ControlFlow<()> + Sync>(
    fit: &Fit,
    search: &Search<P>,
    best: &[f64],
    active: &[usize],
) -> Result<Bootstrap, FitError> {
    let count = active.len();
    let mut slopes = DMatrix::zeros(3 * fit.measured.len(), count);
    for (column, &index) in active.iter().enumerate() {
        let [least, greatest] = fit.parameters[index].range;
        let at = |value: f64| {
            let mut values = best.to_vec();
            values[index] = value.clamp(least, greatest);
            search.predict(&values).map(|steps| (values[index], steps))
        };
        let (low, below) = at(best[index] - DIFFERENCE * (greatest - least))?;
        let (high, above) = at(best[index] + DIFFERENCE * (greatest - least))?;
        for (row, (below, above)) in below.iter().zip(&above).enumerate() {
            for (part, (below, above)) in parts(below).iter().zip(parts(above)).enumerate() {
                slopes[(3 * row + part, column)] = (above - below) / (high - low);
            }
        }
    }
    let blocks = fit.measured.iter().map(|measured| measured.block).max().map_or(0, |last| last + 1);
    let by_run = blocks >= LEAST_BLOCKS;
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); if by_run { blocks } else { fit.measured.len() }];
    fit.measured.iter().enumerate().for_each(|(row, m)| members[if by_run { m.block } else { row }].push(row));
    let samples = search.simulate(best)?;
    let mut draw = ChaCha8Rng::seed_from_u64(fit.seed);
    let mut drawn: Vec<Vec<f64>> = vec![Vec::with_capacity(RESAMPLES); count];
    for _ in 0..RESAMPLES {
        // The simulation's samples are as random as the measured runs.
        let simulated: Vec<Vec<Step>> = samples
            .iter()
            .map(|samples| mean((0..samples.len()).map(|_| &samples[draw.random_range(0..samples.len())])))
            .collect();
        let (mut matrix, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
        for _ in 0..members.len() {
            for &row in &members[draw.random_range(0..members.len())] {
                let Measured { setting, step, travel, .. } = &fit.measured[row];
                let slope = slopes.rows(3 * row, 3);
                let missing = parts(travel).into_iter().zip(parts(&simulated[*setting][*step])).map(|(m, p)| m - p);
                matrix += slope.transpose() * slope;
                right += slope.transpose() * DVector::from_iterator(3, missing);
            }
        }
        let Ok(change) = matrix.svd(true, true).solve(&right, 1e-12) else { continue };
        for (place, &index) in active.iter().enumerate() {
            let [least, greatest] = fit.parameters[index].range;
            drawn[place].push((best[index] + change[place]).clamp(least, greatest));
        }
    }
    let few = samples.iter().map(Vec::len).filter(|&count| count > 1).chain([members.len()]).min().unwrap_or(1);
    let wider = small_sample_factor(few);
    let intervals = drawn.iter_mut().zip(active).map(|(values, &index)| {
        values.sort_by(f64::total_cmp);
        let at = |part: f64| values.get((part * (values.len() as f64 - 1.0)).round() as usize).copied();
        let [least, greatest] = fit.parameters[index].range;
        [at(0.025), at(0.975)]
            .map(|end| (best[index] + wider * (end.unwrap_or(f64::NAN) - best[index])).clamp(least, greatest))
    });
    let intervals = intervals.collect();
    // The correlation is that of the inverse of the normal matrix. Its columns are scaled to one size first.
    let sizes: Vec<f64> = slopes.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
    let scaled = DMatrix::from_fn(slopes.nrows(), count, |row, column| slopes[(row, column)] / sizes[column]);
    let inverse = (scaled.transpose() * scaled + DMatrix::identity(count, count) * 1e-9).try_inverse();
    let inverse = inverse.unwrap_or_else(|| DMatrix::identity(count, count));
    let correlation = DMatrix::from_fn(count, count, |row, column| {
        inverse[(row, column)] / (inverse[(row, row)] * inverse[(column, column)]).sqrt()
    });
    Ok(Bootstrap { intervals, correlation, resampled: if by_run { "runs" } else { "steps" } })
}

/// Returns the factor that widens a 95 % interval drawn from few items. Draws scatter by too little, and their scatter is itself
/// uncertain (Hesterberg, "What teachers should know about the bootstrap", 2015, section 4.3; Student's t by its expansion in 1 /
/// n).
fn small_sample_factor(count: usize) -> f64 {
    const NORMAL: f64 = 1.959964;
    let freedom = (count.max(3) - 1) as f64;
    let (cube, fifth) = (NORMAL.powi(3), NORMAL.powi(5));
    let student = NORMAL
        + (cube + NORMAL) / (4.0 * freedom)
        + (5.0 * fifth + 16.0 * cube + 3.0 * NORMAL) / (96.0 * freedom * freedom);
    student / NORMAL * ((freedom + 1.0) / freedom).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_of_few_samples_are_wider_as_student_says() {
        // Quantiles of Student's t at 97.5 % over the normal one, times sqrt(n / (n - 1)).
        for (count, expected) in [(6, 2.571 / 1.96 * 1.0954), (11, 2.228 / 1.96 * 1.0488), (101, 1.984 / 1.96 * 1.005)]
        {
            let factor = small_sample_factor(count);
            assert!((factor - expected).abs() < 0.02 * expected, "{count}: {factor}, expected {expected}");
        }
    }
}
