//! TDMS files as LabVIEW and DAQmx leave them, made here byte by byte after NI's paper, where no file written by another program has it.

use std::fs;

use borescope::Record;

fn read(bytes: &[u8]) -> Result<Record, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record");
    fs::write(&path, bytes).unwrap();
    Record::read(&path).map_err(|complaint| complaint.to_string().replace(&path.display().to_string(), "RECORD"))
}

const NEW_LIST: u32 = 2 | 4 | 8;
const CHANGES: u32 = 2 | 8;
const DATA_ONLY: u32 = 8;
const INTERLEAVED: u32 = 32;
const BIG: u32 = 64;
const DAQMX: u32 = 128;

/// Numbers and texts in one order.
struct Bytes {
    little: bool,
    bytes: Vec<u8>,
}

impl Bytes {
    fn new(flags: u32) -> Self {
        Self { little: flags & BIG == 0, bytes: Vec::new() }
    }

    /// A number, given by its little-endian bytes.
    fn number(mut self, mut raw: Vec<u8>) -> Self {
        if !self.little {
            raw.reverse();
        }
        self.bytes.extend(raw);
        self
    }

    fn u32(self, value: u32) -> Self {
        self.number(value.to_le_bytes().to_vec())
    }

    fn u64(self, value: u64) -> Self {
        self.number(value.to_le_bytes().to_vec())
    }

    fn f64(self, value: f64) -> Self {
        self.u64(value.to_bits())
    }

    fn i16(self, value: i16) -> Self {
        self.number(value.to_le_bytes().to_vec())
    }

    fn text(self, text: &str) -> Self {
        let mut out = self.u32(text.len() as u32);
        out.bytes.extend(text.as_bytes());
        out
    }

    /// A channel of group `g` with its index and so many properties to follow.
    fn channel(self, name: &str, kind: u32, count: u64, properties: u32) -> Self {
        self.text(&format!("/'g'/'{name}'")).u32(20).u32(kind).u32(1).u64(count).u32(properties)
    }

    /// A channel whose data stand as before.
    fn unchanged(self, name: &str) -> Self {
        self.text(&format!("/'g'/'{name}'")).u32(0).u32(0)
    }

    fn property(self, name: &str, value: f64) -> Self {
        self.text(name).u32(10).f64(value)
    }

    fn words(self, name: &str, value: &str) -> Self {
        self.text(name).u32(0x20).text(value)
    }
}

fn segment(flags: u32, metadata: Bytes, raw: Bytes) -> Vec<u8> {
    let (metadata, raw) = (metadata.bytes, raw.bytes);
    let lead = Bytes::new(flags).u32(4713).u64((metadata.len() + raw.len()) as u64).u64(metadata.len() as u64);
    [b"TDSm".to_vec(), flags.to_le_bytes().to_vec(), lead.bytes, metadata, raw].concat()
}

const I16: u32 = 2;
const F64: u32 = 10;

/// A time and two pressures with three values each, the second of whole numbers.
fn list(flags: u32, count: u64) -> Bytes {
    Bytes::new(flags)
        .u32(3)
        .channel("time", F64, count, 0)
        .channel("p [bar]", F64, count, 0)
        .channel("q", I16, count, 1)
        .words("unit_string", "Volts")
}

fn blocks(flags: u32, from: f64) -> Bytes {
    Bytes::new(flags).f64(from).f64(from + 1.0).f64(10.0).f64(20.0).i16(-3).i16(4)
}

fn rows(flags: u32, from: f64) -> Bytes {
    Bytes::new(flags).f64(from).f64(10.0).i16(-3).f64(from + 1.0).f64(20.0).i16(4)
}

fn values<'a>(record: &'a Record, name: &str) -> &'a [f64] {
    &record.channel(name).unwrap_or_else(|| panic!("no `{name}` in {:?}", record.origin)).values
}

