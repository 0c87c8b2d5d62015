//! The gap workflow: where model and measurement disagree, which effect is missing, and what is left when it is added.

pub mod bench;
pub mod confirm;
pub mod dictionary;
pub mod inquiry;
pub mod investigate;
pub mod joint;
pub mod lag;
pub mod localise;
pub mod manoeuvre;
pub mod noise;
pub mod output;
pub mod panel;
pub mod runs;
pub mod scan;
pub mod simulation;
pub mod smooth;
pub mod split;
pub mod summary;
pub mod twin;
pub mod whiten;
