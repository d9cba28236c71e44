//! Tables of materials: those of `materials.toml`, each with a source, and a map's own.

use std::collections::BTreeMap;
use std::ops::Range;

use scene::{Material, check};
use serde::Deserialize;

use crate::document::{Document, Table};
use crate::problem::Problems;

/// Materials by name.
pub(crate) type Materials = BTreeMap<String, Material>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    friction: f64,
    #[serde(default)]
    restitution: f64,
    #[serde(default)]
    rolling_resistance: f64,
    #[serde(default)]
    linear_damping: f64,
    #[serde(default)]
    angular_damping: f64,
    #[serde(default = "grey")]
    colour: [f64; 3],
    #[serde(default)]
    transparent: bool,
    #[serde(default)]
    source: String,
}

/// Returns the colour of a material without one.
fn grey() -> [f64; 3] {
    [0.6; 3]
}

/// Reads the materials of `materials.toml`, each of which needs a source.
pub(crate) fn read(file: &str, text: &str, problems: &mut Problems) -> Materials {
    let Some((mut document, root)) = Document::parse(file, text, problems) else { return Materials::new() };
    let materials = read_table(&mut document, root);
    for (span, material) in &materials {
        if material.source.is_empty() {
            let name = &material.name;
            document.problem(span, format_args!("`source` of {name} is empty: expected where its numbers come from"));
        }
    }
    by_name(materials)
}

/// Reads the materials of a map and adds them to all others.
pub(crate) fn read_own<'a>(document: &mut Document<'a>, root: &mut Table<'a>, all: &Materials) -> Materials {
    let own = document.table(root, "material").map_or_else(Vec::new, |table| read_table(document, table));
    let mut materials = all.clone();
    materials.extend(by_name(own));
    materials
}

/// Reads every entry of a table with its position.
fn read_table<'a>(document: &mut Document<'a>, mut table: Table<'a>) -> Vec<(Range<usize>, Material)> {
    let entries = document.named::<Entry>(&mut table).into_iter().map(|(span, name, entry)| {
        let Entry {
            friction,
            restitution,
            rolling_resistance,
            linear_damping,
            angular_damping,
            colour,
            transparent,
            source,
        } = entry;
        let material = Material {
            name,
            friction,
            restitution,
            rolling_resistance,
            linear_damping,
            angular_damping,
            colour,
            transparent,
            source,
        };
        (span, material)
    });
    let materials: Vec<_> = entries.collect();
    for (span, material) in &materials {
        document.wrong(span, check::material(material));
    }
    materials
}

fn by_name(materials: Vec<(Range<usize>, Material)>) -> Materials {
    materials.into_iter().map(|(_, material)| (material.name.clone(), material)).collect()
}
