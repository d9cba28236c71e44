//! `usarsim experiment`: runs the thesis's experiments, or one's own.

mod socket;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use experiments::batch::{Batch, BatchError};
use experiments::claim::{Claim, Claims};
use experiments::fit::{Estimate, Fit, FitError, FitResult};
use experiments::plan::Plan;
use experiments::real::{self, Compared, Measured};
use experiments::run::{self, Outcome, RunError};
use experiments::{report, thesis};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use scene::DriveModel;
use serde_json::json;

use crate::output::keep_inputs;
use crate::progress::Progress;
use crate::values::within;
use crate::{Failure, exit, print};

/// Subcommands of `experiment`.
#[derive(clap::Subcommand)]
pub(crate) enum Command {
    /// Run chapter 7 of the thesis "A KUKA youBot simulation in USARSim": every experiment, every figure, every claim.
    Thesis(ThesisArguments),
    /// Put published measurements of real robots beside their simulations.
    Real(RealArguments),
    /// Run your own experiment from a file.
    Run(RunArguments),
    /// Fit parameters of a robot so that simulated steps match measured ones.
    Fit(FitArguments),
}

/// Options of `experiment thesis`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  usarsim experiment thesis\n  usarsim experiment thesis --full\n  \
    usarsim experiment thesis --only forward,friction --out quick\n  \
    usarsim experiment thesis --drive-model analytic --jobs 2 --json\n\nShows every figure and checks every claim with one sample of each \
    setting, and with all where a figure or claim is about samples. --full does all of them, and keeps runs that are done. Open report.html in \
    the folder when it is done. Call it again to resume an interrupted run. The experiments are the files under experiments/thesis.")]
pub(crate) struct ThesisArguments {
    /// Only these experiments, by name.
    #[arg(long, value_delimiter = ',', value_name = "NAME,..")]
    only: Vec<String>,
    /// Do all runs, instead of those that every figure and claim needs at least.
    #[arg(long)]
    full: bool,
    #[command(flatten)]
    common: Common,
}

/// Options of `experiment real`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  usarsim experiment real\n  usarsim experiment real --only pioneer-3-at,warthog --out real\n  \
    usarsim experiment real my-robot.toml --json\n\nWithout a file it does the project's, under experiments/real. What a file holds: \
    docs/real-robots.md."
)]
pub(crate) struct RealArguments {
    /// Files of measurements instead of the project's.
    #[arg(value_name = "FILE.toml", conflicts_with = "only")]
    files: Vec<PathBuf>,
    /// Only these of the project's robots, by the names of their files.
    #[arg(long, value_delimiter = ',', value_name = "NAME,..")]
    only: Vec<String>,
    /// Folder for report.html, rows.csv and plots; without it no file is written.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the rows as JSON.
    #[arg(long)]
    json: bool,
}

/// Options of `experiment run`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  usarsim experiment run my.toml\n  usarsim experiment run my.toml --out results --jobs 1\n\n\
    What a file holds: docs/experiments.md; examples are under experiments/thesis."
)]
pub(crate) struct RunArguments {
    /// The experiment.
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    #[command(flatten)]
    common: Common,
}

/// Options of `experiment fit`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  usarsim experiment fit my-robot.toml\n  usarsim experiment fit my-robot.toml --drive-model analytic --json\n\n\
    What the file and the table of measured steps hold: docs/experiments.md."
)]
pub(crate) struct FitArguments {
    /// The fit.
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    /// The drive model; by default the experiment's first.
    #[arg(long, value_name = "MODEL")]
    drive_model: Option<DriveModel>,
    /// Folder for fit.json and a picture of each parameter; without it no file is written.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Runs at a time; by default as many as there are cores.
    #[arg(long)]
    jobs: Option<usize>,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(clap::Args)]
