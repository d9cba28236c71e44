//! `[[height_field]]`: uneven ground from a picture, from a table of numbers, or generated.

use std::ops::Range as Span;

use png::{BitDepth, ColorType, Decoder, Limits};
use scene::check::{self, MAX_TRIANGLES, Range};
use scene::{HeightField, Shape};

use crate::document::{Document, Table};
use crate::source::{MAX_MESH, Source};

pub(super) const KEYS: &str = ", size, file, height, cell, hills, roughness, flat, seed";

/// Largest difference of heights, m.
const HEIGHT: Range = Range { least: 0.0, most: check::FIELD_HEIGHT.most, unit: " m" };
/// Heights are multiples of a tenth of a millimetre, which are short in logs.
const STEPS: f64 = 1e4;

/// Rows of heights, m, from the far end of the field (+x) to the near one. Each goes from left to right (+y).
pub(crate) struct Rows {
    pub(crate) columns: usize,
    pub(crate) heights: Vec<f64>,
}

pub(super) fn read<'a>(source: &Source, document: &mut Document<'a>, table: &mut Table<'a>) -> Option<Shape> {
    let span = table.span();
    let size: Option<[f64; 2]> = document.required(table, "size", "lengths [x, y] in metres");
    let file: Option<String> = document.optional(table, "file");
    let height: Option<f64> = document.optional(table, "height");
    let given = height.is_none_or(|height| document.within(&span, "height", height, HEIGHT));
    let size = size.filter(|size| {
        let wrong = check::MAP_SIZE.problem_in("size", size);
        let is_good = wrong.is_none();
        document.wrong(&span, wrong);
        is_good && given
    })?;
    let rows = match file {
        Some(file) => of_file(source, &file, height),
        None => Ground::read(document, table, &span, height)?.rows(size),
    };
    let Rows { columns, heights } = rows.map_err(|reason| document.problem(&span, reason)).ok()?;
    // A height field has its near end first.
    let near_first = heights.chunks_exact(columns).rev().flatten();
    let heights = near_first.map(|height| (height * STEPS).round() / STEPS).collect();
    Some(Shape::HeightField(HeightField { size, columns, heights }))
}

/// Describes more points than a map may have; `None` if they are few enough.
fn too_many(rows: usize, columns: usize) -> Option<String> {
    let is_good = rows.saturating_mul(columns).saturating_mul(2) <= MAX_TRIANGLES;
    (!is_good).then(|| format!("{rows} x {columns} heights: expected at most {} of them", MAX_TRIANGLES / 2))
}

fn of_file(source: &Source, file: &str, height: Option<f64>) -> Result<Rows, String> {
    let wrong = |reason: String| format!("height field `{file}`: {reason}");
    match file.rsplit('.').next().map(str::to_ascii_lowercase).as_deref() {
        Some("png") => {
            let height =
                height.ok_or_else(|| wrong("missing `height`: expected that of white over black, m".into()))?;
            let bytes = source.bytes(file, MAX_MESH).map_err(|error| error.to_string())?;
            of_picture(&bytes, height).map_err(wrong)
        }
        Some("csv" | "txt") if height.is_some() => Err(wrong("a table has its heights in metres: no `height`".into())),
        Some("csv" | "txt") => of_text(&source.text(file).map_err(|error| error.to_string())?).map_err(wrong),
        _ => Err(wrong("expected a file that ends in .png, .csv or .txt".into())),
    }
}

/// Reads a picture. `height` is that of white over black, m.
pub(crate) fn of_picture(bytes: &[u8], height: f64) -> Result<Rows, String> {
    let decoder = Decoder::new_with_limits(bytes, Limits { bytes: MAX_MESH as usize });
    let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
    let (rows, columns) = (reader.info().height as usize, reader.info().width as usize);
    let (colours, depth) = reader.output_color_type();
    if colours != ColorType::Grayscale || !matches!(depth, BitDepth::Eight | BitDepth::Sixteen) {
        return Err(format!("{colours:?} of {depth:?} bits: expected grey of 8 or 16 bits"));
    }
    too_many(rows, columns).map_or(Ok(()), Err)?;
    let mut pixels = vec![0; reader.output_buffer_size()];
    let frame = reader.next_frame(&mut pixels).map_err(|error| error.to_string())?;
    let pixels = &pixels[..frame.buffer_size()];
    let heights = match depth {
        BitDepth::Sixteen => {
            let white = f64::from(u16::MAX);
            let grey = |pair: &[u8]| f64::from(u16::from_be_bytes([pair[0], pair[1]]));
            pixels.chunks_exact(2).map(|pair| height * grey(pair) / white).collect()
        }
        _ => pixels.iter().map(|&grey| height * f64::from(grey) / f64::from(u8::MAX)).collect(),
    };
    Ok(Rows { columns, heights })
}

