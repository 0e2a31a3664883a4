//! The schemas of what the verbs write as JSON, from the types that they write.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::campaign::alone::Alone;
use super::manifest::Merged;
use crate::calibration::CalibrationReport;
use crate::check::CheckReport;
use crate::finding::WithFindings;
use crate::finding::lacking::WithFinding;
use crate::finding::measured::WithEvents;
use crate::learn::addition::AdditionReport;
use crate::report::components::ComponentsReport;
use crate::report::effects::LibraryReport;
use crate::report::ledger::Ledger;
use crate::report::provenance::WithProvenance;
use crate::shards::Done;
use crate::simulation::SimulationReport;
use crate::{campaign, diagnosis, fleet, history, isolability};

/// Each schema with its name, such as `borescope.check/1`; a description, with the unit where there is one, stands with every key that
/// has one in the code.
pub fn schemas() -> Vec<(String, Value)> {
    vec![
        of::<WithProvenance<AdditionReport>>("addition"),
        of::<WithProvenance<CalibrationReport>>("calibration"),
        of::<campaign::store::Finished>("campaign"),
        of::<Alone<'_>>("campaign-case"),
        of::<Done<campaign::store::Work>>("campaign-shard"),
        of::<CheckReport>("check"),
        of::<WithProvenance<WithEvents<'_>>>("comparison"),
        of::<ComponentsReport>("components"),
        of::<WithProvenance<WithFindings<'_>>>("diagnosis"),
        of::<Done<fleet::rows::Work>>("diagnosis-shard"),
        of::<LibraryReport>("effects"),
        of::<fleet::Fleet>("fleet"),
        of::<history::History>("history"),
        of::<WithProvenance<Ledger>>("improvement"),
        of::<WithProvenance<isolability::IsolabilityReport>>("isolability"),
        of::<Merged<'_>>("records"),
        of::<SimulationReport>("simulation"),
        of::<WithProvenance<WithFinding<'_>>>("suggestion"),
        of::<diagnosis::watch::Watched>("windows"),
    ]
}

fn of<T: JsonSchema>(verb: &str) -> (String, Value) {
    let name = format!("borescope.{verb}/1");
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let mut schema = Value::from(settings.into_generator().into_root_schema_for::<T>());
    plain(&mut schema);
    schema["title"] = json!(name);
    schema["$comment"] = json!("Keys may be added under one number, none is renamed or removed.");
    schema["properties"]["schema"] = json!({ "description": "Name and version of this schema.", "const": name });
    (name, schema)
}

/// Without names and widths of types of this program, and with each description in one line.
fn plain(schema: &mut Value) {
    match schema {
        Value::Object(words) => {
            if words.get("format").is_some_and(Value::is_string) {
                words.remove("format");
            }
            if let Some(Value::String(text)) = words.get_mut("description") {
                *text = text.split_whitespace().collect::<Vec<_>>().join(" ");
            }
            words.values_mut().for_each(plain);
        }
        Value::Array(all) => all.iter_mut().for_each(plain),
        _ => {}
    }
}
