//! The `toile` binary: parse, run, exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    toile::cli::main()
}
