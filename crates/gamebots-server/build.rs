//! Rebuilds the program when the page in it changes.

fn main() {
    println!("cargo::rerun-if-changed=../../viewer/dist");
}
