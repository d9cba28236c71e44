//! Charts as SVG and PNG, and names over pictures, with an embedded font so that they look the same on every machine.

mod labels;

use std::path::Path;
use std::sync::Once;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};

pub use labels::{Label, write_labels};

/// Size of a picture, pixels.
const SIZE: (u32, u32) = (760, 460);
/// Edge of a picture with equal axes, pixels.
const SQUARE: (u32, u32) = (640, 660);
/// Colours of the series, distinguishable for colour-blind readers (after Okabe and Ito).
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
    RGBColor(160, 140, 0),
];
/// Dash and gap of the reference lines, pixels.
const DASHES: [(u32, u32); 3] = [(6, 4), (2, 3), (14, 5)];
/// Colour of the areas behind the series.
const AREA: RGBColor = RGBColor(222, 218, 210);

/// Contents of a chart.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Chart {
    /// Title above the picture.
    pub title: String,
    /// Quantity and unit along x.
    pub x_title: String,
    /// Quantity and unit along y.
    pub y_title: String,
    /// Lines and dots.
    pub series: Vec<Series>,
    /// Dashed reference lines with their names.
    pub references: Vec<(String, [(f64, f64); 2])>,
    /// Names of the positions 0, 1, .. on x, if these are not numbers.
    pub categories: Vec<String>,
    /// Convex outlines behind the series.
    pub areas: Vec<Vec<(f64, f64)>>,
    /// True if a unit of x is as long as one of y.
    pub equal_axes: bool,
    /// True to label the y axis with the opposite sign, as if it pointed down.
    pub y_down: bool,
    /// Least height of the y axis.
    pub least_height: f64,
}

/// Points of one colour.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// Name in the legend; an empty one is not shown.
    pub label: String,
    /// Points; each list is a separate line.
    pub lines: Vec<Vec<(f64, f64)>>,
    /// True to join the points.
    pub joined: bool,
    /// True to draw a dot at each point.
    pub dots: bool,
}

/// A chart that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {reason}")]
pub struct ChartError {
    file: String,
    reason: String,
}

impl Chart {
    /// Draws the chart as the text of an SVG.
    ///
    /// # Errors
    /// When it cannot be drawn.
    pub fn to_svg(&self) -> Result<String, ChartError> {
        register_fonts();
        let mut text = String::new();
        let drawn = self.draw(&SVGBackend::with_string(&mut text, self.size()).into_drawing_area());
        let refused =
            |reason: DrawingAreaErrorKind<_>| ChartError { file: "SVG".to_owned(), reason: reason.to_string() };
        drawn.map_err(refused).map(|()| text)
    }

    fn size(&self) -> (u32, u32) {
        if self.equal_axes { SQUARE } else { SIZE }
    }

