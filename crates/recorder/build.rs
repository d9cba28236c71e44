//! Generates Rust types and a descriptor from `proto/usarsim.proto`.

use std::error::Error;
use std::path::Path;

use prost::Message;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=proto");
    let files = protox::compile(["usarsim.proto"], ["proto"])?;
    // Readers of a log need no comments, and the generated types are documented where they are used.
    let mut described = files.clone();
    described.file.iter_mut().for_each(|file| file.source_code_info = None);
    std::fs::write(Path::new(&std::env::var("OUT_DIR")?).join("usarsim.desc"), described.encode_to_vec())?;
    prost_build::Config::new().compile_fds(files)?;
    Ok(())
}
