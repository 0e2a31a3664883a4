//! A hundred damaged records with their messages, as one table: `damaged_inputs/messages.txt`. `BLESS=1` writes it anew.

use crate::support::page;

use std::fs;

use borescope::internals::record::Asked;

const MESSAGES: &str = "tests/it/cli/damaged_inputs/messages.txt";
const ROWS: &str = "time [s],p [bar],u [-]\n0.0,1.5,0\n0.5,-2.5,1\n1.0,3.5,1\n";

struct Case {
    what: String,
    bytes: Vec<u8>,
}

fn case(what: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Case {
    Case { what: what.into(), bytes: bytes.into() }
}

/// The small record with one text in the place of another.
fn texts() -> Vec<Case> {
    let replaced: &[(&str, &str)] = &[
        ("time [s]", "t [bar]"),
        ("time [s]", "time"),
        ("time [s]", "time [bar]"),
        ("time [s]", "time []"),
        ("time [s],", ""),
        ("time [s]", "\"time [s]"),
        ("p [bar]", "p"),
        ("p [bar]", "p [barg]"),
        ("p [bar]", "p [bar"),
        ("p [bar]", "[bar]"),
        ("p [bar]", "time [s]"),
        ("p [bar]", "u [bar]"),
        ("p [bar]", "p [L/min/]"),
        ("p [bar]", "p [bar^99]"),
        ("p [bar]", ""),
        ("p [bar]", "p;q [bar]"),
        ("time [s],p [bar],u [-]\n", ""),
        ("0.5,-2.5,1", "0.0,-2.5,1"),
        ("0.5,-2.5,1", "-0.5,-2.5,1"),
        ("0.5,-2.5,1", ",-2.5,1"),
        ("0.5,-2.5,1", "NaN,-2.5,1"),
        ("0.5,-2.5,1", "inf,-2.5,1"),
        ("0.5,-2.5,1", "12:30:01,-2.5,1"),
        ("0.5,-2.5,1", "2026-05-01,-2.5,1"),
        ("0.5,-2.5,1", "0.5,-2.5"),
        ("0.5,-2.5,1", "0.5,-2.5,1,7"),
        ("0.5,-2.5,1", "0.5"),
        ("0.5,-2.5,1", "0.5,abc,1"),
        ("0.5,-2.5,1", "0.5,1e999,1"),
        ("0.5,-2.5,1", "0.5,-2.5e,1"),
        ("0.5,-2.5,1", "0.5,--2.5,1"),
        ("0.5,-2.5,1", "0.5,2.5.1,1"),
        ("0.5,-2.5,1", "0.5,1'234,1"),
        ("0.5,-2.5,1", "0.5,1.234.567,1"),
        ("0.5,-2.5,1", "0.5,0x1F,1"),
        ("0.5,-2.5,1", "0.5,\"-2,5\",1"),
        ("0.5,-2.5,1", "0.5,\"-2.5,1"),
        ("0.5,-2.5,1", "0.5,ERR,1"),
        ("0.5,-2.5,1", "0.5,TRUE,1"),
        ("0.5,-2.5,1", "0.5;-2.5;1"),
        ("0.5,-2.5,1", "0.5,-2.5,1 A"),
        ("0.5,-2.5,1", "0.5,#REF!,1"),
        ("0.5,-2.5,1", "0.5,1 234.5,1"),
        ("1.0,3.5,1\n", "1.0,3"),
        ("1.0,3.5,1\n", "1.0,3.5,"),
        ("1.0,3.5,1\n", "1.0,3.5,-"),
        ("1.0,3.5,1\n", "1.0"),
        ("0.0,1.5,0\n0.5,-2.5,1\n1.0,3.5,1\n", ""),
        ("0.5,-2.5,1", "\u{0}\u{0}\u{0}"),
        ("0.5,-2.5,1", "0.5,\u{2212}2.5,1"),
    ];
    let mut cases: Vec<Case> = Vec::new();
    for (from, to) in replaced {
        assert!(ROWS.contains(from), "{from}");
        cases.push(case(
            format!("`{}` in place of `{}`", to.escape_debug(), from.escape_debug()),
            ROWS.replacen(from, to, 1),
        ));
    }
    for text in [
        "",
        "\n\n",
        "# nothing\n",
        "time [s]\n0\n",
        "0,1\n1,2\n",
        "time;p\ns;bar\n0;1,234\n1;2,345\n",
        "time [s];p [bar]\n0;1,234.5\n",
        "time [s];p [bar]\n0,5;1.5\n",
        "time,p\ns\n0,1\n",
        "time,p\ns,\n0,1\n",
        "time,p\ns,xyz\n0,1\n",
        "time,p\nbar,bar\n0,1\n",
    ] {
        cases.push(case(format!("the text `{}`", text.escape_debug()), text));
    }
    let header = format!("time [s]{}\n0\n", ",p [bar]".repeat(5000));
    cases.push(case("5000 columns", header));
    cases
}

/// Bytes that are no text, or packed.
fn bytes() -> Vec<Case> {
    let mut cases = vec![
        case("UTF-16", b"\xFF\xFEt\0i\0".to_vec()),
        case("a degree sign of Latin 1 and one of UTF-8", b"time [s],T [\xB0C],T2 [\xC2\xB0C]\n0,1,2\n".to_vec()),
        case("a degree sign of an old Macintosh", b"time [s],T [\xA1C]\n0,1\n".to_vec()),
        case("a workbook", b"PK\x03\x04".to_vec()),
        case("an old workbook", b"\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1".to_vec()),
        case("bzip2", b"BZh9".to_vec()),
        case("xz", b"\xFD7zXZ\0".to_vec()),
        case("7z", b"7z\xBC\xAF\x27\x1C".to_vec()),
        case("MDF 3", b"MDF     3.30    ".to_vec()),
        case("unfinished MDF", b"UnFinMF 4.10    ".to_vec()),
        case("gzip of nothing", b"\x1F\x8B".to_vec()),
        case("zstd of nothing", b"\x28\xB5\x2F\xFD".to_vec()),
        case("random bytes", (0..200_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect::<Vec<u8>>()),
    ];
    cases.extend(damaged(&[
        "stroke.csv.gz",
        "stroke.csv.zst",
        "stroke_plain.mat",
        "stroke_struct.mat",
        "stroke.mf4",
        "stroke_rates.mf4",
        "stroke.tdms",
        "stroke_rates.tdms",
    ]));
    cases
}

/// Files of other programs, cut and overwritten.
fn damaged(names: &[&str]) -> Vec<Case> {
    let mut cases = Vec::new();
    for name in names {
        let whole = fs::read(format!("fixtures/formats/{name}")).unwrap();
        for cut in [64, 128, 150, 500, whole.len() / 2] {
            cases.push(case(format!("{name} cut to {cut} bytes"), &whole[..cut]));
        }
        for at in [132, 200, whole.len() / 2] {
            let mut changed = whole.clone();
            changed[at..at + 4].fill(0xFF);
            cases.push(case(format!("{name} with FF FF FF FF at {at}"), changed));
        }
    }
    cases
}

#[test]
fn each_damaged_input_has_its_message() {
    let refused = check(texts().into_iter().chain(bytes()), MESSAGES);
    assert!(refused >= 100, "{refused}");
}

#[cfg(feature = "hdf5")]
#[test]
fn each_damaged_hdf5_file_has_its_message() {
    let short = [case("nothing but the mark", *b"\x89HDF\r\n\x1A\n"), case("a header alone", *b"MATLAB 7.3 MAT-file")];
    let files = damaged(&["stroke.h5", "stroke_rates.h5", "stroke_frame.h5", "stroke_v73.mat"]);
    let promise = case("terabytes promised", fs::read("fixtures/formats/promise.h5").unwrap());
    let refused = check(short.into_iter().chain(files).chain([promise]), "tests/it/cli/damaged_inputs/hdf5.txt");
    assert!(refused >= 20, "{refused}");
}

/// Holds the messages to those in a file; gives how many inputs are refused.
fn check(cases: impl Iterator<Item = Case>, messages: &str) -> usize {
    let mut table = String::new();
    let mut refused = 0;
    for Case { what, bytes } in cases {
        let told = match Asked::default().read_bytes("RECORD", bytes) {
            Ok(_) => "read".to_owned(),
            Err(complaint) => {
                refused += 1;
                let told = complaint.with_lines();
                assert!(told.starts_with("error: RECORD") && told.contains("\n  help: "), "{what}: {told}");
                told
            }
        };
        table.push_str(&format!("{what}\n  {}\n\n", told.replace('\n', "\n  ")));
    }
    if page::blessed() {
        fs::write(messages, &table).unwrap();
    }
    let known = fs::read_to_string(messages).unwrap_or_default();
    for (now, known) in table.split("\n\n").zip(known.split("\n\n")) {
        assert_eq!(now, known);
    }
    assert_eq!(table.len(), known.len());
    refused
}
