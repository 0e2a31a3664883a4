//! Records in ASAM MDF 4: groups of channels, each group with its own time.

mod block;
mod channel;
mod data;

use super::bytes::{Broken, integer, part, u32_at, u64_at};
use super::groups::{Column, Group, Groups};
use block::{Block, File};
use channel::Channel;

/// Most numbers that are taken from one file.
const MOST_NUMBERS: usize = 1 << 27;

/// A group of channels that are written together.
struct Layout {
    record_id: u64,
    /// Bytes of a record without its id, and behind how many of them the invalidation bits begin.
    length: usize,
    invalid: usize,
    /// Records of varying length stand behind their length.
    variable: bool,
    channels: Vec<Channel>,
}

/// The series of a file; `most` is how many bytes may be unpacked.
pub(super) fn read(bytes: &[u8], most: u64) -> Result<Groups, Broken> {
    let mut file = File::new(bytes);
    let head = file.named(64, b"##HD")?.ok_or_else(|| Broken::damaged("it has no header"))?;
    let mut groups = Groups::default();
    let (mut left, mut numbers) = (most, MOST_NUMBERS);
    let mut next = file.once_named(head.link(0), b"##DG")?;
    while let Some(data_group) = next {
        let layouts = layouts(&mut file, &data_group)?;
        let mut records = Vec::new();
        data::gather(&mut file, data_group.link(2), &mut records, left)?;
        left -= records.len() as u64;
        let id_size = part(data_group.data(), 0, 1)?[0] as usize;
        if !matches!(id_size, 0 | 1 | 2 | 4 | 8) {
            return Err(Broken::damaged(format!("its records have an id of {id_size} bytes")));
        }
        let sorted = sort(&records, &layouts, id_size)?;
        for (layout, records) in layouts.into_iter().zip(sorted) {
            take(&mut groups, layout, &records, &mut numbers)?;
        }
        next = file.once_named(data_group.link(0), b"##DG")?;
    }
    Ok(groups)
}

fn layouts(file: &mut File<'_>, data_group: &Block<'_>) -> Result<Vec<Layout>, Broken> {
    let mut layouts = Vec::new();
    let mut next = file.once_named(data_group.link(1), b"##CG")?;
    while let Some(group) = next {
        let data = group.data();
        let (bytes, invalid) = (u32_at(data, 24, true)? as usize, u32_at(data, 28, true)? as usize);
        let mut channels = Vec::new();
        let mut channel = file.once_named(group.link(1), b"##CN")?;
        while let Some(block) = channel {
            channels.push(Channel::read(file, &block)?);
            channel = file.once_named(block.link(0), b"##CN")?;
        }
        layouts.push(Layout {
            record_id: u64_at(data, 0, true)?,
            length: bytes + invalid,
            invalid: bytes,
            variable: part(data, 16, 1)?[0] & 1 != 0,
            channels,
        });
        next = file.once_named(group.link(0), b"##CG")?;
    }
    Ok(layouts)
}

/// The records of each group, in the order of the groups.
fn sort<'a>(records: &'a [u8], layouts: &[Layout], id_size: usize) -> Result<Vec<Vec<&'a [u8]>>, Broken> {
    let mut sorted: Vec<Vec<&[u8]>> = vec![Vec::new(); layouts.len()];
    let mut at = 0;
    while at < records.len() {
        let index = if id_size == 0 {
            0
        } else {
            let id = integer(part(records, at, id_size)?, true);
            let known = layouts.iter().position(|layout| layout.record_id == id);
            known.ok_or_else(|| Broken::damaged(format!("a record has the unknown id {id}")))?
        };
        at += id_size;
        let Some(layout) = layouts.get(index) else { break };
        let length = if layout.variable {
            at += 4;
            u32_at(records, at - 4, true)? as usize
        } else {
            layout.length
        };
        if length + id_size == 0 {
            return Err(Broken::damaged("its records have no length"));
        }
        // What a logger was writing when it was switched off is no record.
        let Ok(record) = part(records, at, length) else { break };
        if let Some(own) = sorted.get_mut(index) {
            own.push(record);
        }
        at += length;
    }
    Ok(sorted)
}

fn take(groups: &mut Groups, layout: Layout, records: &[&[u8]], numbers: &mut usize) -> Result<(), Broken> {
    if layout.variable {
        return Ok(());
    }
    let mut group = Group::default();
    for channel in layout.channels {
        if let Some(why) = channel.lacks() {
            groups.leave(channel.name, why);
            continue;
        }
        *numbers = numbers.checked_sub(records.len()).ok_or(Broken::TooLarge)?;
        let values = records.iter().enumerate().map(|(row, record)| channel.value(record, layout.invalid, row));
        let values = values.collect::<Result<Vec<f64>, Broken>>()?;
        match (channel.kind, channel.sync) {
            (2 | 3, 0 | 1) => {
                group.time = values;
                group.time_unit = channel.unit.unwrap_or_else(|| "s".to_owned());
            }
            (2 | 3, _) => groups.leave(channel.name, "a master that is no time"),
            _ => group.columns.push(Column { name: channel.name, unit: channel.unit, values }),
        }
    }
    groups.push(group);
    Ok(())
}
