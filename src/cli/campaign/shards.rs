//! `campaign --shard` and `--merge`: a campaign in pieces that any number of processes do, on one machine or many.

use std::io::Write;
use std::path::Path;

use super::{Arguments, Begun, present};
use crate::campaign::Row;
use crate::campaign::store::{FORM, Finished, Work, write_cases};
use crate::cli::{Failure, Format, Status, write_json};
use crate::shards::{Done, Found, Hold, Share, merge, put_in_order};

/// Does one shard, or says that it is done.
pub fn run(
    begun: &Begun<'_>,
    shard: Share,
    work: &Path,
    hold: &Hold<'_>,
    arguments: &Arguments,
    out: &mut dyn Write,
) -> Result<Status, Failure> {
    let Begun { campaign, digest, .. } = begun;
    let folder = shard.folder(work);
    let (mut journal, mut rows) = match Found::of(&folder, &FORM, digest, shard, hold)? {
        Found::Done(done, by) => return Ok(say(&done, by, &folder, arguments, out)?),
        Found::Open(journal, rows) => (journal, rows),
    };
    let cases = campaign.cases_of(shard);
    begun.run(cases.clone(), &mut rows, Some(&mut journal))?;
    put_in_order(&mut rows);
    write_cases(&folder, &rows)?;
    let done = Done::new(&FORM, digest, shard, cases, campaign.whole());
    done.write(&folder)?;
    Ok(say(&done, "done", &folder, arguments, out)?)
}

fn say(
    done: &Done<Work>,
    how: &str,
    folder: &Path,
    arguments: &Arguments,
    out: &mut dyn Write,
) -> std::io::Result<Status> {
    match arguments.format {
        Format::Json => write_json(out, done)?,
        Format::Text => {
            let [from, to] = done.range;
            let what = match done.count {
                0 => "no cases, as there are fewer rigs than shards (`--rigs`)".to_owned(),
                1 => format!("case {from}"),
                count => format!("{count} cases, {from} to {}", to - 1),
            };
            writeln!(out, "{}: shard {}, {what}: {how}", folder.display(), done.shard)?;
        }
    }
    Ok(Status::Done)
}

/// Puts the shards in a folder together, as if one process had run the campaign.
pub fn put_together(work: &Path, arguments: &Arguments, out: &mut dyn Write) -> Result<Status, Failure> {
    let (whole, rows) = merge::<Work, Row>(work, &FORM)?;
    present(&Finished::new(whole, rows), arguments, out)
}