struct Common {
    /// Folder of the results; by default the experiment's name.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Only with these drive models.
    #[arg(long, value_delimiter = ',', value_name = "MODEL,..")]
    drive_model: Vec<DriveModel>,
    /// Runs at a time; by default as many as there are cores.
    #[arg(long)]
    jobs: Option<usize>,
    /// Drive through a server's socket at this real-time factor, as a controller does, instead of in this process. Poses then have
    /// the wire's resolution of a millimetre, and lines arrive when the network delivers them.
    #[arg(long, value_name = "RTF", value_parser = real_time_factor)]
    socket: Option<f64>,
    /// Print a summary as JSON.
    #[arg(long)]
    json: bool,
}

/// Parses a real-time factor that a client can keep up with.
fn real_time_factor(text: &str) -> Result<f64, String> {
    within(text, 0.01, 100.0)
}

pub(crate) fn run(command: &Command, quiet: bool) -> Result<(), Failure> {
    match command {
        Command::Thesis(arguments) => {
            let all = thesis::files();
            let name = |file: &str| file.trim_end_matches(".toml").to_owned();
            if let Some(unknown) = arguments.only.iter().find(|only| !all.iter().any(|(file, _)| name(file) == **only))
            {
                let names: Vec<String> = all.iter().map(|(file, _)| name(file)).collect();
                let message = format!("unknown experiment `{unknown}`: expected some of {}", names.join(", "));
                return Err(Failure::new(exit::USAGE, message));
            }
            let only = |file: &str| arguments.only.is_empty() || arguments.only.contains(&name(file));
            let files =
                all.into_iter().filter(|(file, _)| only(file)).map(|(file, text)| (file.into(), text.to_owned()));
            let claims: Claims = toml::from_str(thesis::claims())
                .map_err(|error| Failure::new(exit::FAILURE, format_args!("claims.toml: {error}")))?;
            let claims = &claims.claims;
            let narrow = |plan: &mut Plan| {
                if !arguments.full {
                    thesis::keep_needed(plan, claims);
                }
            };
            let task = Task { files: files.collect(), title: "The thesis, reproduced", folder: "thesis", claims };
            conduct(task, narrow, &arguments.common, quiet)
        }
        Command::Fit(arguments) => fit(arguments, quiet),
        Command::Real(arguments) => real(arguments, quiet),
        Command::Run(RunArguments { file, common }) => {
            let text = scene_loader::text(file).map_err(|error| Failure::new(exit::BAD_CONFIGURATION, error))?;
            let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let task = Task { files: vec![(file.clone(), text)], title: &name, folder: &name, claims: &[] };
            conduct(task, |_| {}, common, quiet)
        }
    }
}

/// Experiments that are done together.
struct Task<'a> {
    /// Files with their texts.
    files: Vec<(PathBuf, String)>,
    /// Title of the report.
    title: &'a str,
    /// Folder of the results, unless another is given.
    folder: &'a str,
    claims: &'a [Claim],
}

