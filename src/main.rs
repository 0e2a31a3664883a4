use std::process::ExitCode;

fn main() -> ExitCode {
    borescope::cli::run(std::env::args_os())
}
