//! What goes wrong while files are read and written: one message, exit status 2, and nothing half done.

use crate::support::command;

use std::fs;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};

use command::borescope;

const RIG: &str = "fixtures/two_tanks/rig.toml";

/// Names of the files in a folder.
fn names(folder: &std::path::Path) -> Vec<String> {
    fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn a_full_disk_is_told() {
    let ran = borescope(["simulate", RIG, "-o", "/dev/full"]);
    assert_eq!((ran.status, ran.out.as_str()), (Some(2), ""));
    assert!(ran.err.starts_with("error: /dev/full: cannot be written: "), "{}", ran.err);
    assert!(ran.err.contains("\n  help: make room on the disk"), "{}", ran.err);
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    for verb in [&["check", RIG][..], &["effects"], &["check", RIG, "--format", "json"]] {
        let out = full.try_clone().unwrap();
        let output = Command::new(env!("CARGO_BIN_EXE_borescope")).args(verb).stdout(out).output().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{verb:?}: {told}");
        assert!(told.starts_with("error: standard output cannot be written: "), "{verb:?}: {told}");
    }
}

/// A limit on the size of files is the full disk of everyone: the old file stays, and no temporary one.
#[test]
fn a_file_that_cannot_be_written_to_its_end_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let record = folder.path().join("record.csv");
    fs::write(&record, "what was there before\n").unwrap();
    let program = env!("CARGO_BIN_EXE_borescope");
    // The signal of the limit is ignored, so that writing fails as on a full disk.
    let script = format!("trap '' XFSZ; ulimit -f 4; exec {program} simulate {RIG} --force -o {}", record.display());
    let output = Command::new("bash").args(["-c", &script]).output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("record.csv: cannot be written: "), "{told}");
    assert_eq!(fs::read_to_string(&record).unwrap(), "what was there before\n");
    assert_eq!(names(folder.path()), ["record.csv"]);
}

#[test]
fn a_folder_without_permission_is_told() {
    let folder = tempfile::tempdir().unwrap();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).unwrap();
    // Who may do everything is not kept out.
    if fs::write(folder.path().join("probe"), "").is_ok() {
        println!("permissions do not bind this user; nothing to see");
        return;
    }
    let record = folder.path().join("record.csv");
    let ran = borescope(["simulate", RIG, "-o", record.to_str().unwrap()]);
    let message = format!(
        "error: {}: no permission to write the file\n  help: name a folder that you may write to\n",
        record.display()
    );
    assert_eq!((ran.status, ran.err), (Some(2), message));
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
}

/// A logger that still writes: the record is read as it was at one moment, or not at all.
#[test]
fn a_record_that_grows_while_it_is_read_is_whole_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    let mut rows = String::from("time [s],p [bar]\n");
    (0..50_000).for_each(|row| rows.push_str(&format!("{row},1.5\n")));
    fs::write(&path, &rows).unwrap();
    let stop = AtomicBool::new(false);
    let (mut read, mut refused) = (0, 0);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut file = fs::File::options().append(true).open(&path).unwrap();
            let mut row = 50_000;
            while !stop.load(Ordering::Relaxed) {
                // Each row in one piece, as a logger does.
                file.write_all(format!("{row},1.5\n").as_bytes()).unwrap();
                row += 1;
            }
        });
        for _ in 0..20 {
            match borescope::Record::read(&path) {
                Ok(record) => {
                    read += 1;
                    assert!(record.time.windows(2).all(|pair| pair[1] == pair[0] + 1.0));
                }
                Err(complaint) => {
                    refused += 1;
                    assert_eq!(complaint.what, "the file changed while it was read");
                }
            }
        }
        stop.store(true, Ordering::Relaxed);
    });
    assert_eq!(read + refused, 20);
    assert!(refused > 0, "nothing changed while it was read");
}

#[test]
fn what_is_read_is_not_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let own = |name: &str| folder.path().join(name).display().to_string();
    let (rig, record) = (own("rig.toml"), own("record.csv"));
    fs::copy(RIG, &rig).unwrap();
    assert_eq!(borescope(["simulate", &rig, "-o", &record]).status, Some(0));
    let before = [&rig, &record].map(|path| fs::read(path).unwrap());
    for verb in [
        &["simulate", &rig, "-o", &rig][..],
        &["simulate", &rig, "--input", &record, "-o", &record],
        &["diagnose", &rig, &record, "--report", &record],
        &["compare", &rig, &record, "--report", &rig],
        &["calibrate", &rig, &record, "-o", &record],
    ] {
        let ran = borescope(verb);
        assert_eq!(ran.status, Some(2), "{verb:?}: {}", ran.err);
        assert!(ran.err.contains("this file is read, and would be overwritten"), "{verb:?}: {}", ran.err);
    }
    assert_eq!(before, [&rig, &record].map(|path| fs::read(path).unwrap()));
}

/// Whoever closes a pipe has seen enough.
#[test]
fn a_closed_pipe_is_no_failure() {
    let program = env!("CARGO_BIN_EXE_borescope");
    let rig = "fixtures/telescopic/rig.toml";
    let script = format!("set -o pipefail; {program} simulate {rig} -o - | head -c 100 > /dev/null");
    let output = Command::new("bash").args(["-c", &script]).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}
