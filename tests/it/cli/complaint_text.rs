//! How messages look, and that files are written whole or not at all.

use std::fs;
use std::io;

use borescope::internals::complaint::{Complaint, Kind, Place, did_you_mean, help_with_names};
use borescope::internals::files::{read_text, write_atomically};

#[test]
fn a_message_names_its_place_and_what_would_be_right() {
    let kinds = ["pump", "relief_valve", "cylinder"];
    let complaint = Complaint::new(Kind::UnknownName, "unknown component kind `pmup`")
        .at(Place::line("rig.toml", 14))
        .help(help_with_names("pmup", "kinds", kinds));
    assert_eq!(
        complaint.to_string(),
        "error: rig.toml:14: unknown component kind `pmup`\n  \
         help: did you mean `pump`? Known kinds: `pump`, `relief_valve`, `cylinder`"
    );
}

#[test]
fn a_message_shows_both_places_and_indents_further_lines_of_help() {
    let complaint = Complaint::new(Kind::Contradiction, "these differ")
        .at(Place::line("rig.toml", 14).at_column(3))
        .at(Place::line("record.csv", 1))
        .help("one\ntwo");
    assert_eq!(complaint.to_string(), "error: rig.toml:14:3 and record.csv:1: these differ\n  help: one\n        two");
    assert_eq!(Complaint::new(Kind::Computation, "no result").to_string(), "error: no result");
}

#[test]
fn the_lines_stand_below_the_message_with_their_files_where_there_are_several() {
    let rig = || Place::line("rig.toml", 9).showing("unit = \"baar\"", 7..13);
    let complaint = Complaint::new(Kind::Unit, "no such unit").at(rig()).help("one\ntwo");
    let message = "error: rig.toml:9: no such unit\n  help: one\n        two";
    assert_eq!(complaint.to_string(), message);
    assert_eq!(complaint.with_lines(), format!("{message}\n  9 | unit = \"baar\"\n    |        ^^^^^^"));
    let complaint = complaint.at(Place::line("record.csv", 10).showing("time [s],p [bar]", 9..16));
    assert!(complaint.with_lines().ends_with(
        "\n  rig.toml:\n   9 | unit = \"baar\"\n     |        ^^^^^^\n  record.csv:\n  10 | time [s],p [bar]\n     |          ^^^^^^^"
    ));
    let plain = Complaint::new(Kind::Unit, "no such unit").at(Place::line("rig.toml", 9));
    assert_eq!(plain.with_lines(), plain.to_string());
    // Whoever compares places means where they are.
    assert_eq!(rig(), Place::line("rig.toml", 9));
}

#[test]
fn near_misses_are_found_and_far_ones_are_not() {
    let names = ["p_A", "p_B", "q_A", "flow_control", "relief"];
    for (word, near) in [
        ("p_a", Some("p_A")),
        ("flow_contol", Some("flow_control")),
        ("releif", Some("relief")),
        ("zz", None),
        ("temperature", None),
        ("", None),
    ] {
        assert_eq!(did_you_mean(word, names), near, "{word}");
    }
    assert_eq!(help_with_names("x", "columns", []), "there are no columns");
}

#[test]
fn a_byte_has_its_line_and_column() {
    let text = "one\nzwölf drei\n";
    let at = text.find("drei").unwrap();
    assert_eq!(Place::of_byte("f", text, at).to_string(), "f:2:7");
    assert_eq!(Place::of_byte("f", text, 0).to_string(), "f:1:1");
    assert_eq!(Place::of_byte("f", text, 999).to_string(), "f:3:1");
}

#[test]
fn a_file_is_written_whole_or_stays_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("result.txt");
    write_atomically(&path, |file| file.write_all(b"first")).unwrap();
    let complaint = write_atomically(&path, |file| {
        file.write_all(b"half")?;
        Err(io::Error::other("the disk is full"))
    })
    .unwrap_err();
    assert_eq!(complaint.to_string(), format!("error: {}: cannot be written: the disk is full", path.display()));
    assert_eq!(fs::read_to_string(&path).unwrap(), "first");
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(left.len(), 1, "{left:?}");
}

#[test]
fn a_missing_folder_or_a_folder_in_the_way_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none").join("result.txt");
    let complaint = write_atomically(&path, |_| Ok(())).unwrap_err();
    assert_eq!(complaint.kind, Kind::Missing);
    assert_eq!(
        complaint.to_string(),
        format!(
            "error: {}: there is no folder `{}` to write into\n  help: create the folder first, or name another one",
            path.display(),
            folder.path().join("none").display()
        )
    );
    let complaint = write_atomically(folder.path(), |_| Ok(())).unwrap_err();
    assert_eq!(
        complaint.to_string(),
        format!("error: {}: this is a folder, not a file\n  help: name a file in it", folder.path().display())
    );
}

#[cfg(unix)]
#[test]
fn a_link_a_device_and_permissions_are_kept() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let real = folder.path().join("real.txt");
    let link = folder.path().join("link.txt");
    fs::write(&real, "old").unwrap();
    fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
    symlink(&real, &link).unwrap();
    write_atomically(&link, |file| file.write_all(b"new")).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(read_text(&real).unwrap(), "new");
    let mode = fs::metadata(&real).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode, 0o640);
    write_atomically("/dev/null".as_ref(), |file| file.write_all(b"gone")).unwrap();
}
