//! `usarsim log plot`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use charts::{Chart, Series};
use nalgebra::Point3;
use recorder::{Log, Table};
use scene::{Shape, Solid};

use crate::output::keep_inputs;
use crate::{Failure, exit, print};

/// Options of `log plot`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  usarsim log plot run.mcap                                # run.svg, the paths over the map\n  \
    usarsim log plot run.mcap --field yaw --out yaw.png\n  usarsim log plot run.mcap --field wheel_speed_1,wheel_speed_2 --robot Ann"
)]
pub(crate) struct Arguments {
    /// The log.
    #[arg(value_name = "FILE.mcap")]
    file: PathBuf,
    /// Draw these columns of `log export --csv` against time, in place of the path.
    #[arg(long, value_name = "NAME,..", value_delimiter = ',')]
    field: Vec<String>,
    /// Only this robot, by number or name.
    #[arg(long, value_name = "ROBOT")]
    robot: Option<String>,
    /// An SVG or PNG file; the log's name with .svg unless given. An existing file is replaced.
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    out: Option<PathBuf>,
}

pub(super) fn run(Arguments { file, field, robot, out }: &Arguments) -> Result<(), Failure> {
    let out = out.clone().unwrap_or_else(|| file.with_extension("svg"));
    keep_inputs(&out, &[file])?;
    let log = super::read(file)?;
    let robot = robot.as_ref().map(|wanted| super::robot(&log, file, wanted)).transpose()?;
    let table = Table::of(&log, robot);
    if table.rows() == 0 {
        return Err(Failure::new(exit::BAD_DATA, format_args!("{}: no robot was in the world", file.display())));
    }
    let names = labels(&log);
    let chart = if field.is_empty() { path(&log, &table, &names) } else { fields(&table, field, &names)? };
    chart.write(&out).map_err(|error| Failure::new(exit::FAILURE, error))?;
    print(out.display());
    Ok(())
}

/// Largest absolute coordinate that is drawn, in the unit of its axis. Beyond it an axis has no numbers.
const MAX_DRAWN: f64 = 1e12;

/// Returns the labels of the robots: names that are unique, or else names with numbers.
fn labels(log: &Log) -> BTreeMap<u64, String> {
    let robots = super::robots(log);
    let name = |&(class, name): &(&str, &str)| if name.is_empty() { class.to_owned() } else { name.to_owned() };
    let names: Vec<String> = robots.values().map(name).collect();
    let is_alone = |name: &String| names.iter().filter(|other| *other == name).count() == 1;
    let label = |(&robot, name): (&u64, &String)| {
        (robot, if is_alone(name) { name.clone() } else { format!("{name} (robot {robot})") })
    };
    robots.keys().zip(&names).map(label).collect()
}

/// Splits a line of angles where it wraps from +π to -π, so that no line is drawn back across.
fn unwrapped(line: Vec<(f64, f64)>) -> Vec<Vec<(f64, f64)>> {
    let is_near = |a: &(f64, f64), b: &(f64, f64)| (b.1 - a.1).abs() < std::f64::consts::PI;
    line.chunk_by(is_near).map(<[_]>::to_vec).collect()
}

/// Returns the lines of a table by robot number.
pub(crate) fn by_robot(table: &Table, x: &str, y: &str) -> BTreeMap<u64, Vec<(f64, f64)>> {
    let column = |name| table.column(name).unwrap_or_default();
    let mut lines: BTreeMap<u64, Vec<(f64, f64)>> = BTreeMap::new();
    for ((&robot, &x), &y) in column("robot").iter().zip(column(x)).zip(column(y)) {
        let line = lines.entry(robot as u64).or_default();
        if x.abs() <= MAX_DRAWN && y.abs() <= MAX_DRAWN {
            line.push((x, y));
        }
    }
    lines
}

/// Draws the paths seen from above: x to the right, the wire's y down.
fn path(log: &Log, table: &Table, names: &BTreeMap<u64, String>) -> Chart {
    let paths = by_robot(table, "x", "y").into_iter();
    let paths: Vec<(u64, Vec<(f64, f64)>)> =
        paths.map(|(robot, line)| (robot, line.into_iter().map(|(x, y)| (x, -y)).collect())).collect();
    let first = paths.iter().filter_map(|(_, line)| line.first().copied()).collect();
    let starts = Series { label: "start".to_owned(), lines: vec![first], joined: false, dots: true };
    let series = paths.into_iter().map(|(robot, line)| Series {
        label: names.get(&robot).cloned().unwrap_or_default(),
        lines: vec![line],
        joined: true,
        dots: false,
    });
    over_map(log, series.chain(std::iter::once(starts)).collect())
}

