//! Table of measured steps.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::plan::Run;
use crate::run::Step;

/// One measured step of a run.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Measured {
    /// Index into `Fit::settings`.
    pub(super) setting: usize,
    /// Index of the repetition of the run, as a block of the bootstrap.
    pub(super) block: usize,
    /// Number of the step, from 0.
    pub(super) step: usize,
    pub(super) travel: Step,
}

/// Reads the measured runs and their steps from a table `run,step,main,error,yaw`. A run is named by the values of its axes, or as
/// in the steps.csv of an experiment.
pub(super) fn measurements(
    text: &str,
    names: &[Run],
    runs: Vec<Run>,
) -> Result<(Vec<Vec<Run>>, Vec<Measured>), String> {
    #[derive(Deserialize)]
    struct Row {
        run: String,
        step: usize,
        main: f64,
        error: f64,
        yaw: f64,
    }
    let setting = |run: &Run| {
        let axes = run.labels.iter().filter(|(name, _)| name != "model" && name != "sample");
        let values = axes.map(|(_, value)| value.as_str()).collect::<Vec<_>>().join(" ");
        // An experiment without axes is named by itself.
        if values.is_empty() { run.id.split('/').next().unwrap_or_default().to_owned() } else { values }
    };
    let mut kept: Vec<Vec<Run>> = Vec::new();
    let mut measured: Vec<Measured> = Vec::new();
    // Number of times that each step of a run appeared, and the block of each repetition.
    let mut repeated: BTreeMap<(String, usize), usize> = BTreeMap::new();
    let mut blocks: BTreeMap<(String, usize), usize> = BTreeMap::new();
    for row in csv::Reader::from_reader(text.as_bytes()).deserialize() {
        let Row { run: name, step, main, error, yaw } = row.map_err(|error: csv::Error| error.to_string())?;
        let wrong = |what: String| format!("run `{name}`, step {step}: {what}");
        // In a steps.csv the sample is the last part; the table may have more samples than the simulation.
        let stem = |id: &str| id.rsplit_once('-').map(|(stem, _)| stem.to_owned());
        let same = |run: &&Run| run.id == name || stem(&run.id).is_some_and(|of| stem(&name) == Some(of));
        let wanted = names.iter().find(same).map_or_else(|| name.clone(), setting);
        let Some(run) = runs.iter().find(|run| setting(run) == wanted) else {
            let mut known: Vec<String> = runs.iter().map(setting).collect();
            known.dedup();
            return Err(wrong(format!("the experiment has no such run: expected one of {}", known.join(", "))));
        };
        if step == 0 || step > run.setup.steps() as usize {
            return Err(wrong(format!("expected a step from 1 to {}", run.setup.steps())));
        }
        if ![main, error, yaw].iter().all(|number| number.is_finite()) {
            return Err(wrong("a number is not finite".to_owned()));
        }
        let index = kept.iter().position(|samples| samples[0].id == run.id).unwrap_or_else(|| {
            let same = |other: &&Run| setting(other) == wanted && other.drive_model == run.drive_model;
            kept.push(runs.iter().filter(same).cloned().collect());
            kept.len() - 1
        });
        let times = repeated.entry((name.clone(), step)).or_default();
        let new = blocks.len();
        let block = *blocks.entry((name, *times)).or_insert(new);
        *times += 1;
        measured.push(Measured { setting: index, block, step: step - 1, travel: Step { main, error, yaw } });
    }
    if measured.is_empty() {
        return Err("expected a table `run,step,main,error,yaw`, m and rad, with at least one step".to_owned());
    }
    Ok((kept, measured))
}
