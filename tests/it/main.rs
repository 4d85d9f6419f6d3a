//! The tests of the library and the program, one module for each subject: `cargo test --test it
//! tolerance::` runs those of one.
//!
//! With `MORION_THOROUGH=1` in the environment some of them take many more cases and hours.

mod advice;
mod align;
mod architecture;
mod bench;
mod broken_profiles;
mod budget;
mod cameras_and_targets;
mod columns;
mod cones;
mod damage;
mod design_accuracy;
mod determinism;
mod dry_run;
mod economy;
mod facet_limits;
mod fingerprint;
mod frame;
mod fuzzed;
mod given_mirrors;
mod glb;
mod machining;
mod manners;
mod maps;
mod mesh_advice;
mod mesh_tolerance;
mod meshes;
mod methods;
mod numerics;
mod obstacles;
mod outside;
mod packages;
mod packed;
mod pages;
mod panels;
mod part;
mod part_refusals;
mod profile_checks;
mod profile_combinations;
mod proof;
mod radial_tables;
mod random_profiles;
mod readme;
mod refusals;
mod render;
mod report_contract;
mod round_mirrors;
mod sag_table;
mod shipped;
mod single_precision;
mod step;
mod stress;
#[cfg(feature = "studio")]
mod studio;
mod support;
mod targets;
mod tolerance;
mod tracing;
mod unchanged;
mod unwrap;
mod verdicts;
mod views;
mod volume;
mod witness_physics;
