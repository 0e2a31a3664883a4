//! Each wrong record gives one message: the line, what is wrong, what would be right.

use std::fs;
use std::path::Path;

use borescope::internals::complaint::{Complaint, Kind, Place};
use borescope::internals::record::{Asked, Record, Stream};
use borescope::internals::units::Dimension;

const NUMBER: &str = "write a number such as `-1.5` or `2e-3`, or nothing where there is no value";
const TIME: &str = "every row has its time as a number, such as `1.5`; remove the rows without";
const CLOCK: &str = "write all times as numbers, such as seconds from the first row, or all as dates with times of day, such as `2026-11-23 10:00:00.120`";
const EMPTY_FIELD: &str = "every row has its time; remove the rows without";
const RISES: &str = "the time rises from row to row; sort the rows, remove those that repeat, or split the record where the clock was set";
const NAMES: &str = "name the columns in the first row: `time [s],p_A [bar],...`";
const BROKE_OFF: &str = "the writing broke off; remove the last line, or copy the file again";
const ENCODING: &str = "save the file as UTF-8; write `degC` and `um` where the degree or micro sign is in the way";
const MARKS: &str = "write all numbers with the same decimal mark and without separators of thousands";
const QUOTE: &str = "close it, or remove it";

/// The bytes of the file; `line: what is wrong`, the places of the file written as `:line`; the help.
const WRONG: &[(&[u8], &str, &str)] = &[
    // Nothing to read.
    (b"", ": the file is empty", "the first row names the columns: `time [s],p_A [bar],...`"),
    (b"\n# only a remark\n", ": the file is empty", "the first row names the columns: `time [s],p_A [bar],...`"),
    (b"time [s],p [bar]\n", ":1: the record has no rows below its header", "one row of numbers for each time"),
    (
        b"# a\ntime [s],p [bar]\n# b\n",
        ":2: the record has no rows below its header",
        "one row of numbers for each time",
    ),
    (
        b"time [s]\n0\n",
        ":1: the record has no column beside the time",
        "name the columns as `time [s],p_A [bar],...`, separated by `,`, `;` or a tab",
    ),
    // The header.
    (b"0.1,5\n0.2,6\n", ":1: the first row holds numbers, not the names of the columns", NAMES),
    (
        b"t [bar],p [bar]\n0,1\n",
        ":1: the first column is `t [bar]`, not the time",
        "write `t [s]` if it is; else put the time in front",
    ),
    (b"p [bar],time [s]\n1,0\n", ":1: `time` is column 2, but must be the first", "move the time column to the front"),
    (b"time,p [bar]\n0,1\n", ":1: the column `time` has no unit in square brackets", "write `time [s]`"),
    (
        b"time [bar],p [bar]\n0,1\n",
        ":1: column `time`: `bar` is a unit of pressure, not of time",
        "units of time: `s`, `ms`, `us`, `min`, `h`",
    ),
    (
        b"time [s],p\n0,1\n",
        ":1: the column `p` has no unit in square brackets",
        "write its unit behind the name, such as `p [bar]`; `p [-]` for a pure number",
    ),
    (b"time [s],p (bar)\n0,1\n", ":1: the column `p (bar)` has no unit in square brackets", "write `p [bar]`"),
    (
        b"time [s],p []\n0,1\n",
        ":1: the column `p []` has no unit in square brackets",
        "write its unit behind the name, such as `p [bar]`; `p [-]` for a pure number",
    ),
    (
        b"time [s],q [L/mn]\n0,1\n",
        ":1: column `q`: unknown unit `mn` in `L/mn`",
        "did you mean `L/min`? Units of flow: `L/min`, `L/s`, `m3/s`",
    ),
    (
        b"time [s],[bar]\n0,1\n",
        ":1: column 2 has no name",
        "write `name [unit]`; remove a separator at the end of the lines",
    ),
    (
        b"time [s],p [bar],\n0,1,\n",
        ":1: column 3 has no name",
        "write `name [unit]`; remove a separator at the end of the lines",
    ),
    (b"time [s],p [bar],p [kPa]\n0,1,2\n", ":1: the column `p` appears twice", "rename or remove one of the two"),
    (b"time [s],p [bar],time [s]\n0,1,0\n", ":1: the column `time` appears twice", "rename or remove one of the two"),
    (b"time [s],\"p [bar]\n0,1\n1,2\n", ":1: a quotation mark opens and is not closed", QUOTE),
    // The time.
    (b"time [s],p [bar]\n0.1,1\n0.3,1\n0.2,1\n", ":3 and :4: the time runs backwards to 0.2 s", RISES),
    (b"time [s],p [bar]\n0.1,1\n# gap\n\n0.1,1\n", ":2 and :5: the time 0.1 s repeats", RISES),
    // The numbers.
    (b"time [s],p [bar]\n0,1\nNaN,2\n", ":3: `NaN` in column `time` is not a finite number", TIME),
    (b"time [s],p [bar]\n-inf,0\n", ":2: `-inf` in column `time` is not a finite number", TIME),
    (b"time [s],p [bar]\n0,1e999\n", ":2: `1e999` in column `p` is not a finite number", NUMBER),
    (b"time [s],p [bar]\n,0\n", ":2: the field of `time` is empty", EMPTY_FIELD),
    (b"time [s],p [bar]\n0,high\n", ":2: `high` in column `p` is not a number", NUMBER),
    (b"time [s],p [bar]\n12:30:01,1\n", ":2: `12:30:01` in column `time` is not a number", CLOCK),
    (b"time [s];p [bar]\n0,5;1.5\n", ":2: `1.5` in column `p`: the decimal mark of this file is the comma", MARKS),
    (b"time [s];p [bar]\n0.5;1,5\n", ":2: `1,5` in column `p`: the decimal mark of this file is the point", MARKS),
    (b"time [s],p [bar]\n0,\"1\n1,2\n", ":2: a quotation mark opens and is not closed", QUOTE),
    // The rows.
    (
        b"time [s],p [bar]\n0,1,2\n1,2\n",
        ":2: the row has 3 fields, but the header names 2 columns",
        "one field for each column; where numbers have decimal commas, separate the columns with `;`",
    ),
    (
        b"time [s];p [bar]\n0;1;2\n1;2\n",
        ":2: the row has 3 fields, but the header names 2 columns",
        "one field for each column",
    ),
    (
        b"time [s],p [bar]\n0,1\n1\n2,3\n",
        ":3: the row has 1 field, but the header names 2 columns",
        "one field for each column",
    ),
    // Files that end too early.
    (b"time [s],p [bar],q [L/min]\n0,1,2\n1,2\n", ":3: the file ends in the middle of a row: 2 fields of 3", BROKE_OFF),
    (
        b"time [s],p [bar],q [L/min]\r\n0,1,2\r\n1,2\r\n",
        ":3: the file ends in the middle of a row: 2 fields of 3",
        BROKE_OFF,
    ),
    (b"time [s],p [bar],q [L/min]\n0,1,2\n1,2", ":3: the file ends in the middle of a row: 2 fields of 3", BROKE_OFF),
    (b"time [s],p [bar]\n0,1\n1,", ":3: the file ends in the middle of a number: ``", BROKE_OFF),
    (b"time [s],p [bar]\n0,1\n1,-", ":3: the file ends in the middle of a number: `-`", BROKE_OFF),
    (
        b"time [s],p [bar]\n0,1.5\n1,1.5\n2,1.5\n3,1.5\n4,1.5\n5,1.5\n6,1.5\n7,1.5\n8,1.5\n9,1.5\n10,4",
        ":12: the file ends in the middle of a number: `4`",
        BROKE_OFF,
    ),
    // The encoding.
    (b"time [s],T [degC]\n0,1\n# 40 \x80C\n", ":3: the byte 0x80 is not UTF-8 text", ENCODING),
    (b"\xff\xfet\0i\0", ":1: the file is UTF-16 text", "save it as UTF-8"),
];