/// Does experiments. `narrow` may leave runs out.
fn conduct(task: Task, narrow: impl Fn(&mut Plan), common: &Common, quiet: bool) -> Result<(), Failure> {
    let Task { files, title, folder, claims } = task;
    let (mut plans, mut inputs) = (Vec::new(), Vec::new());
    for (file, text) in files {
        let mut plan = Plan::read(&file, &text).map_err(|error| Failure::new(exit::BAD_CONFIGURATION, error))?;
        if !common.drive_model.is_empty() {
            plan.keep_models(&common.drive_model);
        }
        narrow(&mut plan);
        if let Some(real_time_factor) = common.socket {
            // Marks the plan, so its results are not mixed with those of runs in this process.
            plan.text.push_str(&format!("\n# through the socket at {real_time_factor} times real time\n"));
        }
        plans.push(plan);
        inputs.push(file);
    }
    let out = common.out.as_deref().unwrap_or(Path::new(folder));
    report::files(out, &plans).iter().try_for_each(|written| keep_inputs(written, &inputs))?;
    let batch = Batch::open(out, &plans).map_err(|error| failure(&error))?;
    let total: usize = plans.iter().map(|plan| plan.runs().len()).sum();
    let left_out = plans.iter().map(Plan::count).sum::<usize>() - total;
    let jobs = jobs(common.jobs);
    let progress = Progress::of_runs(total, quiet);
    let (start, kept) = (Instant::now(), AtomicUsize::new(0));
    let done = |outcome: &Outcome, old: bool| {
        kept.fetch_add(usize::from(old), Ordering::Relaxed);
        progress.say(outcome.id.clone());
        progress.add(1);
    };
    let make = |plan: &Plan, run: &experiments::plan::Run, log: &Path| match common.socket {
        Some(real_time_factor) => socket::run(plan, run, log, real_time_factor),
        None => run::run(plan, run, Some(log)),
    };
    let outcomes = batch.run(jobs, make, done).map_err(|error| failure(&error))?;
    progress.say("tables, plots, report");
    let plots = report::write_all(out, title, &plans, claims, &outcomes).map_err(|error| failure(&error))?;
    progress.finish();
    let (seconds, kept) = (start.elapsed().as_secs_f64(), kept.into_inner());
    let report = out.join("report.html");
    if common.json {
        let verdicts: Vec<_> = claims
            .iter()
            .map(|claim| {
                let verdict = claim.verdict(&outcomes);
                let found = |model| claim.found(&outcomes, model);
                json!({
                    "line": claim.line, "claim": claim.text, "thesis": claim.number, "unit": claim.unit,
                    "bodies": found("bodies"), "analytic": found("analytic"), "kinematic": found("kinematic"),
                    "verdict": verdict.word(), "sentence": claim.sentence(verdict),
                })
            })
            .collect();
        print(json!({
            "runs": total, "left_out": left_out, "kept": kept, "seconds": seconds, "plots": plots,
            "folder": out.display().to_string(), "report": report.display().to_string(), "claims": verdicts,
        }));
    } else {
        print(format_args!(
            "{} ({kept} kept from before), {} in {seconds:.0} s: open {}",
            names::count(total, "run"),
            names::count(plots, "plot"),
            report.display()
        ));
        if left_out > 0 {
            print(format_args!(
                "left out {} that no figure or claim needs: --full does them",
                names::count(left_out, "run")
            ));
        }
    }
    Ok(())
}

/// Creates a spinner on a terminal; hidden if quiet.
fn spinner(quiet: bool) -> ProgressBar {
    let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let style = ProgressStyle::with_template("{spinner} {pos} trials in {elapsed}, {msg}");
    ProgressBar::with_draw_target(None, target).with_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()))
}

fn jobs(given: Option<usize>) -> usize {
    given.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from))
}

fn fit(arguments: &FitArguments, quiet: bool) -> Result<(), Failure> {
    let FitArguments { file, drive_model, out, json, .. } = arguments;
    let refused = |error: FitError| {
        let code = if matches!(error, FitError::Search(_)) { exit::FAILURE } else { exit::BAD_CONFIGURATION };
        Failure::new(code, error)
    };
    let fit = Fit::read(file, *drive_model).map_err(refused)?;
    if let Some(out) = out {
        fit.outputs(out).iter().try_for_each(|written| keep_inputs(written, fit.inputs()))?;
    }
    let bar = spinner(quiet);
    let trial = |distance: f64| {
        bar.set_message(format!("{:.3} mm from the measured steps", 1e3 * distance));
        bar.inc(1);
        ControlFlow::Continue(())
    };
    let found = fit.find(jobs(arguments.jobs), trial).map_err(refused)?;
    bar.finish_and_clear();
    let text = serde_json::to_string_pretty(&found).unwrap_or_default();
    if let Some(out) = out {
        let failed =
            |error: &dyn std::fmt::Display| Failure::new(exit::FAILURE, format_args!("{}: {error}", out.display()));
        std::fs::create_dir_all(out).map_err(|error| failed(&error))?;
        std::fs::write(out.join("fit.json"), &text).map_err(|error| failed(&error))?;
        found.parameters.iter().try_for_each(|parameter| parameter.draw(out)).map_err(|error| failed(&error))?;
    }
    if *json {
        print(text);
        return Ok(());
    }
    let FitResult { distance_before, distance, scatter, caution, steps, simulated, resampled, parameters } = &found;
    print(format_args!("{}: {steps} measured steps, {simulated} runs", fit.name));
    print(format_args!(
        "distance from the measured steps {:.3} mm, {:.3} mm at the start",
        1e3 * distance,
        1e3 * distance_before
    ));
    if let Some(scatter) = scatter {
        print(format_args!("repetitions of a step scatter by {:.3} mm", 1e3 * scatter));
    }
    if let Some(caution) = caution {
        print(format_args!("CAUTION {caution}"));
    }
    for Estimate { name, value, interval: [low, high], caution, .. } in parameters {
        match caution {
            Some(caution) => {
                print(format_args!("{name}: {value:.6}  95 % from {low:.6} to {high:.6}  CAUTION {caution}"))
            }
            None => print(format_args!("{name}: {value:.6}  95 % from {low:.6} to {high:.6} ({resampled} resampled)")),
        }
    }
    Ok(())
}

