//! Generates Rust types from `proto/live.proto`, and has the crate compiled again when the page comes or changes.

use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=proto");
    // `include_dir!` watches the files that it found, and a page that is built later is not among them.
    println!("cargo::rerun-if-changed=../../viewer/dist");
    let files = protox::compile(["live.proto"], ["proto"])?;
    prost_build::Config::new().compile_fds(files)?;
    Ok(())
}