#[test]
fn each_wrong_record_gives_one_message() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    for &(bytes, what, help) in WRONG {
        fs::write(&path, bytes).unwrap();
        let text = String::from_utf8_lossy(bytes);
        let Err(complaint) = Record::read(&path) else {
            panic!("accepted, though {what}:\n{text}");
        };
        let shown = complaint.to_string().replace(&path.display().to_string(), "");
        assert_eq!(shown, format!("error: {what}\n  help: {help}"), "for:\n{text}");
        assert_eq!(streamed(&path).unwrap_err().to_string(), complaint.to_string(), "piece by piece:\n{text}");
    }
}

/// The rows of a record that is read piece by piece.
fn streamed(path: &Path) -> Result<usize, Complaint> {
    let asked = Asked::default();
    let mut stream = Stream::open(path, &asked)?;
    let mut rows = 0;
    while let Some(piece) = stream.next_rows()? {
        rows += piece.time.len();
    }
    Ok(rows)
}

/// Lines are those of the file, whatever stands before the wrong one.
#[test]
fn lines_are_those_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    for (text, line) in [
        ("time [s],p [bar]\n0,1\n1,x\n", 3),
        ("time [s],p [bar]\r\n0,1\r\n1,x\r\n", 3),
        ("time [s],p [bar]\r0,1\r1,x\r", 3),
        ("\u{feff}time [s],p [bar]\n0,1\n1,x\n", 3),
        ("# a\n\n# b\ntime [s],p [bar]\n0,1\n# c\n\n\n1,x\n", 9),
        ("# a\r\n\r\n# b\r\ntime [s],p [bar]\r\n0,1\r\n# c\r\n\r\n\r\n1,x\r\n", 9),
        ("\u{feff}# a\ntime [s],p [bar]\n0,1\n1,x\n", 4),
        ("\"time\n[s]\",\"p\n[bar]\"\n0,1\n\"1\",\"x\"\n", 5),
        ("time [s],p [bar]\n0,1\n   \n1,x\n", 4),
        ("# a \" b\ntime [s],p [bar]\n0,1\n# \"\n1,x", 5),
    ] {
        fs::write(&path, text).unwrap();
        let complaint = Record::read(&path).unwrap_err();
        assert_eq!(complaint.places, [Place::line(&path, line)], "for:\n{text}");
        assert_eq!(complaint.what, "`x` in column `p` is not a number");
        assert_eq!(streamed(&path).unwrap_err().to_string(), complaint.to_string());
    }
}

