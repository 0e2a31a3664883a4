use std::process::ExitCode;

fn main() -> ExitCode {
    borescope::command(std::env::args_os())
}
