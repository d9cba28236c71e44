//! Tables of outcomes, as CSV in metres and radians.

use std::fmt::Write;

use crate::plot::Quantity;
use crate::run::Outcome;

/// Returns the table `run,step,main,error,yaw`: every step in the frame of the robot at its start.
pub fn steps(outcomes: &[Outcome]) -> String {
    let mut table = "run,step,main,error,yaw\n".to_owned();
    for outcome in outcomes {
        for (number, step) in (1..).zip(&outcome.steps) {
            let _ = writeln!(table, "{},{number},{:.6},{:.6},{:.6}", outcome.id, step.main, step.error, step.yaw);
        }
    }
    table
}

/// Returns a table with one line per run: its setting, its result, and the digest of its world.
pub fn runs(outcomes: &[Outcome]) -> String {
    let mut table = "run,setting,model,sample,seed,main,error,yaw,wheels_turned,seconds,digest\n".to_owned();
    for outcome in outcomes {
        let of = |quantity: Quantity| quantity.of(outcome, usize::MAX);
        let label = |name| outcome.label(name).unwrap_or_default();
        let (main, error, yaw) = (of(Quantity::Main), of(Quantity::Error), of(Quantity::Yaw));
        let Outcome { id, seed, wheels_turned, seconds, digest, .. } = outcome;
        let (setting, model, sample) = (setting(outcome), label("model"), label("sample"));
        let _ = writeln!(
            table,
            "{id},{setting},{model},{sample},{seed},{main:.6},{error:.6},{yaw:.6},{wheels_turned:.6},{seconds:.3},{digest}"
        );
    }
    table
}

/// Returns a table with one line per setting: means and standard deviations of its samples after the last step.
pub fn summary(outcomes: &[Outcome]) -> String {
    let mut table =
        "experiment,setting,model,samples,main,main_sd,error,error_sd,yaw,yaw_sd,step_main,step_error\n".to_owned();
    let same = |a: &Outcome, b: &Outcome| key(a) == key(b);
    for group in outcomes.chunk_by(same) {
        let Some(first) = group.first() else { continue };
        let of = |quantity: Quantity| mean_and_deviation(group.iter().map(|outcome| quantity.of(outcome, usize::MAX)));
        let _ = write!(
            table,
            "{},{},{},{}",
            first.experiment(),
            setting(first),
            first.label("model").unwrap_or_default(),
            group.len()
        );
        for quantity in [Quantity::Main, Quantity::Error, Quantity::Yaw] {
            let (mean, deviation) = of(quantity);
            let _ = write!(table, ",{mean:.6},{deviation:.6}");
        }
        let _ = writeln!(table, ",{:.6},{:.6}", of(Quantity::StepMain).0, of(Quantity::StepError).0);
    }
    table
}

/// Returns everything that identifies a run, except its sample.
fn key(outcome: &Outcome) -> (&str, Vec<&(String, String)>) {
    (outcome.experiment(), outcome.labels.iter().filter(|(name, _)| name != "sample").collect())
}

/// Returns the values of the axes, such as `move=forward map=rough`.
fn setting(outcome: &Outcome) -> String {
    let axes = outcome.labels.iter().filter(|(name, _)| name != "sample" && name != "model");
    axes.map(|(name, value)| format!("{name}={}", value.replace([',', '"'], "_"))).collect::<Vec<_>>().join(" ")
}

/// Returns the mean and the standard deviation (of a sample: over n - 1).
pub fn mean_and_deviation(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let values: Vec<f64> = values.collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    (mean, if values.len() > 1 { (square / (count - 1.0)).sqrt() } else { 0.0 })
}
