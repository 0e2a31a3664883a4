//! Everything that borescope promises, by room; what several tests need is in `support`.

mod support {
    pub mod below;
    pub mod browser;
    pub mod cards;
    pub mod circuit;
    pub mod command;
    pub mod curve;
    pub mod cycle;
    pub mod formula;
    pub mod leaking;
    pub mod long_record;
    pub mod page;
    pub mod plant;
    pub mod steady;
    pub mod study;
    #[cfg(unix)]
    pub mod tab;
    pub mod telescopic;

    #[path = "../../../fixtures/bench/stroke.rs"]
    pub mod stroke;
}

mod circuit {
    mod closed_form;
    mod component_cards;
    mod effect_cards;
    mod energy;
    mod inputs;
    mod kinks;
    mod meters;
    mod onset_slopes;
    mod other_machines;
    mod own_effects;
    mod plant;
    mod properties;
    mod run;
    mod solvers;
    mod viscosity;
}

mod cli {
    #[cfg(target_os = "linux")]
    mod bad_input;
    mod begin;
    mod complaint_text;
    mod damaged_inputs;
    mod desk;
    mod diagnose;
    mod fitted;
    mod fleet;
    #[cfg(unix)]
    mod interrupt;
    mod json_schema;
    mod learn;
    #[cfg(target_os = "linux")]
    mod output_faults;
    mod record;
    mod report;
    mod rig_wrong;
    mod signatures;
    mod simulate;
    mod store;
    mod terminal;
    mod threads;
    mod windows;
}

mod diagnosis {
    mod ambiguous;
    mod calibrate;
    mod calibration_honest;
    mod campaign;
    mod common_cause;
    mod consequences;
    mod context;
    mod cycle;
    mod data_sheet;
    mod effort;
    mod honest;
    mod measured;
    mod of_record;
    mod open_records;
    mod settings;
    mod starts;
    mod store;
    mod switching;
}

mod docs {
    mod add_a_component;
    mod ambiguities;
    mod links;
    mod map;
    mod noise;
    mod paper_figures;
    mod pictures;
    mod reference;
    mod studies;
    mod tutorial;
}

mod fit {
    mod behaviour;
    mod intervals;
    mod nist;
    mod stroke;
}

mod learn {
    mod motors;
    mod open_rigs;
    mod pairs;
    mod rates;
    mod rivals;
}

mod numeric {
    mod dual;
    mod independent;
    mod rosenbrock;
    mod stroke;
}

mod record {
    mod accepted;
    mod dialects;
    mod fuzz_targets;
    mod shared;
    mod tdms;
    mod wrong;
}

mod residual {
    mod generators;
    mod irregular;
    mod monitor;
    mod onset;
    mod run_length;
    mod shared;
}

mod rig {
    mod expression;
    mod expression_text;
    mod expression_wrong;
    mod files_beside;
    mod own_components;
    mod structure;
    mod structure_known;
    mod units_known;
}
