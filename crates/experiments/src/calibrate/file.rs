//! The robot's file with the numbers that were found.

use scene::RobotDef;
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, Value};

use super::{BEARINGS, Calibration, RADIUS, STIFFNESS, SUM, TRACK};

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
    if let Some(bearings) = number(BEARINGS)
        && let Some(rollers) = document.get_mut("rollers").and_then(Item::as_table_like_mut)
    {
        match rollers.get_mut("bearing_friction").and_then(Item::as_value_mut) {
            Some(old) => replace(old, bearings.value),
            None => drop(rollers.insert("bearing_friction", toml_edit::value(round(bearings.value)))),
        }
        changed.push(format!("bearing_friction = {}", round(bearings.value)));
    }
    if let [Some(along), Some(across)] = STIFFNESS.map(number)
        && let Some(common) = document.get_mut("wheels").and_then(Item::as_table_like_mut)
    {
        let stiffness = Array::from_iter([along, across].map(|it| round(it.value)));
        changed.push(format!("tyre.stiffness = {stiffness}"));
        match common.get_mut("tyre").and_then(Item::as_table_like_mut) {
            Some(tyre) => drop(tyre.insert("stiffness", toml_edit::value(stiffness))),
            None => {
                let mut tyre = InlineTable::new();
                tyre.insert("stiffness", stiffness.into());
                tyre.insert("patch", Array::from_iter(found.patch.unwrap_or_default().map(round)).into());
                common.insert("tyre", toml_edit::value(tyre));
            }
        }
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
