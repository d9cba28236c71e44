//! Rebuilds the crate when the page comes or changes.

fn main() {
    // `include_dir!` watches the files that it found, and a page that is built later is not among them.
    println!("cargo::rerun-if-changed=../../viewer/dist");
}