#[test]
fn a_file_that_cannot_be_read_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none.csv");
    let complaint = Record::read(&path).unwrap_err();
    assert_eq!(complaint.kind, Kind::Missing);
    assert_eq!(
        complaint.to_string(),
        format!(
            "error: {}: there is no such file\n  help: check the path; a relative one counts from the current folder",
            path.display()
        )
    );
    let complaint = Record::read(folder.path()).unwrap_err();
    assert_eq!(complaint.kind, Kind::Unreadable);
    assert_eq!(
        complaint.to_string(),
        format!("error: {}: this is a folder, not a file\n  help: name one file in it", folder.path().display())
    );
}

#[test]
fn a_column_that_is_asked_for_and_missing_is_told_with_both_places() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    fs::write(&path, "# rig 3\ntime [s],p_A [bar],q_A [L/min]\n0,1,2\n").unwrap();
    let record = Record::read(&path).unwrap();
    let from = || Place::line("rig.toml", 14);
    let shown = |name| {
        let complaint = record.require(name, Dimension::PRESSURE, from()).unwrap_err();
        complaint.to_string().replace(&path.display().to_string(), "record.csv")
    };
    assert_eq!(
        shown("p_a"),
        "error: rig.toml:14 and record.csv:2: the record has no column `p_a`\n  \
         help: did you mean `p_A`? Known columns: `p_A`, `q_A`"
    );
    assert_eq!(
        shown("level"),
        "error: rig.toml:14 and record.csv:2: the record has no column `level`\n  \
         help: known columns: `p_A`, `q_A`"
    );
    assert_eq!(
        shown("q_A"),
        "error: rig.toml:14 and record.csv:2: column `q_A`: `L/min` is a unit of flow, not of pressure\n  \
         help: units of pressure: `bar`, `mbar`, `MPa`, `kPa`, `hPa`, `Pa`, `mPa`, `GPa`, `psi`"
    );
    let channel = record.require("p_A", Dimension::PRESSURE, from()).unwrap();
    assert_eq!(channel.values, [1e5]);
}

/// Pieces are cut between lines, so that long records read the same, whatever ends their lines.
#[test]
fn pieces_give_all_rows_and_the_right_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.csv");
    for end in ["\n", "\r\n", "\r", "\n\n# remark\n"] {
        let row = |row: usize| format!("{row},0.25,-1.5e-3{end}");
        let mut text = format!("time [s],p [bar],q [L/min]{end}");
        text.extend((0..200_000).map(row));
        fs::write(&path, &text).unwrap();
        assert!(text.len() > 3_000_000);
        assert_eq!(streamed(&path).unwrap(), 200_000, "{end:?}");
        text.push_str(&format!("200000,x,0{end}\n\n"));
        fs::write(&path, &text).unwrap();
        assert_eq!(streamed(&path).unwrap_err().to_string(), Record::read(&path).unwrap_err().to_string(), "{end:?}");
    }
}
