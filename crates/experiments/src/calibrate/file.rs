//! The robot's file with the numbers that were found.

use scene::RobotDef;
use toml_edit::{Array, DocumentMut, Item, Table, Value};

use super::{Calibration, RADIUS, SUM, TRACK};

/// Returns the text of a robot.toml with the radius that was found, and the wheels' places, if nothing slides that decides them otherwise. Other
/// text and remarks stay. Also returns what was changed, for people.
///
/// # Errors
/// When the text is no TOML.
pub fn write_robot(text: &str, robot: &RobotDef, found: &Calibration) -> Result<(String, Vec<String>), String> {
    let mut document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| error.to_string())?;
    let mut changed = Vec::new();
    let number = |name: &str| found.numbers.iter().find(|number| number.name == name);
    if let Some(radius) = number(RADIUS) {
        let set = |table: &mut dyn toml_edit::TableLike| {
            if let Some(old) = table.get_mut("radius").and_then(Item::as_value_mut) {
                replace(old, radius.value);
            }
        };
        if let Some(common) = document.get_mut("wheels").and_then(Item::as_table_like_mut) {
            set(common);
        }
        for wheel in wheels(&mut document) {
            set(wheel);
        }
        changed.push(format!("radius = {}", round(radius.value)));
    }
    // A difference of sides without sliding, and Mecanum wheels, turn by where their wheels are.
    let scale = [TRACK, SUM].into_iter().find_map(|name| {
        let found = number(name)?;
        Some((found.value / found.in_file?, name))
    });
    if let Some((scale, name)) = scale {
        let axes = if name == SUM { 0..2 } else { 1..2 };
        for wheel in wheels(&mut document) {
            let Some(position) = wheel.get_mut("position").and_then(Item::as_array_mut) else { continue };
            scale_axes(position, axes.clone(), scale);
        }
        changed.push(format!("positions of {} wheels times {scale:.4}", robot.driven().count()));
    }
    Ok((document.to_string(), changed))
}

fn wheels(document: &mut DocumentMut) -> impl Iterator<Item = &mut Table> {
    document.get_mut("wheel").and_then(Item::as_array_of_tables_mut).into_iter().flat_map(|wheels| wheels.iter_mut())
}

fn scale_axes(position: &mut Array, axes: std::ops::Range<usize>, scale: f64) {
    for axis in axes {
        let number = |value: &Value| value.as_float().or(value.as_integer().map(|it| it as f64));
        if let Some(place) = position.get_mut(axis)
            && let Some(old) = number(place)
        {
            replace(place, old * scale);
        }
    }
}

/// Replaces a number, and keeps the remark behind it.
fn replace(old: &mut Value, number: f64) {
    let around = old.decor().clone();
    *old = round(number).into();
    *old.decor_mut() = around;
}

/// Rounds to a hundredth of a millimetre.
fn round(value: f64) -> f64 {
    (value * 1e5).round() / 1e5
}