/// Draws series over the map of a log, seen from above, with y of the wire negated.
pub(crate) fn over_map(log: &Log, series: Vec<Series>) -> Chart {
    let scene = log.scene().ok();
    let solids = scene.iter().flat_map(|scene| &scene.map.solids).filter_map(outline);
    Chart {
        title: format!("map {}, seen from above", log.run.get("map").map_or("", String::as_str)),
        x_title: "x (ahead), m".to_owned(),
        y_title: "y (to the right), m".to_owned(),
        series,
        areas: solids.collect(),
        equal_axes: true,
        y_down: true,
        ..Chart::default()
    }
}

/// Returns the hull of a solid in the plane, with y up, or `None` if it has no edge.
fn outline(solid: &Solid) -> Option<Vec<(f64, f64)>> {
    let sign = [-1.0, 1.0];
    let corners: Vec<[f64; 3]> = match &solid.shape {
        Shape::HalfSpace => return None,
        Shape::Box { size: [x, y, z] } => {
            let corner = |a: f64, b: f64, c: f64| [a * x / 2.0, b * y / 2.0, c * z / 2.0];
            sign.iter().flat_map(|&a| sign.map(|b| sign.map(|c| corner(a, b, c)))).flatten().collect()
        }
        Shape::Cylinder { radius, length } => (0..64)
            .map(|step| (f64::from(step % 32) / 32.0 * std::f64::consts::TAU, sign[step as usize / 32]))
            .map(|(angle, end)| [radius * angle.cos(), radius * angle.sin(), end * length / 2.0])
            .collect(),
        Shape::Ball { radius } => (0..32)
            .map(|step| f64::from(step) / 32.0 * std::f64::consts::TAU)
            .map(|angle| [radius * angle.cos(), radius * angle.sin(), 0.0])
            .collect(),
        Shape::Hull { points } => points.clone(),
        Shape::Mesh { vertices, .. } => vertices.clone(),
        Shape::HeightField(field) => field.corners().collect(),
    };
    let pose = solid.pose();
    let seen = corners.into_iter().map(|corner| pose * Point3::from(corner));
    Some(hull(seen.map(|point| (point.x, -point.y)).collect()))
}

/// The convex hull of points in a plane, counterclockwise (Andrew's monotone chain).
fn hull(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let half = |points: &mut dyn Iterator<Item = &(f64, f64)>| {
        let mut chain: Vec<(f64, f64)> = Vec::new();
        for &point in points {
            while let [.., a, b] = chain[..]
                && (b.0 - a.0) * (point.1 - a.1) <= (b.1 - a.1) * (point.0 - a.0)
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut outline = half(&mut points.iter());
    outline.extend(half(&mut points.iter().rev()));
    outline
}

fn fields(table: &Table, fields: &[String], names: &BTreeMap<u64, String>) -> Result<Chart, Failure> {
    let mut series = Vec::new();
    for name in fields {
        if table.column(name).is_none() {
            let known: Vec<&str> = table.columns.iter().map(|column| column.name.as_str()).collect();
            let meant = names::did_you_mean(name, known.iter().copied());
            let text = format!("no field `{name}`{meant}: expected one of {}", known.join(", "));
            return Err(Failure::new(exit::USAGE, text));
        }
        let lines = by_robot(table, "time", name);
        let many = lines.len() > 1;
        series.extend(lines.into_iter().map(|(robot, line)| Series {
            label: match names.get(&robot) {
                Some(robot) if many => format!("{name}, {robot}"),
                _ => name.clone(),
            },
            lines: if unit(name) == "rad" && !name.starts_with("wheel") { unwrapped(line) } else { vec![line] },
            joined: true,
            dots: false,
        }));
    }
    let mut units: Vec<&str> = fields.iter().map(|name| unit(name)).collect();
    units.dedup();
    Ok(Chart {
        title: fields.join(", "),
        x_title: "simulated time, s".to_owned(),
        y_title: units.join(", "),
        series,
        ..Chart::default()
    })
}

/// Returns the unit of a column.
fn unit(name: &str) -> &'static str {
    match name {
        "x" | "y" | "z" => "m",
        "roll" | "pitch" | "yaw" => "rad",
        "vx" | "vy" | "vz" => "m/s",
        "wx" | "wy" | "wz" => "rad/s",
        _ if name.starts_with("wheel_angle") => "rad",
        _ if name.starts_with("wheel_speed") => "rad/s",
        _ if name.starts_with("joint_position") => "rad or m",
        _ if name.starts_with("joint_speed") => "rad/s or m/s",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_that_turns_on_makes_no_line_back() {
        let line = vec![(0.0, 3.0), (1.0, 3.1), (2.0, -3.1), (3.0, -3.0)];
        assert_eq!(unwrapped(line), [vec![(0.0, 3.0), (1.0, 3.1)], vec![(2.0, -3.1), (3.0, -3.0)]]);
    }

    #[test]
    fn a_hull_has_the_outermost_points_alone() {
        let points = vec![(0.0, 0.0), (2.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 2.0), (0.0, 2.0), (0.0, 0.0)];
        assert_eq!(hull(points), [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)]);
    }
}