    /// Draws the chart as SVG or PNG, depending on the ending of the file's name.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, file: &Path) -> Result<(), ChartError> {
        register_fonts();
        let refused = |reason: String| ChartError { file: file.display().to_string(), reason };
        let size = self.size();
        let has = |ending: &str| file.extension().is_some_and(|it| it.eq_ignore_ascii_case(ending));
        if !has("png") && !has("svg") {
            return Err(refused("expected a name that ends in .svg or .png".to_owned()));
        }
        if has("png") {
            self.draw(&BitMapBackend::new(file, size).into_drawing_area()).map_err(|reason| refused(reason.to_string()))
        } else {
            self.draw(&SVGBackend::new(file, size).into_drawing_area()).map_err(|reason| refused(reason.to_string()))
        }
    }

    /// Returns the left, right, bottom and top ends of the axes.
    fn range(&self) -> [f64; 4] {
        let points = || self.series.iter().flat_map(|series| series.lines.iter().flatten());
        let ends = self.references.iter().flat_map(|(_, ends)| ends);
        let [mut left, mut right] = bounds(points().map(|point| point.0), 1e-9);
        let [mut low, mut high] = bounds(points().chain(ends).map(|point| point.1), self.least_height.max(1e-9));
        if self.equal_axes {
            let half = 0.55 * (right - left).max(high - low).max(1.0);
            let (x, y) = ((left + right) / 2.0, (low + high) / 2.0);
            return [x - half, x + half, y - half, y + half];
        }
        if self.categories.is_empty() {
            right += 0.02 * (right - left);
        } else {
            (left, right) = (-0.5, self.categories.len() as f64 - 0.5);
        }
        let room = 0.06 * (high - low);
        (low, high) = (low - room, high + room);
        [left, right, low, high]
    }

    fn draw<B: DrawingBackend>(&self, root: &DrawingArea<B, Shift>) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        root.fill(&WHITE)?;
        let [left, right, low, high] = self.range();
        let mut chart = ChartBuilder::on(root)
            .caption(&self.title, ("sans-serif", 17))
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(64)
            .build_cartesian_2d(left..right, low..high)?;
        for area in &self.areas {
            let corners = clipped(area, [left, right, low, high]);
            if corners.len() > 2 {
                chart.draw_series(std::iter::once(Polygon::new(corners, AREA.filled())))?;
            }
        }
        self.draw_axes(&mut chart)?;
        for (index, series) in self.series.iter().enumerate() {
            draw_series(&mut chart, series, COLOURS[index % COLOURS.len()])?;
        }
        for (index, (label, ends)) in self.references.iter().enumerate() {
            let (dash, gap) = DASHES[index % DASHES.len()];
            let dashes = DashedLineSeries::new(*ends, dash, gap, BLACK.stroke_width(1));
            let label = chart.draw_series(dashes)?.label(label.as_str());
            label.legend(move |(x, y)| {
                // Each legend shows dashes in its eighteen pixels.
                let next = x + (dash + gap) as i32;
                let pieces = [(x, x + dash as i32), (next, next + dash as i32), (next + (dash + gap) as i32, x + 18)];
                let pieces = pieces.map(|(from, to)| (from.min(x + 18), to.min(x + 18)));
                let [first, second, third] = pieces.map(|(from, to)| PathElement::new([(from, y), (to, y)], BLACK));
                EmptyElement::at((0, 0)) + first + second + third
            });
        }
        if !self.references.is_empty() || self.series.iter().any(|series| !series.label.is_empty()) {
            chart
                .configure_series_labels()
                .position(self.free_corner([left, right, low, high]))
                .background_style(WHITE.mix(0.8))
                .border_style(RGBColor(200, 200, 200))
                .label_font(("sans-serif", 14))
                .draw()?;
        }
        root.present()
    }

    /// Returns the corner with the fewest lines for the legend; the upper left of equal ones.
    fn free_corner(&self, [left, right, low, high]: [f64; 4]) -> SeriesLabelPosition {
        let rows = self.references.len() + self.series.iter().filter(|series| !series.label.is_empty()).count();
        let reach = [0.4, (0.05 + 0.06 * rows as f64).min(0.5)];
        let lines = self.series.iter().flat_map(|series| series.lines.iter().map(Vec::as_slice));
        let lines: Vec<&[(f64, f64)]> = lines.chain(self.references.iter().map(|(_, ends)| ends.as_slice())).collect();
        let covered = |(at_right, at_top): (bool, bool)| {
            let is_in = |&(x, y): &(f64, f64)| {
                let [x, y] = [(x - left) / (right - left), (y - low) / (high - low)];
                let [x, y] = [if at_right { 1.0 - x } else { x }, if at_top { 1.0 - y } else { y }];
                x < reach[0] && y < reach[1]
            };
            lines.iter().map(|line| along(line).iter().filter(|&point| is_in(point)).count()).sum::<usize>()
        };
        let corners = [
            (SeriesLabelPosition::UpperLeft, (false, true)),
            (SeriesLabelPosition::UpperRight, (true, true)),
            (SeriesLabelPosition::LowerRight, (true, false)),
            (SeriesLabelPosition::LowerLeft, (false, false)),
        ];
        let free = corners.into_iter().min_by_key(|(_, corner)| covered(*corner));
        free.map_or(SeriesLabelPosition::UpperLeft, |(position, _)| position)
    }

    fn draw_axes<B: DrawingBackend>(
        &self,
        chart: &mut ChartContext<B, Plane>,
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        let categories = &self.categories;
        let named = |x: &f64| match categories.get(x.round() as usize) {
            Some(name) if (x - x.round()).abs() < 1e-6 && *x >= 0.0 => name.clone(),
            Some(_) | None if !categories.is_empty() => String::new(),
            _ => short(*x),
        };
        let x_labels = if categories.is_empty() { 11 } else { 2 * categories.len() + 1 };
        let sign = if self.y_down { -1.0 } else { 1.0 };
        chart
            .configure_mesh()
            .x_labels(x_labels)
            .x_label_formatter(&named)
            .y_label_formatter(&|y| short(sign * y))
            .x_desc(&self.x_title)
            .y_desc(&self.y_title)
            .label_style(("sans-serif", 14))
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(225, 225, 225))
            .draw()
    }
}

fn register_fonts() {
    static FONT: Once = Once::new();
    FONT.call_once(|| {
        // The embedded font is valid.
        let _ = register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
    });
}

/// Returns points on a line. Every line has the same number, so that one with two ends counts as much as one with a thousand.
fn along(line: &[(f64, f64)]) -> Vec<(f64, f64)> {
    const POINTS: usize = 40;
    let last = line.len().saturating_sub(1);
    let at = |part: f64| {
        let index = part * last as f64;
        let (before, after) = (line[index.floor() as usize], line[index.ceil() as usize]);
        let on = index.fract();
        (before.0 + on * (after.0 - before.0), before.1 + on * (after.1 - before.1))
    };
    if line.is_empty() { Vec::new() } else { (0..=POINTS).map(|step| at(step as f64 / POINTS as f64)).collect() }
}

