//! Faults: the parameter, its healthy value, and the range to search.

use crate::complaint::{Complaint, Kind};
use crate::rig::source::Value;
use crate::rig::{Fault, Parameter, Rig, range};
use crate::units::Quantity;

pub(super) fn read_fault(rig: &mut Rig, id: &str, value: &Value<'_>) -> Result<(), Complaint> {
    let Some(parameter) = rig.parameter(id) else {
        return Err(Complaint::new(Kind::UnknownName, format!("fault on `{id}`, which is no parameter of this rig"))
            .at(value.place())
            .help(rig.help_with_parameters(id)));
    };
    if rig.parameters[parameter].role.is_of_the_drive() {
        return Err(Complaint::new(
            Kind::Contradiction,
            format!("`{id}` cannot be a fault: it is of what drives the rig"),
        )
        .at(value.place())
        .help("how a spool follows its command is found by itself; as a fault take the `lag` of a part"));
    }
    let (dimension, limits) = (rig.parameters[parameter].unit.dimension, rig.parameters[parameter].bounds);
    let table = value.table(format!("fault `{id}`"))?;
    let healthy = match table.get("healthy") {
        None => rig.parameters[parameter].value,
        Some(value) => {
            let stated = value.quantity(dimension)?;
            rig.parameters[parameter].unit = stated.unit;
            stated.value
        }
    };
    let bounds_value = table.require("bounds", "add the range to search, such as `bounds = [\"0 mm\", \"0.4 mm\"]`")?;
    let list = bounds_value.list()?;
    let [low, high] = list.as_slice() else {
        return Err(Complaint::new(Kind::Shape, format!("`bounds` of fault `{id}` has {} entries", list.len()))
            .at(bounds_value.place())
            .help("write two: the lowest and the highest value to search"));
    };
    let (low, high) = (low.quantity(dimension)?.value, high.quantity(dimension)?.value);
    if !(low < high && low >= limits.0 && high <= limits.1 && (low..=high).contains(&healthy)) {
        let unit = &rig.parameters[parameter].unit;
        let shown = |value: f64| Quantity { value, unit: unit.clone() };
        return Err(Complaint::new(
            Kind::Bounds,
            format!(
                "`bounds` of fault `{id}` do not fit: {} to {}, healthy {}",
                shown(low),
                shown(high),
                shown(healthy)
            ),
        )
        .at(bounds_value.place())
        .help(format!("the lower one first, the healthy value between them, both {}", range(limits, unit))));
    }
    let limit = match table.get("limit") {
        None => None,
        Some(limit) => Some(read_limit(rig, id, &limit, parameter, healthy, (low, high))?),
    };
    table.finish()?;
    throughout(&mut rig.parameters[parameter]);
    rig.faults.push(Fault { parameter, healthy, bounds: (low, high), limit, place: value.place() });
    Ok(())
}

/// A fault is one value throughout: what may be another in each switching is as uncertain in a healthy rig as the file states, and where
/// it states nothing exact but for a calibration.
fn throughout(parameter: &mut Parameter) {
    if parameter.varies() && parameter.spread == 0.0 {
        (parameter.spread, parameter.sigma) = (parameter.sigma, 0.0);
    }
    parameter.per_event = false;
}

/// The value from which the part no longer serves: reached on the way from the healthy value to a bound of the search.
fn read_limit(
    rig: &Rig,
    id: &str,
    value: &Value<'_>,
    parameter: usize,
    healthy: f64,
    bounds: (f64, f64),
) -> Result<f64, Complaint> {
    let unit = &rig.parameters[parameter].unit;
    let limit = value.quantity(unit.dimension)?.value;
    let shown = |value: f64| Quantity { value, unit: unit.clone() };
    if limit == healthy {
        return Err(Complaint::new(
            Kind::Contradiction,
            format!("`limit` of fault `{id}` is its healthy value, {}", shown(healthy)),
        )
        .at(value.place())
        .help("write the value from which the part no longer serves"));
    }
    if !(bounds.0..=bounds.1).contains(&limit) {
        return Err(Complaint::new(
            Kind::Bounds,
            format!("`limit` of fault `{id}` is {}, outside the range that is searched", shown(limit)),
        )
        .at(value.place())
        .help(format!("a value that is searched, {}", range(bounds, unit))));
    }
    Ok(limit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_that_is_a_fault_is_one_value_throughout() {
        let text = std::fs::read_to_string("fixtures/telescopic/rig.toml").unwrap();
        let text = text.replace("[faults]", "[faults]\n\"directional_valve.lag\" = { bounds = [\"2 ms\", \"40 ms\"] }");
        let lag = |text: String| {
            let rig = Rig::parse("rig.toml", text).unwrap();
            let lag = &rig.parameters[rig.parameter("directional_valve.lag").unwrap()];
            (lag.is_uncertain(), lag.varies(), lag.sigma, lag.spread)
        };
        // As uncertain as stated; where nothing is stated exact, and for a calibration as far off as lags are, a quarter.
        let stated = text.replace("lag = \"8 ms\"", "lag = \"8 ms +- 0.5 ms\"");
        assert_eq!(lag(stated), (true, false, 0.5e-3, 0.5e-3));
        assert_eq!(lag(text), (false, false, 0.0, 2e-3));
    }
}
