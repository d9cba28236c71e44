//! The table, plots and page of real robots beside their simulations.

use std::path::{Path, PathBuf};

use charts::{Chart, Series};
use maud::{Markup, PreEscaped, html};

use super::{Compared, Row};
use crate::batch::{BatchError, refused, write};
use crate::report::document;

/// Returns the table of all rows as text.
pub fn text(compared: &[Compared]) -> String {
    let mut text = String::new();
    for Compared { measured, rows, .. } in compared {
        text += &format!("{}\n", measured.name);
        for row in rows {
            let what = &row.what;
            let spread = row.spread.map_or(String::new(), |spread| format!(" +- {spread:.4}"));
            let (real, ours, percent) = (format!("{:.4}{spread}", row.real), row.ours, row.percent());
            text += &format!("  {what:50} real {real:17}  here {ours:.4}  {percent:+5.1} %  {}\n", row.verdict());
        }
        for other in &measured.other {
            let (simulator, source) = (&other.simulator, &other.source);
            text += &format!(
                "  {:50} needs {:.2} for this turn ({source})\n",
                format!("{simulator}, by a user"),
                other.chi
            );
        }
    }
    text
}

/// Returns the files that [`write_all`] writes.
pub fn outputs(folder: &Path, compared: &[Compared]) -> Vec<PathBuf> {
    let plots = compared.iter().filter(|it| it.measured.turn.len() > 1).map(|it| plot_file(folder, it));
    ["report.html", "rows.csv"].map(|name| folder.join(name)).into_iter().chain(plots).collect()
}

/// Writes `report.html`, `rows.csv` and a plot of each robot with several curvatures.
///
/// # Errors
/// When a file cannot be written.
pub fn write_all(folder: &Path, compared: &[Compared]) -> Result<(), BatchError> {
    let mut figures = Vec::new();
    for robot in compared.iter().filter(|it| it.measured.turn.len() > 1) {
        let svg = chart(robot).to_svg().map_err(BatchError::Plot)?;
        write(&plot_file(folder, robot), svg.as_bytes())?;
        figures.push(svg);
    }
    let table = folder.join("rows.csv");
    write(&table, &csv(compared).map_err(|error| refused(&table, error))?)?;
    write(&folder.join("report.html"), page(compared, &figures).into_string().as_bytes())
}

fn plot_file(folder: &Path, robot: &Compared) -> PathBuf {
    folder.join(format!("{}.svg", robot.id))
}

fn csv(compared: &[Compared]) -> Result<Vec<u8>, String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let head = ["robot", "what", "curvature", "real", "spread", "within", "here", "verdict"];
    writer.write_record(head).map_err(|error| error.to_string())?;
    for (robot, row) in compared.iter().flat_map(|it| it.rows.iter().map(move |row| (it, row))) {
        let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let (real, within, ours) = (row.real.to_string(), row.within.to_string(), row.ours.to_string());
        let (name, verdict) = (robot.measured.name.clone(), row.verdict().to_owned());
        let record = [name, row.what.clone(), number(row.curvature), real, number(row.spread), within, ours, verdict];
        writer.write_record(&record).map_err(|error| error.to_string())?;
    }
    writer.into_inner().map_err(|error| error.to_string())
}

/// Draws the effective over the geometric track at every curvature, with the standard deviations of the measurement.
fn chart(robot: &Compared) -> Chart {
    let rows = || robot.rows.iter().filter_map(|row| Some((row.curvature?, row)));
    let bar = |(at, row): (f64, &Row)| row.spread.map(|spread| vec![(at, row.real - spread), (at, row.real + spread)]);
    let real = rows().map(|(at, row)| (at, row.real)).collect();
    let here = rows().map(|(at, row)| (at, row.ours)).collect();
    Chart {
        title: robot.measured.name.clone(),
        x_title: "curvature: sum over difference of the sides' wheel speeds".to_owned(),
        y_title: "effective over geometric track".to_owned(),
        series: vec![
            Series { label: "here".to_owned(), lines: vec![here], joined: true, dots: false },
            Series { label: "real robot".to_owned(), lines: vec![real], joined: false, dots: true },
            Series { lines: rows().filter_map(bar).collect(), joined: true, ..Series::default() },
        ],
        ..Chart::default()
    }
}

fn page(compared: &[Compared], figures: &[String]) -> Markup {
    let body = html! {
        p {
            "Published measurements, and what usarsim " (env!("CARGO_PKG_VERSION")) " does with the robots' dimensions. A row agrees if the \
             difference is within the standard deviation of the measurement or what its file allows, whichever is more."
        }
        div.figures { @for svg in figures { figure { (PreEscaped(svg)) } } }
        @for robot in compared { (robot_table(robot)) }
    };
    document("Wheels beside real robots", &body)
}

fn robot_table(Compared { measured, rows, .. }: &Compared) -> Markup {
    html! {
        h2 { (measured.name) }
        p { (measured.source) "." }
        @if let Some(note) = &measured.note { p.noted { (note) } }
        table {
            tr { th { "quantity" } th { "real" } th { "here" } th { "difference" } th { "verdict" } }
            @for row in rows {
                tr {
                    td { (row.what) }
                    td.number { (format!("{:.4}", row.real)) @if let Some(spread) = row.spread { (format!(" ± {spread:.4}")) } }
                    td.number { (format!("{:.4}", row.ours)) }
                    td.number { (format!("{:+.1} %", row.percent())) }
                    td class=(row.verdict()) { (row.verdict()) }
                }
            }
            @for other in &measured.other {
                tr {
                    td { (other.simulator) ", the factor that a user needed (" (other.source) ")" }
                    td {}
                    td.number { (format!("{:.2}", other.chi)) }
                    td {} td {}
                }
            }
        }
    }
}
