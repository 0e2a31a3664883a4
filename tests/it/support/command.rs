//! Runs the built program.

use std::ffi::OsStr;
use std::process::{Child, Command};

/// What every file that was written is told with.
const WRITTEN: &str = "written to ";

/// What a run of the program left: exit status, standard output, standard error; and from that apart which files were written.
pub struct Ran {
    pub status: Option<i32>,
    pub out: String,
    pub err: String,
    pub written: Vec<String>,
}

/// A program that is ended with the test, whether that passes or not.
pub struct Ending(pub Child);

impl Drop for Ending {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs `borescope` with these arguments, from the folder of the project.
pub fn borescope<A: AsRef<OsStr>>(arguments: impl IntoIterator<Item = A>) -> Ran {
    let output = Command::new(env!("CARGO_BIN_EXE_borescope")).args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let (written, err): (Vec<_>, Vec<_>) =
        text(output.stderr).split_inclusive('\n').map(str::to_owned).partition(|line| line.starts_with(WRITTEN));
    let written = written.iter().map(|line| line[WRITTEN.len()..].trim_end().to_owned()).collect();
    Ran { status: output.status.code(), out: text(output.stdout), err: err.concat(), written }
}
