//! Effects: physics beyond that of the components.

use crate::complaint::{Complaint, Kind};
use crate::rig::source::Value;
use crate::rig::{ParameterSetting, Rig, range};

pub(super) fn read_effect(rig: &mut Rig, id: &str, value: &Value<'_>) -> Result<(), Complaint> {
    let here = |mut complaint: Complaint| {
        complaint.places = vec![value.place()];
        complaint
    };
    let placed = rig.placed(id).map_err(here);
    let table = value.table(format!("effect `{id}`"));
    let placed = placed.map_err(|complaint| match &table {
        Ok(table) if table.get("at").is_some() => complaint.help(format!(
            "an effect as a formula of your own stands in `[own_effects.{}]`",
            id.split('@').next().unwrap_or(id)
        )),
        _ => complaint,
    })?;
    let table = table?;
    let names: Vec<&str> = match placed.effect.form.card() {
        Some(card) => card.parameters.iter().map(|own| own.name).collect(),
        None => placed.effect.parameters.iter().map(|free| free.name).collect(),
    };
    let (mut given, mut written) = (Vec::new(), Vec::new());
    for name in names {
        let Some(entry) = table.get(name) else { continue };
        let stated = entry.stated(rig.effect_unit(&placed, name).dimension)?;
        given.push(ParameterSetting { name: name.to_owned(), value: stated.value, sigma: stated.sigma.unwrap_or(0.0) });
        written.push((name, stated.unit, entry.place()));
    }
    table.finish()?;
    if let Some(first) = placed.effect.parameters.first()
        && given.iter().all(|given| given.name != first.name)
    {
        return Err(Complaint::new(Kind::MissingEntry, format!("effect `{id}` has no `{}`", first.name))
            .at(value.place())
            .help(format!("add `{} = \"...\"`: {}", first.name, placed.effect.meaning)));
    }
    let indices = rig.give_effect(&placed, &given).map_err(here)?;
    for (free, &index) in placed.effect.parameters.iter().zip(&indices) {
        let Some((_, unit, place)) = written.iter().find(|(name, ..)| *name == free.name) else { continue };
        let parameter = &mut rig.parameters[index];
        (parameter.unit, parameter.place) = (unit.clone(), place.clone());
        if !(parameter.bounds.0..=parameter.bounds.1).contains(&parameter.value) {
            return Err(Complaint::new(Kind::Bounds, format!("`{}` is outside its physical bounds", parameter.id))
                .at(place.clone())
                .help(format!("{}: {}", parameter.meaning, range(parameter.bounds, unit))));
        }
    }
    Ok(())
}
