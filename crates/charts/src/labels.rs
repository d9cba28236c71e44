//! Names over a picture.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::{ChartError, register_fonts};

/// A name in a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// Name.
    pub text: String,
    /// Column and row of what it names, pixels.
    pub at: [f64; 2],
    /// True to write it a little higher, with a line down to its place.
    pub is_above: bool,
}

/// Least height of the letters, pixels, and the height of the picture over theirs: as in the page.
const LEAST: f64 = 11.0;
const RATIO: f64 = 58.0;
/// Distance of the letters' middle below that of their line, over their height.
const LOWER: f64 = 0.12;
/// Colour of the letters, and of the plate behind them with the part of it that covers.
const INK: RGBColor = RGBColor(29, 32, 39);
const PLATE: RGBColor = WHITE;
const COVERS: f64 = 0.85;

/// Writes names over their places in a picture with rows from the top. A name that would cover an earlier one is left out.
///
/// # Errors
/// When they cannot be drawn.
pub fn write_labels(pixels: &mut [[u8; 3]], size: [usize; 2], labels: &[Label]) -> Result<(), ChartError> {
    register_fonts();
    let [width, height] = size.map(|edge| edge as u32);
    let area = BitMapBackend::with_buffer(pixels.as_flattened_mut(), (width, height)).into_drawing_area();
    let refused =
        |reason: DrawingAreaErrorKind<_>| ChartError { file: "picture".to_owned(), reason: reason.to_string() };
    draw(&area, size.map(|edge| edge as f64), labels).map_err(refused)
}

fn draw<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    [width, height]: [f64; 2],
    labels: &[Label],
) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    let letters = (height / RATIO).max(LEAST);
    let style = TextStyle::from(("sans-serif", letters).into_font()).color(&INK);
    let style = style.pos(Pos::new(HPos::Center, VPos::Center));
    let mut taken: Vec<[i32; 4]> = Vec::new();
    for Label { text, at: [x, y], is_above } in labels {
        let (wide, _) = area.estimate_text_size(text, &style)?;
        let half = [f64::from(wide) / 2.0 + 0.45 * letters, 0.8 * letters];
        let lifted = y - half[1] - if *is_above { 1.2 * letters } else { 0.0 };
        let middle = |at: f64, half: f64, size: f64| at.min(size - half).max(half);
        let [across, down] = [middle(*x, half[0], width), middle(lifted, half[1], height)];
        let plate =
            [across - half[0], down - half[1], across + half[0], down + half[1]].map(|edge| edge.round() as i32);
        let [left, top, right, bottom] = plate;
        if taken.iter().any(|other| left < other[2] && right > other[0] && top < other[3] && bottom > other[1]) {
            continue;
        }
        taken.push(plate);
        if *is_above {
            let line = [(*x as i32, bottom), (*x as i32, *y as i32)];
            area.draw(&PathElement::new(line, INK.mix(COVERS).stroke_width((letters / 12.0) as u32)))?;
        }
        area.draw(&Rectangle::new([(left, top), (right, bottom)], PLATE.mix(COVERS).filled()))?;
        area.draw(&Text::new(text.as_str(), (across as i32, (down + LOWER * letters) as i32), style.clone()))?;
    }
    area.present()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_written_in_their_order_inside_the_picture_and_never_over_each_other() {
        let grey = [120; 3];
        let size = [200, 100];
        let label = |text: &str, at| Label { text: text.to_owned(), at, is_above: true };
        let draw = |labels: &[Label]| {
            let mut pixels = vec![grey; size[0] * size[1]];
            write_labels(&mut pixels, size, labels).unwrap();
            pixels
        };
        let one = label("Robot1", [100.0, 60.0]);
        let drawn = draw(std::slice::from_ref(&one));
        let bright = drawn.iter().filter(|pixel| pixel[0] > 200).count();
        let dark = drawn.iter().filter(|pixel| pixel[0] < grey[0] - 10).count();
        assert!(bright > 300 && dark > 20, "{bright} {dark}");
        assert_eq!(drawn, draw(&[one.clone(), label("hidden", [103.0, 62.0])]));
        assert_ne!(drawn, draw(&[one, label("beside", [30.0, 95.0])]));
        // What is at an edge or outside has its plate whole; nothing panics.
        for at in [[-50.0, -50.0], [199.0, 99.0], [f64::MAX, 0.0], [f64::NAN, 5.0]] {
            let drawn = draw(&[label("a name that is wider than the picture is, by far and more", at)]);
            assert!(drawn.iter().any(|&pixel| pixel != grey), "{at:?}");
        }
        assert_eq!(draw(&[]), vec![grey; size[0] * size[1]]);
    }
}
