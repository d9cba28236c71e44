//! What is built into the program is built in anew when it changes.

fn main() {
    println!("cargo::rerun-if-changed=../../assets");
    println!("cargo::rerun-if-changed=../../maps");
}
