//! `wheelwatt._gmr`: the commands of `gmr` as functions, and logs as columns. What it gives is made
//! into objects in `wheelwatt/*.py`.
//!
//! There is no work here: a function's work is its command's, so that both say the same.

mod batches;
mod command;
mod failure;
mod gram;
mod table;

/// The native module.
#[pyo3::pymodule]
mod _gmr {
    #[pymodule_export]
    use super::command::main;
    #[pymodule_export]
    use super::command::run;
    #[pymodule_export]
    use super::gram::Sums;
    #[pymodule_export]
    use super::gram::gram_columns;
    #[pymodule_export]
    use super::gram::write_grams;
    #[pymodule_export]
    use super::table::read_log;
    #[pymodule_export]
    use super::table::write_log;
}
