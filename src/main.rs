use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(borescope::command(std::env::args_os()))
}
