//! The page's types of shapes. Outside `src`, where nothing reads a file or the environment.

use std::path::Path;

use ts_rs::TS;

use crate::{HeightField, Shape};

/// `UPDATE_FIGURES=1` renews the file.
#[test]
fn the_page_has_the_types_of_shapes() {
    let config = ts_rs::Config::default();
    let [field, shape] = [HeightField::decl(&config), Shape::decl(&config)];
    let text =
        format!("// Generated from crates/scene/src/shape.rs by `make figures`.\n\nexport {field}\n\nexport {shape}\n");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../viewer/src/protocol/shape.gen.ts");
    if std::env::var_os("UPDATE_FIGURES").is_some() {
        std::fs::write(&path, &text).expect("a file");
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == text, "{} is out of date: `make figures` renews it", path.display());
}