fn real(arguments: &RealArguments, quiet: bool) -> Result<(), Failure> {
    let RealArguments { files, only, out, json } = arguments;
    let bad = |error: &dyn std::fmt::Display| Failure::new(exit::BAD_CONFIGURATION, error);
    let name = |file: &Path| file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut texts = Vec::new();
    for file in files {
        texts.push((file.clone(), scene_loader::text(file).map_err(|error| bad(&error))?));
    }
    if files.is_empty() {
        texts = real::files().into_iter().map(|(file, text)| (file.into(), text.to_owned())).collect();
        let names: Vec<String> = texts.iter().map(|(file, _)| name(file)).collect();
        if let Some(unknown) = only.iter().find(|only| !names.contains(only)) {
            let message = format!("unknown robot `{unknown}`: expected some of {}", names.join(", "));
            return Err(Failure::new(exit::USAGE, message));
        }
        texts.retain(|(file, _)| only.is_empty() || only.contains(&name(file)));
    }
    let progress = Progress::of_runs(texts.len(), quiet);
    let mut compared = Vec::new();
    for (file, text) in &texts {
        let measured = Measured::read(&file.display().to_string(), text).map_err(|error| bad(&error))?;
        progress.say(measured.name.clone());
        let rows = real::run(&measured).map_err(|error| bad(&format_args!("{}: {error}", file.display())))?;
        compared.push(Compared { id: name(file), measured, rows });
        progress.add(1);
    }
    progress.finish();
    if let Some(out) = out {
        real::report::outputs(out, &compared).iter().try_for_each(|written| keep_inputs(written, files))?;
        real::report::write_all(out, &compared).map_err(|error| failure(&error))?;
    }
    if *json {
        let robots = compared.iter().map(|Compared { id, measured, rows }| {
            json!({ "id": id, "name": measured.name, "source": measured.source, "rows": rows, "others": measured.other })
        });
        print(json!({ "robots": robots.collect::<Vec<_>>() }));
        return Ok(());
    }
    print(real::report::text(&compared).trim_end());
    let rows = compared.iter().flat_map(|it| &it.rows);
    let (agreeing, all) = (rows.clone().filter(|row| row.agrees()).count(), rows.count());
    print(format_args!("{agreeing} of {} agree", names::count(all, "row")));
    Ok(())
}

pub(crate) fn failure(error: &BatchError) -> Failure {
    let code = match error {
        BatchError::Folder { .. } | BatchError::Run(RunError::Load { .. } | RunError::Setup { .. }) => {
            exit::BAD_CONFIGURATION
        }
        BatchError::File { .. } | BatchError::Plot(_) | BatchError::Run(RunError::Log(_)) => exit::FAILURE,
    };
    Failure::new(code, error)
}
