//! A self-contained page of the results of experiments.

use std::path::{Path, PathBuf};

use maud::{DOCTYPE, Markup, PreEscaped, html};
use names::count;

use crate::batch::{BatchError, refused, write};
use crate::claim::Claim;
use crate::plan::Plan;
use crate::run::Outcome;
use crate::table;

/// Drive models that claims are compared with.
const MODELS: [&str; 3] = ["bodies", "analytic", "kinematic"];

/// Most lines of a table that is shown unasked.
const MAX_OPEN: usize = 50;

const STYLE: &str = "
body { font: 16px/1.5 system-ui, sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; color: #222 }
h1, h2 { line-height: 1.2 } h2 { margin-top: 2.5rem }
table { border-collapse: collapse; width: 100%; font-size: 0.9rem }
th, td { text-align: left; vertical-align: top; padding: 0.35rem 0.6rem; border-bottom: 1px solid #ddd }
td.number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums }
.agrees { color: #00664b } .differs { color: #a33b00 } .thesis { color: #7a3f6b } .noted { color: #555 }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(30rem, 1fr)); gap: 1rem }
figure { margin: 0 } figure svg { width: 100%; height: auto }
code { background: #f3f3f3; padding: 0 0.2rem }
";

/// Writes `steps.csv`, `runs.csv`, `summary.csv`, every plot and `report.html`. Returns the number of plots.
///
/// # Errors
/// When a file cannot be written.
pub fn write_all(
    folder: &Path,
    title: &str,
    plans: &[Plan],
    claims: &[Claim],
    outcomes: &[Outcome],
) -> Result<usize, BatchError> {
    write(&folder.join("steps.csv"), table::steps(outcomes).as_bytes())?;
    write(&folder.join("runs.csv"), table::runs(outcomes).as_bytes())?;
    write(&folder.join("summary.csv"), table::summary(outcomes).as_bytes())?;
    let plots = folder.join("plots");
    std::fs::create_dir_all(&plots).map_err(|error| refused(&plots, error))?;
    let mut figures = Vec::new();
    for plan in plans {
        let own: Vec<Outcome> = outcomes.iter().filter(|it| it.experiment() == plan.name).cloned().collect();
        for plot in plan.shown_plots() {
            if plot.draw(&own, &plots)? {
                let file = plots.join(format!("{}.svg", plot.name));
                let svg = std::fs::read_to_string(&file).map_err(|error| refused(&file, error))?;
                figures.push((plot.name.clone(), plot.title.clone(), svg));
            }
        }
    }
    // Figures of the thesis in its order, 7.2 before 7.10, then appendices, then others in the order of the plans.
    figures.sort_by_key(|(name, _, _)| number(name));
    let has_logs = folder.join("logs").is_dir();
    let page = page(title, plans, claims, outcomes, &figures, has_logs).into_string();
    write(&folder.join("report.html"), page.as_bytes())?;
    Ok(figures.len())
}

/// Returns the files that [`write_all`] writes.
pub fn files(folder: &Path, plans: &[Plan]) -> Vec<PathBuf> {
    let tables = ["steps.csv", "runs.csv", "summary.csv", "report.html"].map(|name| folder.join(name));
    let plots = plans.iter().flat_map(Plan::shown_plots);
    tables.into_iter().chain(plots.flat_map(|plot| plot.files(&folder.join("plots")))).collect()
}

/// Returns the sort key of a figure: chapter, then number.
fn number(name: &str) -> (String, u32) {
    let parts = name.split_once('.').and_then(|(chapter, number)| Some((chapter.to_owned(), number.parse().ok()?)));
    parts.filter(|(chapter, _)| chapter.len() == 1).unwrap_or(("~".to_owned(), 0))
}

fn page(
    title: &str,
    plans: &[Plan],
    claims: &[Claim],
    outcomes: &[Outcome],
    figures: &[(String, String, String)],
    has_logs: bool,
) -> Markup {
    let (runs, experiments) = (count(outcomes.len(), "run"), count(plans.len(), "experiment"));
    let left_out =
        plans.iter().map(Plan::count).sum::<usize>().saturating_sub(plans.iter().map(|it| it.runs().len()).sum());
    let body = html! {
        p {
            (runs) " of usarsim " (env!("CARGO_PKG_VERSION")) ", " (experiments) ". Every step of every run is in "
            code { "steps.csv" } ", the runs with their seeds in " code { "runs.csv" } ", their means in " code { "summary.csv" }
            @if has_logs { ", and a log of each under " code { "logs" } } "."
        }
        @if left_out > 0 {
            p {
                "Left out: " (count(left_out, "run")) " that no figure or claim needs. Each setting has one sample, but where a figure or claim \
                 is about samples; " code { "--full" } " does all of them."
            }
        }
        @if !claims.is_empty() { (claim_table(claims, outcomes)) }
        @if !figures.is_empty() { (figure_chapter(figures, !claims.is_empty())) }
        h2 { "Experiments" }
        table {
            tr { th { "name" } th { "what" } th { "runs" } th { "samples differ by" } }
            @for plan in plans {
                tr {
                    td { (plan.name) }
                    td { (plan.description) }
                    td.number { (plan.runs().len()) }
                    td { (differences(plan)) }
                }
            }
        }
        (summary_table(outcomes))
    };
    document(title, &body)
}

/// Returns a page with a title.
pub(crate) fn document(title: &str, body: &Markup) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                (body)
            }
        }
    }
}

