//! Rebuilds the crate when an embedded file changes.

fn main() {
    println!("cargo::rerun-if-changed=../../assets");
    println!("cargo::rerun-if-changed=../../maps");
}
