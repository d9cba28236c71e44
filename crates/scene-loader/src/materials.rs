//! `materials.toml`: one table a material, each number with its source.

use std::collections::BTreeMap;

use scene::{Material, check};
use serde::Deserialize;

use crate::document::Document;
use crate::problem::Problems;

/// Materials by name.
pub(crate) type Materials = BTreeMap<String, Material>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    friction: f64,
    restitution: f64,
    rolling_resistance: f64,
    linear_damping: f64,
    angular_damping: f64,
    #[serde(default = "grey")]
    colour: [f64; 3],
    source: String,
}

/// What a material without a colour looks like.
fn grey() -> [f64; 3] {
    [0.6; 3]
}

pub(crate) fn read(file: &str, text: &str, problems: &mut Problems) -> Materials {
    let mut materials = Materials::new();
    let Some((mut document, mut root)) = Document::parse(file, text, problems) else { return materials };
    for (span, name, entry) in document.named::<Entry>(&mut root) {
        if entry.source.is_empty() {
            document.problem(&span, format_args!("`source` of {name} is empty: expected where its numbers come from"));
        }
        let Entry { friction, restitution, rolling_resistance, linear_damping, angular_damping, colour, source } =
            entry;
        let material = Material {
            name: name.clone(),
            friction,
            restitution,
            rolling_resistance,
            linear_damping,
            angular_damping,
            colour,
            source,
        };
        document.wrong(&span, check::material(&material));
        materials.insert(name, material);
    }
    materials
}