fn figure_chapter(figures: &[(String, String, String)], has_claims: bool) -> Markup {
    html! {
        h2 { "Figures" }
        p {
            "Drawn from the runs of this folder. "
            @if has_claims { "Dashed are the thesis's numbers where its text has them; its own data are lost. " }
            "Lines join measured steps and are no measurements between them."
        }
        div.figures {
            @for (name, title, svg) in figures {
                figure id=(name) aria-label=(title) { (PreEscaped(svg)) }
            }
        }
    }
}

fn claim_table(claims: &[Claim], outcomes: &[Outcome]) -> Markup {
    let text = |number: Option<f64>| number.map_or("–".to_owned(), |number| format!("{number:.2}"));
    html! {
        h2 { "What the thesis says, and what was found" }
        p {
            "Nothing was tuned to agree. A verdict is that of " code { "bodies" } ", the reference: chassis, wheels and 24 rollers as bodies."
        }
        table {
            tr {
                th { "line" } th { "claim" } th { "thesis" }
                @for model in MODELS { th { (model) } }
                th { "unit" } th { "verdict" }
            }
            @for claim in claims {
                @let verdict = claim.verdict(outcomes);
                tr {
                    td { (claim.line) }
                    td { (claim.text) }
                    td.number { @if claim.words.is_some() { "in words" } @else { (text(claim.number)) } }
                    @for model in MODELS { td.number { (text(claim.found(outcomes, model))) } }
                    td { (claim.unit) }
                    td { strong class=(verdict.word().split(' ').next().unwrap_or_default()) { (verdict.word()) } ". " (claim.sentence(verdict)) }
                }
            }
        }
    }
}

fn summary_table(outcomes: &[Outcome]) -> Markup {
    let summary = table::summary(outcomes);
    let mut rows = summary.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = rows.next().unwrap_or_default();
    let is_short = summary.lines().count() <= MAX_OPEN;
    html! {
        h2 { "Means of all settings" }
        p { "After the last step, in metres and radians; sd is the standard deviation of the samples." }
        details open[is_short] {
            summary { "Show the table" }
            table {
                tr { @for name in &head { th { (name) } } }
                @for row in rows {
                    tr { @for cell in &row { @if cell.parse::<f64>().is_ok() { td.number { (cell) } } @else { td { (cell) } } } }
                }
            }
        }
    }
}

/// Describes the variation between the samples of an experiment.
fn differences(plan: &Plan) -> String {
    let it = plan.tolerances;
    let parts = [
        (it.position, format!("place ±{} mm", 1e3 * it.position)),
        (it.yaw, format!("heading ±{:.1}°", it.yaw.to_degrees())),
        (it.wheel_phase, format!("wheel phase ±{:.0}°", it.wheel_phase.to_degrees())),
        (it.friction, format!("friction ±{} %", 100.0 * it.friction)),
        (it.mass, format!("mass ±{} %", 100.0 * it.mass)),
    ];
    let parts: Vec<String> = parts.into_iter().filter(|(size, _)| *size > 0.0).map(|(_, text)| text).collect();
    if parts.is_empty() { "nothing".to_owned() } else { parts.join(", ") }
}
