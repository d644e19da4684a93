//! Sparse Cholesky on faer: the symbolic factorisation is kept, the numeric one repeated.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

use super::sparse::Pattern;

/// The matrix is not positive definite to working precision.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is not positive definite")]
pub struct NotPositiveDefinite;

/// Cholesky factor of matrices of one pattern. Its pattern is in elimination order, or [`Cholesky::reordered`].
pub struct Cholesky {
    pattern: Pattern,
    symbolic: SymbolicCholesky<u32>,
    factor: Vec<f64>,
    memory: MemBuffer,
}

impl Cholesky {
    /// Analyses the pattern once.
    ///
    /// # Panics
    /// If memory runs out.
    pub fn new(pattern: Pattern) -> Self {
        // Without a permutation faer reads the upper triangle here, and the lower one in the numeric part.
        let upper = pattern.upper();
        Self::analysed(pattern, (&upper, Side::Upper), SymmetricOrdering::Identity)
    }

    /// Analyses a pattern in any order: it is eliminated by approximate minimum degree.
    ///
    /// # Panics
    /// If memory runs out.
    pub fn reordered(pattern: Pattern) -> Self {
        let lower = pattern.clone();
        Self::analysed(pattern, (&lower, Side::Lower), SymmetricOrdering::Amd)
    }

    fn analysed(
        pattern: Pattern,
        (triangle, side): (&Pattern, Side),
        ordering: SymmetricOrdering<'_, u32>,
    ) -> Self {
        let symbolic = factorize_symbolic_cholesky(
            view(triangle),
            side,
            ordering,
            CholeskySymbolicParams {
                supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
                ..Default::default()
            },
        )
        .expect("memory for the symbolic factorisation");
        let scratch = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default())
            .or(symbolic.solve_in_place_scratch::<f64>(3, Par::Seq));
        Self {
            factor: vec![0.0; symbolic.len_val()],
            memory: MemBuffer::new(scratch),
            pattern,
            symbolic,
        }
    }

    /// The pattern.
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Stored entries of the factor.
    pub fn factor_entries(&self) -> usize {
        self.factor.len()
    }

    /// Factorises the matrix with these values of the lower triangle.
    pub fn factorise(&mut self, values: &[f64]) -> Result<(), NotPositiveDefinite> {
        self.symbolic
            .factorize_numeric_llt(
                &mut self.factor,
                SparseColMatRef::new(view(&self.pattern), values),
                Side::Lower,
                LltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut self.memory),
                Default::default(),
            )
            .map_err(|_| NotPositiveDefinite)?;
        // faer lets a NaN through: a NaN pivot compares as "not non-positive".
        Ok(())
    }

    /// Solves in place for `columns` right-hand sides (at most 3) stored one after the other.
    pub fn solve(&mut self, rhs: &mut [f64], columns: usize) {
        let size = self.pattern.size();
        LltRef::new(&self.symbolic, &self.factor).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, size, columns),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
    }
}

fn view(pattern: &Pattern) -> SymbolicSparseColMatRef<'_, u32> {
    SymbolicSparseColMatRef::new_checked(
        pattern.size(),
        pattern.size(),
        pattern.column_starts(),
        None,
        pattern.rows(),
    )
}
