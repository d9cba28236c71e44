//! The program `usarsim`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(usarsim::main(std::env::args_os()))
}
