//! The page of robots, docs/robot-gallery.md, and its pictures, docs/robots/*.png.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

use scene::RobotDef;
use scene_loader::{FAMILIES, Family};

use super::repository;

/// Most bytes of a picture.
const PICTURE: u64 = 12 << 10;

/// A shipped class with its further names.
struct Entry {
    robot: RobotDef,
    names: Vec<String>,
}

/// Returns the shipped classes by the names of their folders.
fn entries() -> Vec<Entry> {
    let entry =
        |(class, names): (String, Vec<String>)| Entry { robot: scene_loader::robot(&class, &[]).unwrap(), names };
    scene_loader::robot_folders().into_iter().map(entry).collect()
}

/// Makes the chapters of the page.
pub(crate) fn chapters() -> String {
    let entries = entries();
    let row = |Entry { robot: RobotDef { class, description, .. }, names }: &Entry| {
        let names: String = names.iter().map(|name| format!("<br>`{name}`")).collect();
        format!("| ![{class}](robots/{class}.png) | `{class}`{names} | {description} |")
    };
    let chapter = |family: &Family| {
        let Family { title, driving, .. } = family;
        let rows: Vec<String> = entries.iter().filter(|entry| family.has(&entry.robot)).map(row).collect();
        format!("\n## {title}\n\n{driving}\n\n| | class | |\n|---|---|---|\n{}\n", rows.join("\n"))
    };
    let chapters: String = FAMILIES.iter().map(chapter).collect();
    format!("\n{}\n", chapters.trim_end())
}

/// Colours of a picture, and the step to which they are rounded before the most frequent ones are taken.
const COLOURS: usize = 128;
const STEP: u8 = 8;

/// Rewrites a picture with few colours, which takes a third of the bytes.
fn shrink(file: &Path) {
    let mut reader = png::Decoder::new(fs::File::open(file).unwrap()).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let rounded = |part: &u8| part.saturating_add(STEP / 2) / STEP * STEP;
    let pixels: Vec<[u8; 3]> = bytes.chunks(3).map(|it| [0, 1, 2].map(|part| rounded(&it[part]))).collect();
    let mut counts: BTreeMap<[u8; 3], usize> = BTreeMap::new();
    pixels.iter().for_each(|&pixel| *counts.entry(pixel).or_default() += 1);
    let mut palette: Vec<[u8; 3]> = counts.keys().copied().collect();
    palette.sort_by_key(|colour| (Reverse(counts[colour]), *colour));
    palette.truncate(COLOURS);
    let far =
        |a: &[u8; 3], b: &[u8; 3]| -> u32 { (0..3).map(|part| u32::from(a[part].abs_diff(b[part])).pow(2)).sum() };
    let nearest = |pixel: &[u8; 3]| (0..palette.len()).min_by_key(|&place| far(pixel, &palette[place])).unwrap() as u8;
    let nearest: BTreeMap<[u8; 3], u8> = counts.keys().map(|pixel| (*pixel, nearest(pixel))).collect();
    let mut encoder = png::Encoder::new(fs::File::create(file).unwrap(), info.width, info.height);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(palette.concat());
    encoder.set_compression(png::Compression::Best);
    encoder.set_filter(png::FilterType::NoFilter);
    let places: Vec<u8> = pixels.iter().map(|pixel| nearest[pixel]).collect();
    encoder.write_header().unwrap().write_image_data(&places).unwrap();
}

/// Draws a robot by the command that the page names.
fn draw(class: &str) {
    let out = format!("docs/robots/{class}.png");
    let arguments =
        format!("snapshot --robot {class} --map smooth --view portrait --seconds 0.3 --size 240x180 --out {out}");
    let mut program = Command::new(env!("CARGO_BIN_EXE_usarsim"));
    let output = program.args(arguments.split(' ')).current_dir(repository()).output().unwrap();
    assert!(output.status.success(), "{class}: {}", String::from_utf8_lossy(&output.stderr));
    shrink(&repository().join(out));
}

/// `UPDATE_FIGURES=1` draws them.
#[test]
fn every_robot_has_a_picture_in_the_gallery() {
    let folder = repository().join("docs/robots");
    let classes: BTreeSet<String> = entries().into_iter().map(|entry| entry.robot.class).collect();
    if std::env::var_os("UPDATE_FIGURES").is_some() {
        fs::create_dir_all(&folder).unwrap();
        classes.iter().for_each(|class| draw(class));
    }
    let mut drawn = BTreeSet::new();
    for entry in fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap()) {
        let name = entry.file_name().to_string_lossy().into_owned();
        let size = entry.metadata().unwrap().len();
        assert!(size <= PICTURE, "docs/robots/{name}: {size} bytes, expected at most {PICTURE}");
        drawn.insert(name.strip_suffix(".png").unwrap_or(&name).to_owned());
    }
    assert_eq!(drawn, classes, "`UPDATE_FIGURES=1 cargo test --test all figures` draws the pictures");
}
