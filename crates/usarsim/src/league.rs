//! `usarsim league`.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use charts::Series;
use recorder::{Log, Record, Table};
use scene::{Entrant, Score, Standing, Standings};

use crate::log::plot;
use crate::output::keep_inputs;
use crate::{Failure, exit, log, print};

#[derive(clap::Subcommand)]
pub(crate) enum Command {
    /// Print the points of each team, and write a page with the map, the paths and every score.
    Report(Arguments),
}

/// Options of `league report`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  usarsim serve --league rescue --log run.mcap   # play, and record\n  \
    usarsim league report run.mcap                 # the points, and run.html with map and paths\n  \
    usarsim league report run.mcap --json          # for score tables")]
pub(crate) struct Arguments {
    /// The log of the round.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// Print the standings as JSON, and write no page.
    #[arg(long)]
    json: bool,
    /// The page; the log's name with .html unless given. An existing file is replaced.
    #[arg(long, value_name = "FILE.html", conflicts_with = "json")]
    out: Option<PathBuf>,
}

pub(crate) fn run(command: &Command) -> Result<(), Failure> {
    let Command::Report(Arguments { file, json, out }) = command;
    let log = log::read(file)?;
    let Some(standings) = standings(&log) else {
        let text = format!("{}: no league was played; expected the log of `usarsim serve --league`", file.display());
        return Err(Failure::new(exit::BAD_DATA, text));
    };
    if *json {
        print(serde_json::to_string(&standings).unwrap_or_default());
        return Ok(());
    }
    let out = out.clone().unwrap_or_else(|| file.with_extension("html"));
    keep_inputs(&out, &[file])?;
    let drawing = draw(&log, &standings).map_err(|error| Failure::new(exit::FAILURE, error))?;
    let written = std::fs::write(&out, page(file, &standings, &drawing));
    written.map_err(|error| Failure::new(exit::FAILURE, format_args!("{}: {error}", out.display())))?;
    print(table(&standings));
    print(out.display());
    Ok(())
}

/// Returns the last standings of a log. A log that was cut off has none, so its scores are added up.
fn standings(log: &Log) -> Option<Standings> {
    let records = || log.entries.iter().map(|entry| &entry.record);
    let last = records().rev().find_map(|record| match record {
        Record::Standings(standings) => Some((**standings).clone()),
        _ => None,
    });
    let scores = || records().filter_map(|record| if let Record::Scored(score) = record { Some(score) } else { None });
    last.or_else(|| {
        let scene = log.scene().ok()?;
        let league = scene.league?;
        let teams = league.teams.iter().map(|team| Standing { team: team.name.clone(), ..Standing::default() });
        let mut standings = Standings {
            league: league.name.clone(),
            map: scene.map.name.clone(),
            time_limit: league.time_limit,
            time: log.entries.last().map_or(0.0, |entry| entry.time),
            teams: teams.collect(),
            ..Standings::default()
        };
        for score in scores() {
            let Some(team) = league.team(&score.team).and_then(|team| standings.teams.get_mut(team)) else { continue };
            team.points = score.total;
            team.scores.push(score.clone());
            if team.robots.iter().all(|entrant| entrant.robot != score.robot) {
                let robots = log::robots(log);
                let (class, name) = robots.get(&score.robot).copied().unwrap_or_default();
                team.robots.push(Entrant { robot: score.robot, class: class.to_owned(), name: name.to_owned() });
            }
        }
        Some(standings)
    })
}

/// Returns the points as a table for a terminal.
fn table(standings: &Standings) -> String {
    let mut text = format!("{} on {}, {}\n", standings.league, standings.map, ending(standings));
    for (place, team) in standings.ranking() {
        // Writing to a text cannot fail.
        let _ = writeln!(text, "{place}. {} {} points", team.team, team.points);
        for Score { time, robot, reason, points, .. } in &team.scores {
            let since = time - standings.began.unwrap_or_default();
            let _ = writeln!(text, "   {} robot {robot} {reason} {points:+}", clock(since));
        }
    }
    text.trim_end().to_owned()
}

/// Describes when a round ended.
fn ending(standings: &Standings) -> String {
    match standings.began {
        None => "not begun".to_owned(),
        Some(_) if standings.is_over => format!("over after {}", clock(standings.time_limit)),
        Some(_) => format!("{} left", clock(standings.time_left())),
    }
}

