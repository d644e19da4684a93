//! Linear algebra over nalgebra and faer: elimination order, sparse assembly, Cholesky, Newton.

pub mod cholesky;
pub mod newton;
pub mod ordering;
pub mod quasi_newton;
pub mod sparse;
#[cfg(test)]
mod test;
