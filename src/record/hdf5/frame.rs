//! A DataFrame as `to_hdf` of pandas writes it: names in one dataset, their columns beside each other in another.

use hdf5_reader::{Dataset, group::Group};

use super::number::Numeric;
use super::{PACKED, Variables, Walk, broken, text};
use crate::record::bytes::Broken;
use crate::record::groups::{is_time, split_name};
use crate::record::mat::Value;

/// Whether a group is such a frame.
pub(super) fn is_frame(group: &Group) -> bool {
    group.attribute("pandas_type").ok().and_then(|kind| text(&kind)).as_deref() == Some("frame")
}

impl Walk {
    /// The columns of all blocks; the index is the time where no column is.
    pub(super) fn frame(&mut self, datasets: &[Dataset]) -> Result<Vec<(String, Value)>, Broken> {
        let named = |name: &str| datasets.iter().find(|dataset| dataset.name() == name);
        let mut variables = Variables::default();
        for items in datasets {
            let Some(block) = items.name().strip_suffix("_items") else { continue };
            let Some(values) = named(&format!("{block}_values")) else { continue };
            let names = items.read_strings().map_err(broken)?;
            for (head, value) in names.iter().zip(self.block(values, names.len())?) {
                variables.take(head, None, value);
            }
        }
        let index = named("axis1").filter(|_| !variables.values.iter().any(|(name, _)| is_time(name)));
        if let Some(index) = index
            && let Some(name) = index.attribute("name").ok().and_then(|name| text(&name))
            && is_time(&split_name(&name).0)
        {
            let value = self.dataset(index)?;
            variables.take(&name, None, value);
        }
        Ok(variables.with_units())
    }

    /// The columns of one block, which holds its rows one after the other.
    fn block(&mut self, values: &Dataset, count: usize) -> Result<Vec<Value>, Broken> {
        let Some(numeric) = Numeric::of(values.dtype()) else {
            return Ok((0..count).map(|_| Value::Other("no numbers")).collect());
        };
        if values.shape().get(1..) != Some(&[count as u64]) {
            return Err(Broken::damaged(format!("a block of its frame is not as wide as its {count} names")));
        }
        let Some(raw) = self.raw(values, 1)? else { return Ok((0..count).map(|_| PACKED).collect()) };
        let column = |index: usize| numeric.series(&raw, index * numeric.width, count * numeric.width);
        Ok((0..count).map(|index| Value::vector(column(index))).collect())
    }
}