fn of_text(text: &str) -> Result<Rows, String> {
    let (mut columns, mut heights) = (0, Vec::new());
    for (number, line) in (1..).zip(text.lines()) {
        let before = heights.len();
        let line = line.split('#').next().unwrap_or_default();
        let words = line.split([',', ';', ' ', '\t']).map(str::trim).filter(|word| !word.is_empty());
        for word in words {
            let height = word.parse().ok().filter(|height: &f64| height.is_finite());
            heights.push(height.ok_or_else(|| format!("line {number}: got `{}`, expected a height", shown(word)))?);
        }
        let count = heights.len() - before;
        if count > 0 && columns > 0 && count != columns {
            return Err(format!("line {number}: got {count} heights, expected {columns} as in the lines before"));
        }
        columns = columns.max(count);
    }
    let rows = heights.len() / columns.max(1);
    if rows < 2 || columns < 2 {
        return Err(format!("{rows} lines of {columns} heights: expected at least two of two"));
    }
    too_many(rows, columns).map_or(Ok(Rows { columns, heights }), Err)
}

fn shown(word: &str) -> String {
    word.chars().take(40).flat_map(char::escape_debug).collect()
}

/// Ground that is generated: value noise of several wavelengths.
struct Ground {
    /// Height of the highest point over the lowest, m.
    height: f64,
    /// Edge of a cell, m.
    cell: f64,
    /// Longest wavelength, m.
    hills: f64,
    /// Ratio of the heights of one wavelength to those of its double.
    roughness: f64,
    /// Radius of the flat place in the middle, m. The hills grow from there to twice as far.
    flat: f64,
    seed: u64,
}

impl Ground {
    fn read<'a>(
        document: &mut Document<'a>,
        table: &mut Table<'a>,
        span: &Span<usize>,
        height: Option<f64>,
    ) -> Option<Self> {
        if height.is_none() {
            document.problem(span, "missing `height`: expected that of the highest point over the lowest, m");
        }
        let mut number = |key: &str, range: Range, default: f64| -> Option<f64> {
            let value = document.optional(table, key).unwrap_or(default);
            document.within(span, key, value, range).then_some(value)
        };
        let [cell, hills] =
            [("cell", 1.0), ("hills", 20.0)].map(|(key, default)| number(key, check::MAP_SIZE, default));
        let roughness = number("roughness", check::SHARE, 0.5);
        let flat = number("flat", Range { least: 0.0, ..check::MAP_SIZE }, 0.0);
        let seed = document.optional(table, "seed").unwrap_or(0);
        Some(Self { height: height?, cell: cell?, hills: hills?, roughness: roughness?, flat: flat?, seed })
    }

    fn rows(&self, size: [f64; 2]) -> Result<Rows, String> {
        let [rows, columns] = size.map(|length| (length / self.cell).round().max(1.0) as usize + 1);
        too_many(rows, columns).map_or(Ok(()), Err)?;
        let place = |axis: usize, number: usize, count: usize| size[axis] * (number as f64 / (count - 1) as f64 - 0.5);
        let mut heights = Vec::with_capacity(rows * columns);
        for row in (0..rows).rev() {
            for column in 0..columns {
                let [x, y] = [place(0, row, rows), place(1, column, columns)];
                heights.push(self.wave(x, y) * self.share(x, y));
            }
        }
        let least = heights.iter().copied().fold(f64::INFINITY, f64::min);
        let most = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let factor = if most > least { self.height / (most - least) } else { 0.0 };
        heights.iter_mut().for_each(|height| *height *= factor);
        Ok(Rows { columns, heights })
    }

    /// Returns the share of the hills at a place: 0 in the flat middle, 1 far from it.
    fn share(&self, x: f64, y: f64) -> f64 {
        let distance = (x * x + y * y).sqrt();
        if self.flat > 0.0 { eased((distance / self.flat - 1.0).clamp(0.0, 1.0)) } else { 1.0 }
    }

    fn wave(&self, x: f64, y: f64) -> f64 {
        let (mut sum, mut wavelength, mut height) = (0.0, self.hills, 1.0);
        // Waves of two cells are the shortest that the grid can show.
        for octave in 0..32 {
            sum += height * self.noise(octave, x / wavelength, y / wavelength);
            wavelength /= 2.0;
            height *= self.roughness;
            if wavelength < 2.0 * self.cell || height == 0.0 {
                break;
            }
        }
        sum
    }

    /// Returns noise of -1 to 1, smooth between the points with whole coordinates.
    fn noise(&self, octave: u64, x: f64, y: f64) -> f64 {
        let (left, low) = (x.floor(), y.floor());
        let at = |right: f64, up: f64| self.value(octave, (left + right) as i64, (low + up) as i64);
        let (across, along) = (eased(x - left), eased(y - low));
        let between = |from: f64, to: f64, share: f64| from + (to - from) * share;
        between(between(at(0.0, 0.0), at(1.0, 0.0), across), between(at(0.0, 1.0), at(1.0, 1.0), across), along)
    }

    /// Returns the random number of a point, -1 to 1.
    fn value(&self, octave: u64, x: i64, y: i64) -> f64 {
        let mut hash = scene::Fnv::default();
        [self.seed, octave, x as u64, y as u64].iter().for_each(|part| hash.mix(&part.to_le_bytes()));
        // The high bits of the hash of short inputs are alike: they are mixed once more (the finaliser of SplitMix64).
        let mixed = (hash.value() ^ (hash.value() >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Eases a share of 0 to 1 in and out.
fn eased(share: f64) -> f64 {
    share * share * (3.0 - 2.0 * share)
}
