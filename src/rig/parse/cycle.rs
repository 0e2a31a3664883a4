//! The cycle: phases, and how each input runs over them.

use crate::complaint::{Complaint, Kind};
use crate::rig::source::Value;
use crate::rig::{Cycle, Phase, Profile, Rig};
use crate::units::Dimension;

/// Most rows of a cycle: a rig file must not be able to fill the memory.
const MOST_ROWS: f64 = 1e6;
/// Most phases of a cycle: one for each hundred rows of the longest.
const MOST_PHASES: usize = 10_000;

pub(super) fn read_cycle(rig: &Rig, value: &Value<'_>) -> Result<Cycle, Complaint> {
    let table = value.table("`[cycle]`")?;
    let interval_value = table.require("interval", "add the time between samples, such as `interval = \"4 ms\"`")?;
    let interval = interval_value.quantity(Dimension::TIME)?.value;
    if interval <= 0.0 {
        return Err(Complaint::new(Kind::Bounds, "the interval of the cycle is not positive")
            .at(interval_value.place())
            .help("write the time between samples, above 0 s"));
    }
    let phases_value = table.require("phases", "add `phases = [ { duration = \"1 s\", ... } ]`")?;
    let mut phases = Vec::new();
    let listed = phases_value.list()?;
    if listed.len() > MOST_PHASES {
        return Err(Complaint::new(Kind::Bounds, format!("the cycle has {} phases", listed.len()))
            .at(phases_value.place())
            .help(format!("no more than {MOST_PHASES}; longer runs come from a record, with `--input`")));
    }
    for (number, value) in listed.iter().enumerate() {
        let table = value.table(format!("phase {} of `[cycle]`", number + 1))?;
        let duration = table.require("duration", "add `duration = \"1 s\"`")?;
        let duration = (duration.quantity(Dimension::TIME)?.value, duration.place());
        if duration.0 <= 0.0 {
            return Err(Complaint::new(Kind::Bounds, "a phase of no duration")
                .at(duration.1)
                .help("write a time above 0 s"));
        }
        let mut inputs = Vec::new();
        for input in &rig.inputs {
            let value = table.require(&input.name, &format!("give `{}` in this phase", input.name))?;
            let quantity = |value: &Value<'_>| value.quantity(input.unit.dimension).map(|quantity| quantity.value);
            inputs.push(if value.is_list() {
                match value.list()?.as_slice() {
                    [from, to] => Profile { from: quantity(from)?, to: quantity(to)? },
                    _ => {
                        return Err(Complaint::new(
                            Kind::Shape,
                            format!("{} needs two entries, start and end", value.what),
                        )
                        .at(value.place())
                        .help("write `[START, END]`, or one value where the input stands still"));
                    }
                }
            } else {
                let constant = quantity(&value)?;
                Profile { from: constant, to: constant }
            });
        }
        table.finish()?;
        phases.push(Phase { duration: duration.0, inputs });
    }
    table.finish()?;
    if phases.is_empty() {
        return Err(Complaint::new(Kind::Empty, "the cycle has no phases")
            .at(phases_value.place())
            .help("add `{ duration = \"1 s\", ... }` with a value for every input"));
    }
    let cycle = Cycle { interval, phases };
    let rows = cycle.duration() / interval;
    if rows > MOST_ROWS {
        return Err(Complaint::new(Kind::Bounds, format!("the cycle has {rows:.1e} rows"))
            .at(phases_value.place())
            .help(format!("no more than {MOST_ROWS:.0e}: write a longer `interval` or shorter phases")));
    }
    Ok(cycle)
}
