//! `materials.toml`: one table a material, each number with its source.

use std::collections::BTreeMap;

use serde::Deserialize;
use sim_core::scene::Material;

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
    let (mut document, mut root) = Document::parse(file, text, problems);
    let mut materials = Materials::new();
    for (span, name, entry) in document.named::<Entry>(&mut root) {
        document.wire_name(&span, &name);
        for (key, value, most) in [
            ("friction", entry.friction, 10.0),
            ("restitution", entry.restitution, 1.0),
            ("rolling_resistance", entry.rolling_resistance, 1.0),
            ("linear_damping", entry.linear_damping, 1000.0),
            ("angular_damping", entry.angular_damping, 1000.0),
        ] {
            if !(0.0..=most).contains(&value) {
                document.problem(&span, format_args!("`{key}` of {name} is {value}: expected 0 to {most}"));
            }
        }
        if !entry.colour.iter().all(|part| (0.0..=1.0).contains(part)) {
            let got = entry.colour;
            document
                .problem(&span, format_args!("`colour` of {name} is {got:?}: expected red, green and blue of 0 to 1"));
        }
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
        materials.insert(name, material);
    }
    materials
}
