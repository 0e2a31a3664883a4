//! `diagnose`: what is wrong in a record, how large, how sure.

use std::io::Write;
use std::path::Path;

use super::diagnose_arguments::Arguments;
use super::keep::Keeper;
use super::{Failure, Format, Status, manifest, terminal, windows, write_file, write_json, write_page};
use crate::complaint::{Complaint, Kind};
use crate::context::Context;
use crate::diagnosis::watch::Watching;
use crate::diagnosis::{Diagnosed, DiagnosisOptions, Verdict};
use crate::finding::{Finding, WithFindings, findings};
use crate::learn::behind::diagnose;
use crate::model::Model;
use crate::record::survey::Doubt;
use crate::report::caveats::left_out;
use crate::report::curves::Curves;
use crate::report::diagnosis::write_styled;
use crate::report::findings::{Left, brief};
use crate::report::pages::diagnosis::html;
use crate::report::provenance::{Provenance, WithProvenance};
use crate::rig::Rig;

/// A record that is diagnosed.
struct Done {
    diagnosed: Diagnosed,
    findings: Vec<Finding>,
    provenance: Provenance,
}

/// Stretches that the fit leaves out that are told one by one on standard error.
const NOTED: usize = 3;

/// Declares every file of the run.
fn declare(arguments: &Arguments) -> Result<(), Complaint> {
    let outputs = arguments.overwriting.outputs().reading(arguments.records.iter().chain(&arguments.rig));
    let outputs = match &arguments.store {
        Some(store) => outputs.adding_to(store)?,
        None => outputs,
    };
    outputs.writing_all(arguments.report.iter().chain(&arguments.curves))?;
    Ok(())
}

pub fn run(arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    match (&arguments.merge, &arguments.manifest, &arguments.rig) {
        (Some(work), ..) => manifest::put_together(work, arguments, out),
        (None, Some(list), _) => manifest::run(list, arguments, context, out),
        (None, None, Some(rig)) => one_by_one(rig, arguments, context, out),
        // The command line asks for it.
        (None, None, None) => Err(Complaint::new(Kind::MissingEntry, "a diagnosis needs a rig file").into()),
    }
}

/// Diagnoses the records of the command line one after the other.
fn one_by_one(rig: &Path, arguments: &Arguments, context: &Context, out: &mut dyn Write) -> Result<Status, Failure> {
    let outputs = [("--report", &arguments.report), ("--curves", &arguments.curves)];
    for (option, _) in outputs.iter().filter(|(_, path)| path.is_some()) {
        if arguments.records.len() > 1 {
            let what = format!("`{option}` with more than one record");
            return Err(Complaint::new(Kind::Contradiction, what)
                .help("write one file per record: call `diagnose` once for each")
                .into());
        }
    }
    declare(arguments)?;
    arguments.window.map_or(Ok(()), windows::check)?;
    let rig = Rig::read(rig)?.with_context(context);
    super::read::doubts_of(&rig);
    if let Some(window) = arguments.window {
        let watching = Watching { window, fits: arguments.fits };
        let model = Model::new(rig);
        let found = windows::run(&model, &arguments.records, watching, arguments.format, out)?;
        return Ok(if arguments.exit_code { found } else { Status::Done });
    }
    let (store, at) = (arguments.store.as_deref(), arguments.at.as_deref());
    let mut keeper = Keeper::open(store, at, arguments.records.len(), &rig)?;
    let model = Model::new(rig);
    let options = DiagnosisOptions::default();
    let style = terminal::style();
    let mut done: Vec<Done> = Vec::new();
    let mut bad: Vec<Complaint> = Vec::new();
    for (number, path) in arguments.records.iter().enumerate() {
        if arguments.records.len() > 1 {
            terminal::prefix(format!("record {} of {}, ", number + 1, arguments.records.len()));
        }
        let one = super::read::fitted(&model.rig, path).and_then(|record| {
            let diagnosed = diagnose(&model, &record, &options)?;
            // Values that are missing were told when the record was read.
            let found = diagnosed.diagnosis.left_out.iter().filter(|finding| finding.doubt != Doubt::Dropout);
            for words in left_out(found, NOTED) {
                terminal::note(format_args!("note: {}: left out of the fit: {words}", path.display()));
            }
            if let Some(keeper) = &mut keeper {
                keeper.keep(&record, &options, &diagnosed.diagnosis)?;
            }
            let provenance = Provenance::of(&model.rig, [&record]);
            let record = diagnosed.record(&record);
            if let Some(path) = &arguments.curves {
                let curves = Curves { model: &diagnosed.healthy, found: &diagnosed.model };
                write_file(path, |file| curves.write_csv(&model.rig, record, file))?;
            }
            let found = diagnosed.other_rig.clone().map(Model::new);
            let findings = findings(found.as_ref().unwrap_or(&model), record, &diagnosed.diagnosis)?;
            if let Some(report) = &arguments.report {
                write_page(report, &html(&model.rig, record, &diagnosed, (&findings, store))?)?;
            }
            Ok(Done { diagnosed, findings, provenance })
        });
        match one {
            Ok(one) => {
                if arguments.format == Format::Text {
                    if number > 0 {
                        writeln!(out)?;
                    }
                    terminal::clear();
                    let page = match arguments.all {
                        true => one.provenance.below(write_styled(&one.diagnosed, &model.rig, style)),
                        false => brief(
                            &one.diagnosed.diagnosis,
                            &one.findings,
                            style,
                            Left { page: arguments.report.is_some(), store },
                        ),
                    };
                    out.write_all(page.as_bytes())?;
                    out.flush()?;
                }
                done.push(one);
            }
            Err(complaint) => bad.push(complaint),
        }
    }
    if arguments.format == Format::Json {
        let answers = done.iter().map(|one| WithProvenance {
            result: WithFindings { diagnosis: &one.diagnosed.diagnosis, findings: &one.findings },
            provenance: one.provenance.clone(),
        });
        let diagnoses: Vec<_> = answers.collect();
        match diagnoses.as_slice() {
            [] => {}
            [one] if arguments.records.len() == 1 => write_json(out, one)?,
            several => write_json(out, &several)?,
        }
    }
    if !bad.is_empty() {
        return Err(Failure::Complaints(bad));
    }
    let is_well = |Done { diagnosed: one, .. }: &Done| {
        one.diagnosis.verdict == Verdict::Healthy && one.diagnosis.common_cause.is_none()
    };
    let found = !done.iter().all(is_well);
    Ok(if arguments.exit_code && found { Status::Found } else { Status::Done })
}