type Plane = Cartesian2d<RangedCoordf64, RangedCoordf64>;

fn draw_series<B: DrawingBackend>(
    chart: &mut ChartContext<B, Plane>,
    series: &Series,
    colour: RGBColor,
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    for (index, line) in series.lines.iter().enumerate() {
        let named = index == 0 && !series.label.is_empty();
        if series.joined {
            let drawn = chart.draw_series(LineSeries::new(line.iter().copied(), colour.stroke_width(2)))?;
            if named {
                let legend = move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2));
                drawn.label(series.label.as_str()).legend(legend);
            }
        }
        if series.dots {
            let drawn = chart.draw_series(line.iter().map(|&point| Circle::new(point, 3, colour.filled())))?;
            if named && !series.joined {
                drawn.label(series.label.as_str()).legend(move |(x, y)| Circle::new((x + 9, y), 3, colour.filled()));
            }
        }
    }
    Ok(())
}

/// Clips a convex outline to left, right, low, high (Sutherland and Hodgman).
fn clipped(outline: &[(f64, f64)], [left, right, low, high]: [f64; 4]) -> Vec<(f64, f64)> {
    // Distance of a point inside each side.
    let sides: [&dyn Fn((f64, f64)) -> f64; 4] = [&|p| p.0 - left, &|p| right - p.0, &|p| p.1 - low, &|p| high - p.1];
    sides.iter().fold(outline.to_vec(), |corners, inside| {
        let mut kept = Vec::new();
        for (index, &to) in corners.iter().enumerate() {
            let from = corners[(index + corners.len() - 1) % corners.len()];
            let (before, after) = (inside(from), inside(to));
            if before * after < 0.0 {
                let part = before / (before - after);
                kept.push((from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1)));
            }
            if after >= 0.0 {
                kept.push(to);
            }
        }
        kept
    })
}

/// Returns the least and greatest value, widened to at least the given distance.
fn bounds(values: impl Iterator<Item = f64>, least: f64) -> [f64; 2] {
    let [low, high] =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    let (middle, half) = if low <= high { ((low + high) / 2.0, (high - low) / 2.0) } else { (0.0, 0.0) };
    if 2.0 * half > least {
        [low, high]
    } else {
        let half = if least > 1e-6 { least / 2.0 } else { 0.5 };
        [middle - half, middle + half]
    }
}

/// Formats a number of an axis without rounding noise.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_outline_is_cut_at_the_edges_of_the_picture() {
        let check = |outline: &[(f64, f64)], expected: &[(f64, f64)]| {
            let mut got = clipped(outline, [0.0, 1.0, 0.0, 1.0]);
            let mut expected = expected.to_vec();
            let by_place = |a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1));
            got.sort_by(by_place);
            expected.sort_by(by_place);
            assert_eq!(got, expected, "{outline:?}");
        };
        let whole = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)];
        check(&[(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)], &whole);
        check(&[(0.5, -1.0), (2.0, -1.0), (2.0, 0.5), (0.5, 0.5)], &[(0.5, 0.0), (0.5, 0.5), (1.0, 0.0), (1.0, 0.5)]);
        check(&[(2.0, 2.0), (3.0, 2.0), (3.0, 3.0)], &[]);
    }

    #[test]
    fn a_legend_stands_where_the_fewest_lines_run() {
        let check = |line: &[(f64, f64)], expected: SeriesLabelPosition| {
            let series = Series { label: "line".into(), lines: vec![line.to_vec()], joined: true, ..Series::default() };
            let chart = Chart { series: vec![series], ..Chart::default() };
            let got = chart.free_corner([0.0, 1.0, 0.0, 1.0]);
            assert_eq!(format!("{got:?}"), format!("{expected:?}"), "{line:?}");
        };
        check(&[(0.0, 0.0), (1.0, 1.0)], SeriesLabelPosition::UpperLeft);
        check(&[(0.0, 1.0), (1.0, 0.0)], SeriesLabelPosition::UpperRight);
        check(&[(0.0, 1.0), (1.0, 1.0)], SeriesLabelPosition::LowerRight);
        check(&[], SeriesLabelPosition::UpperLeft);
    }

    #[test]
    fn a_chart_is_written_in_both_formats_and_an_unwritable_file_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let line = Series { lines: vec![vec![(0.0, 1.0), (1.0, 2.0)]], joined: true, ..Series::default() };
        let chart = Chart { series: vec![line], ..Chart::default() };
        for (name, start) in [("a.svg", &b"<svg"[..]), ("a.png", &b"\x89PNG"[..])] {
            let file = folder.path().join(name);
            chart.write(&file).unwrap();
            assert!(std::fs::read(&file).unwrap().starts_with(start), "{name}");
        }
        let error = chart.write(&folder.path().join("no/such.svg")).unwrap_err().to_string();
        assert!(error.contains("such.svg"), "{error}");
    }
}
