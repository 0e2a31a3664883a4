//! Records in TDMS, as LabVIEW writes them: segments, each with what is new about the channels and then with values of them.
//!
//! The format is that of NI's paper "TDMS File Format Internal Structure".

mod cursor;
mod daqmx;
mod kind;
mod object;
mod raw;
mod scale;
mod segment;
mod series;

use super::bytes::Broken;
use super::groups::Groups;
use object::Objects;
use raw::Raw;
use segment::Segment;

/// The series of a file.
///
/// A segment whose end was never written, as the last one is when LabVIEW crashes, is read as far as it goes, and the record says so.
///
/// # Errors
/// What is damaged, or of a type that is not read; more numbers than are read.
pub(super) fn read(bytes: &[u8]) -> Result<Groups, Broken> {
    let (mut objects, mut raw) = (Objects::default(), Raw::new());
    let (mut at, mut broke_off) = (0, false);
    while at < bytes.len() {
        let segment = Segment::at(bytes, at)?;
        broke_off |= segment.unfinished;
        if let Some(metadata) = segment.metadata {
            objects.update(metadata, segment.little, segment.new_list)?;
            raw.take(&mut objects, &segment)?;
        }
        at = segment.end;
    }
    let mut groups = series::gather(objects);
    if broke_off {
        groups.remark("whose writing broke off: the last segment as far as it goes");
    }
    Ok(groups)
}