/// Formats seconds as minutes and seconds.
fn clock(seconds: f64) -> String {
    let whole = seconds.max(0.0).round() as u64;
    format!("{}:{:02}", whole / 60, whole % 60)
}

/// Draws the paths of all teams over the map, with the places of scores.
fn draw(log: &Log, standings: &Standings) -> Result<String, charts::ChartError> {
    let lines: BTreeMap<u64, Vec<(f64, f64)>> = plot::by_robot(&Table::of(log, None), "x", "y");
    let path = |team: &Standing| Series {
        label: format!("{} {}", team.team, team.points),
        lines: team
            .robots
            .iter()
            .filter_map(|entrant| lines.get(&entrant.robot))
            .map(|line| line.iter().map(|(x, y)| (*x, -y)).collect())
            .collect(),
        joined: true,
        dots: false,
    };
    let places = |is_gain: bool, label: &str| Series {
        label: label.to_owned(),
        lines: vec![
            standings
                .teams
                .iter()
                .flat_map(|team| &team.scores)
                .filter(|score| (score.points > 0) == is_gain)
                .map(|score| (score.position[0], -score.position[1]))
                .collect(),
        ],
        joined: false,
        dots: true,
    };
    let mut series: Vec<Series> = standings.teams.iter().map(path).collect();
    series.extend([places(true, "points"), places(false, "penalty")].into_iter().filter(|it| !it.lines[0].is_empty()));
    let mut chart = plot::over_map(log, series);
    chart.title = format!("{} on {}", standings.league, standings.map);
    chart.to_svg()
}

/// Returns a page with the ranking, the drawing and all scores.
fn page(file: &Path, standings: &Standings, drawing: &str) -> String {
    let mut rows = String::new();
    for (place, team) in standings.ranking() {
        let (name, robots) = (escaped(&team.team), escaped(&entrants(team)));
        // Writing to a text cannot fail.
        let _ = writeln!(rows, "<tr><td>{place}</td><th>{name}</th><td>{}</td><td>{robots}</td></tr>", team.points);
    }
    let mut events: Vec<&Score> = standings.teams.iter().flat_map(|team| &team.scores).collect();
    events.sort_by(|a, b| a.time.total_cmp(&b.time));
    let mut scores = String::new();
    for Score { time, team, robot, reason, points, total, .. } in events {
        let since = clock(time - standings.began.unwrap_or_default());
        let (team, reason) = (escaped(team), escaped(reason));
        let row = format!("<td>{since}</td><th>{team}</th><td>{robot}</td><td>{reason}</td>");
        let _ = writeln!(scores, "<tr>{row}<td>{points:+}</td><td>{total}</td></tr>");
    }
    let (title, map, end) = (escaped(&standings.league), escaped(&standings.map), ending(standings));
    let source = escaped(&file.display().to_string());
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>\n\
         body {{ font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem }}\n\
         table {{ border-collapse: collapse; margin: 1rem 0 }}\nth, td {{ padding: .3rem .8rem; text-align: left; border-bottom: 1px solid #ccc }}\n\
         svg {{ max-width: 100%; height: auto }}\n</style>\n<h1>{title}</h1>\n<p>Map {map}, {end}. From {source}.</p>\n\
         <table>\n<tr><th>Place</th><th>Team</th><th>Points</th><th>Robots</th></tr>\n{rows}</table>\n{drawing}\n\
         <h2>Scores</h2>\n<table>\n<tr><th>Time</th><th>Team</th><th>Robot</th><th>Reason</th><th>Points</th><th>Total</th></tr>\n\
         {scores}</table>\n</html>\n"
    )
}

/// Lists the robots of a team by class and name. Those that entered several times are counted.
fn entrants(team: &Standing) -> String {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for Entrant { class, name, .. } in &team.robots {
        *counts.entry(format!("{class} {name}").trim().to_owned()).or_default() += 1;
    }
    let robots = counts.into_iter().map(|(robot, count)| match count {
        1 => robot,
        _ => format!("{robot} ({count} times)"),
    });
    robots.collect::<Vec<_>>().join(", ")
}

/// Escapes a text for HTML.
fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    text.replace('"', "&quot;").replace('\'', "&#39;")
}
