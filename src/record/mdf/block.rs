//! Blocks of MDF 4: a name of four letters, links to other blocks, then data.

use std::collections::HashSet;

use crate::record::bytes::{Broken, part, u64_at};

/// The file, and how much of it has been followed.
pub(super) struct File<'a> {
    pub bytes: &'a [u8],
    /// Where blocks of groups, channels and data have been visited: links may lead in circles.
    visited: HashSet<u64>,
}

/// One block.
pub(super) struct Block<'a> {
    pub id: &'a [u8],
    bytes: &'a [u8],
    links: usize,
}

impl<'a> File<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, visited: HashSet::new() }
    }

    /// The block at an address; `None` where the address is that of no block.
    pub fn block(&self, address: u64) -> Result<Option<Block<'a>>, Broken> {
        if address == 0 {
            return Ok(None);
        }
        let start = usize::try_from(address).unwrap_or(usize::MAX);
        let head = part(self.bytes, start, 24)?;
        if !head.starts_with(b"##") {
            return Err(Broken::damaged(format!("there is no block at byte {start}")));
        }
        let length = usize::try_from(u64_at(head, 8, true)?).unwrap_or(usize::MAX);
        let links = usize::try_from(u64_at(head, 16, true)?).unwrap_or(usize::MAX);
        let bytes = part(self.bytes, start, length)?;
        if links > length / 8 || 24 + 8 * links > length {
            return Err(Broken::damaged(format!("the block at byte {start} has more links than it is long")));
        }
        Ok(Some(Block { id: part(head, 0, 4)?, bytes, links }))
    }

    /// The block at an address that no other one may lead to.
    pub fn once(&mut self, address: u64) -> Result<Option<Block<'a>>, Broken> {
        if address != 0 && !self.visited.insert(address) {
            return Err(Broken::damaged("its blocks lead in a circle"));
        }
        self.block(address)
    }

    /// The same, of a block that must be one of this name.
    pub fn once_named(&mut self, address: u64, id: &[u8]) -> Result<Option<Block<'a>>, Broken> {
        self.once(address)?;
        self.named(address, id)
    }

    /// The block at an address, which must be one of this name.
    pub fn named(&self, address: u64, id: &[u8]) -> Result<Option<Block<'a>>, Broken> {
        match self.block(address)? {
            Some(block) if block.id != id => {
                let (found, wanted) = (String::from_utf8_lossy(block.id), String::from_utf8_lossy(id));
                Err(Broken::damaged(format!("a block {found} stands where {wanted} should")))
            }
            block => Ok(block),
        }
    }

    /// The text at an address: plain, or within the `<TX>` of a comment.
    pub fn text(&self, address: u64) -> Result<Option<String>, Broken> {
        let Some(block) = self.block(address)? else { return Ok(None) };
        let data = block.data();
        let end = data.iter().position(|byte| *byte == 0).unwrap_or(data.len());
        let text = String::from_utf8_lossy(data.get(..end).unwrap_or_default()).into_owned();
        if block.id != b"##MD" {
            return Ok(Some(text.trim().to_owned()));
        }
        let inner = text.split_once("<TX>").and_then(|(_, rest)| rest.split_once("</TX>"));
        Ok(inner.map(|(inner, _)| inner.trim().to_owned()))
    }
}

impl<'a> Block<'a> {
    /// Where link `index` leads; 0 where there is none.
    pub fn link(&self, index: usize) -> u64 {
        if index >= self.links {
            return 0;
        }
        u64_at(self.bytes, 24 + 8 * index, true).unwrap_or(0)
    }

    pub fn links(&self) -> usize {
        self.links
    }

    /// What stands behind the links.
    pub fn data(&self) -> &'a [u8] {
        self.bytes.get(24 + 8 * self.links..).unwrap_or_default()
    }
}