fn check(bytes: &[u8]) {
    let record = read(bytes).unwrap_or_else(|told| panic!("{told}"));
    assert_eq!(record.time, [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(values(&record, "p"), [10e5, 20e5, 10e5, 20e5]);
    assert_eq!(values(&record, "q"), [-3.0, 4.0, -3.0, 4.0]);
    assert_eq!(record.channel("q").unwrap().unit.symbol, "V");
    assert_eq!(record.origin.read_as, "TDMS");
}

/// Every way that segments may say the same.
#[test]
fn segments_say_what_is_new() {
    for order in [0, BIG] {
        let (new, data) = (NEW_LIST | order, DATA_ONLY | order);
        let first = segment(new, list(new, 2), blocks(new, 0.0));
        let none = || Bytes::new(order);
        let second = |flags, metadata| [first.clone(), segment(flags, metadata, blocks(order, 2.0))].concat();
        check(&second(data, none()));
        check(&second(new, list(new, 2)));
        check(&second(new, none().u32(3).unchanged("time").unchanged("p [bar]").unchanged("q")));
        check(&second(CHANGES | order, none().u32(1).unchanged("q")));
        // Two chunks behind one list.
        let both = Bytes { little: order == 0, bytes: [blocks(new, 0.0).bytes, blocks(new, 2.0).bytes].concat() };
        check(&segment(new, list(new, 2), both));
        let (new, data) = (new | INTERLEAVED, data | INTERLEAVED);
        let first = segment(new, list(new, 2), rows(new, 0.0));
        check(&[first, segment(data, none(), rows(order, 2.0))].concat());
    }
}

/// A channel that pauses has no value meanwhile; one that changes its type goes on.
#[test]
fn channels_may_pause_and_change() {
    let first = segment(NEW_LIST, list(0, 2), blocks(0, 0.0));
    let pause = Bytes::new(0).u32(1).text("/'g'/'q'").u32(0xFFFF_FFFF).u32(0);
    let raw = Bytes::new(0).f64(2.0).f64(3.0).f64(10.0).f64(20.0);
    let record = read(&[first.clone(), segment(CHANGES, pause, raw)].concat()).unwrap();
    assert_eq!(values(&record, "p"), [10e5, 20e5, 10e5, 20e5]);
    // Which of the times `q` lacks is not in the file.
    assert_eq!(record.origin.left_out, [("q".to_owned(), "no time with it".to_owned())]);
    let other = Bytes::new(0).u32(1).channel("q", F64, 2, 0);
    let raw = Bytes::new(0).f64(2.0).f64(3.0).f64(10.0).f64(20.0).f64(-3.0).f64(4.0);
    check(&[first, segment(CHANGES, other, raw)].concat());
}

/// LabVIEW writes where a segment ends when it is done with it.
#[test]
fn a_segment_that_was_being_written_is_read_as_far_as_it_goes() {
    let first = segment(NEW_LIST, list(0, 2), blocks(0, 0.0));
    // Rows are kept as far as they are whole; of blocks, which stand behind each other, the last channels would have none.
    for (flags, raw, of_cut) in [(DATA_ONLY, blocks(0, 2.0), 0), (DATA_ONLY | INTERLEAVED, rows(0, 2.0), 1)] {
        let mut second = segment(flags, Bytes::new(0), raw);
        second[12..20].fill(0xFF);
        for (cut, rows) in [(0, 2), (2, of_cut), (second.len() - 28, 0)] {
            let bytes = [&first[..], &second[..second.len() - cut]].concat();
            let record = read(&bytes).unwrap_or_else(|told| panic!("{told}"));
            assert_eq!(record.origin.read_as, "TDMS whose writing broke off: the last segment as far as it goes");
            assert_eq!((record.time.len(), values(&record, "q").len()), (2 + rows, 2 + rows), "{cut}");
        }
    }
    // Even where the list of its channels was not yet written.
    let mut second = segment(NEW_LIST, list(0, 2), Bytes::new(0));
    second[12..28].fill(0xFF);
    second.truncate(50);
    assert_eq!(read(&[first, second].concat()).unwrap().time, [0.0, 1.0]);
}

/// Waveforms: times from their properties, each group at its own rate, brought together by their dates.
#[test]
fn waveforms_have_the_times_of_their_properties() {
    let wave = |out: Bytes, seconds: u64, offset: f64, increment: f64, unit: &str| {
        let out = out.property("wf_increment", increment).property("wf_start_offset", offset);
        out.words("wf_xunit_string", unit).text("wf_start_time").u32(0x44).u64(1 << 63).u64(seconds)
    };
    let file = |second: (u64, f64, f64, &str)| {
        let list = wave(Bytes::new(0).u32(2).channel("a", I16, 2, 4), 3_900_000_000, 0.0, 0.25, "s");
        let list = wave(list.channel("b", I16, 1, 4), second.0, second.1, second.2, second.3);
        segment(NEW_LIST, list, Bytes::new(0).i16(1).i16(2).i16(3))
    };
    let record = read(&file((3_900_000_001, 250.0, 100.0, "ms"))).unwrap();
    assert_eq!(record.time, [0.0, 0.25, 1.25]);
    assert_eq!(values(&record, "a")[..2], [1.0, 2.0]);
    assert_eq!(values(&record, "b")[2], 3.0);
    let left = |second| read(&file(second)).unwrap().origin.left_out.first().cloned().map(|(_, why)| why);
    assert_eq!(left((3_900_000_001, 0.0, 1.0, "Hz")).unwrap(), "its values stand over `Hz`, no time");
    assert_eq!(left((3_900_000_001, 0.0, 0.0, "s")).unwrap(), "its samples are 0 s apart");
}

/// The moments of a channel of time stamps; text beside them is no series.
#[test]
fn stamps_are_times() {
    let list = Bytes::new(0).u32(3).channel("when", 0x44, 2, 0).channel("p [bar]", I16, 2, 0);
    let list = list.text("/'g'/'remark'").u32(28).u32(0x20).u32(1).u64(2).u64(11).u32(0);
    let raw = Bytes::new(0).u64(0).u64(3_900_000_000).u64(1 << 62).u64(3_900_000_001);
    let mut raw = raw.i16(1).i16(2).u32(1).u32(3);
    raw.bytes.extend(b"abc");
    let record = read(&segment(NEW_LIST, list, raw)).unwrap();
    assert_eq!((&record.time[..], values(&record, "p")), (&[0.0, 1.25][..], &[1e5, 2e5][..]));
    assert_eq!(record.origin.left_out, [("remark".to_owned(), "text".to_owned())]);
}

/// Two channels and a digital line of one card, the second channel on its own card with rows of its own.
#[test]
fn raw_data_of_cards_are_scaled() {
    let flags = NEW_LIST | DAQMX;
    let index = |out: Bytes, name: &str, mark: u32, count: u64, buffer: u32, offset: u32| {
        let out = out.text(&format!("/'g'/'{name}'")).u32(mark).u32(0xFFFF_FFFF).u32(1).u64(count).u32(1);
        let mut out = out.u32(if mark == 0x1269 { 3 } else { 0 }).u32(buffer).u32(offset);
        out.bytes.extend(if mark == 0x1269 { vec![0; 4] } else { vec![0] });
        // The scale that the value goes to, then the widths of the rows of both cards.
        out.u32(0).u32(2).u32(5).u32(2)
    };
    let wave = |out: Bytes| out.property("wf_increment", 0.5);
    let linear = |out: Bytes, slope: f64| {
        let out = out.property("NI_Number_Of_Scales", 2.0).words("NI_Scale[1]_Scale_Type", "Linear");
        let out = out.property("NI_Scale[1]_Linear_Slope", slope).property("NI_Scale[1]_Linear_Y_Intercept", 1.0);
        out.property("NI_Scale[1]_Linear_Input_Source", 0.0).words("NI_UnitDescription", "Bar")
    };
    let list = |end: u32| {
        let list = linear(wave(index(Bytes::new(0).u32(3), "a", 0x1269, 2, 0, 2).u32(7)), 0.5);
        let list = wave(index(list, "line", 0x126A, 2, 0, 33).u32(2)).property("NI_Number_Of_Scales", 1.0);
        linear(wave(index(list, "b", 0x1269, 2, 1, end).u32(7)), 2.0)
    };
    let raw = || {
        let mut raw = Bytes::new(0).i16(99).i16(10);
        raw.bytes.push(0b10);
        let mut raw = raw.i16(99).i16(-10);
        raw.bytes.push(0b01);
        raw.i16(7).i16(8)
    };
    let record = read(&segment(flags, list(0), raw())).unwrap_or_else(|told| panic!("{told}"));
    assert_eq!(record.time, [0.0, 0.5]);
    assert_eq!(values(&record, "a"), [6e5, -4e5]);
    assert_eq!(values(&record, "line"), [1.0, 0.0]);
    assert_eq!(values(&record, "b"), [15e5, 17e5]);
    let told = read(&segment(flags, list(1), raw())).unwrap_err();
    assert!(told.contains("damaged: a channel of DAQmx stands outside of the rows of its card"), "{told}");
}

/// Channels of one name in several groups are told apart, and channels with dates are not combined with channels without.
#[test]
fn groups_are_told_apart() {
    let list = |dated: u32| {
        let out = Bytes::new(0).u32(2).channel("p", I16, 1, 1).property("wf_increment", 1.0);
        let out = out.text("/'other'/'p'").u32(20).u32(I16).u32(1).u64(1).u32(1 + dated).property("wf_increment", 1.0);
        if dated == 1 { out.text("wf_start_time").u32(0x44).u64(0).u64(3_900_000_000) } else { out }
    };
    let raw = || Bytes::new(0).i16(1).i16(2);
    let record = read(&segment(NEW_LIST, list(0), raw())).unwrap();
    assert_eq!((values(&record, "g/p"), values(&record, "other/p")), (&[1.0][..], &[2.0][..]));
    let record = read(&segment(NEW_LIST, list(1), raw())).unwrap();
    let why = "its time has no date, but that of other groups has one";
    assert_eq!(record.origin.left_out, [("g/p".to_owned(), why.to_owned())]);
}

/// One message each, with what is wrong and what helps.
#[test]
fn damaged_segments_are_told() {
    let whole = segment(NEW_LIST, list(0, 2), blocks(0, 0.0));
    let list_of = |list: Bytes| segment(NEW_LIST, list, blocks(0, 0.0));
    let with = |at: usize, bytes: &[u8]| {
        let mut out = whole.clone();
        out[at..at + bytes.len()].copy_from_slice(bytes);
        out
    };
    let one = |kind, count| Bytes::new(0).u32(1).channel("p", kind, count, 0);
    for (bytes, what) in [
        (whole[..20].to_vec(), "damaged: it ends before byte 28"),
        (whole[..whole.len() - 1].to_vec(), "damaged: it ends before byte"),
        ([&whole[..], b"TDSx"].concat(), "damaged: it ends before byte"),
        ([&whole[..], &[0; 28]].concat(), "damaged: there is no segment at byte"),
        (with(8, &[1, 0, 0, 0]), "damaged: the segment at byte 0 is of the unknown version 1"),
        (with(20, &[0xFF; 8]), "damaged: the raw data of the segment at byte 0 begin behind its end"),
        (with(28, &[0xFF; 4]), "damaged: a list of its channels is longer than the segment says"),
        (with(32, &[0xFF; 4]), "damaged: a list of its channels is longer than the segment says"),
        (with(36, b"x"), "is no path of a channel"),
        (list_of(one(0x77, 2)), "damaged: values of the unknown type 0x77"),
        (list_of(one(F64, u64::MAX)), "damaged: a channel cannot have 18446744073709551615 values"),
        (list_of(one(F64, 0)), "damaged: a segment has raw data and no channel"),
        (list_of(one(F64, 5)), "damaged: the raw data of a segment end within a value"),
        (
            list_of(Bytes::new(0).u32(1).unchanged("p")),
            "damaged: a channel has its data as before, where there were none",
        ),
        (segment(DATA_ONLY, Bytes::new(0), blocks(0, 0.0)), "damaged: a segment has raw data and no channel"),
        (list_of(one(11, 2)), "holds numbers of the type extended float, which are not read"),
        (b"TDSh".to_vec(), "the file is the index of a TDMS file, which is not read"),
    ] {
        let told = read(&bytes).unwrap_err();
        assert!(told.starts_with("error: RECORD: the ") && told.contains(what), "{what}: {told}");
        assert!(told.contains("\n  help: "), "{told}");
    }
}
