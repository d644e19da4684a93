//! What every term offers on a stencil of N nodes: an energy its value, gradient, Hessian and projection; a load its
//! force and how that changes with positions and velocities.

use nalgebra::{Matrix3, Vector3};

/// Unknowns of a stencil: positions \[m\] of vertices or slopes \[-\] of edges.
pub type Nodes<const N: usize> = [Vector3<f64>; N];
/// Derivative of the energy by each node \[N or N·m\].
pub type Gradient<const N: usize> = [Vector3<f64>; N];
/// One 3 x 3 block of second derivatives.
pub type Block = Matrix3<f64>;
/// All blocks of second derivatives; `hessian[i][j]` couples node i with node j.
pub type Hessian<const N: usize> = [[Block; N]; N];

/// An energy that is a sum over stencils and knows the nodes only: no velocity, no step (DESIGN section 3).
pub trait Potential<const N: usize> {
    /// Number of stencils.
    fn count(&self) -> usize;
    /// Nodes of stencil `s`: vertices first, then edges counted from the number of vertices.
    fn nodes(&self, s: usize) -> [u32; N];
    /// Energy \[J\].
    fn value(&self, s: usize, x: &Nodes<N>) -> f64;
    /// Exact first derivative.
    fn gradient(&self, s: usize, x: &Nodes<N>) -> Gradient<N>;
    /// Exact second derivative.
    fn hessian(&self, s: usize, x: &Nodes<N>) -> Hessian<N>;
    /// A positive semidefinite matrix that equals the Hessian where that is one already.
    fn hessian_projected(&self, s: usize, x: &Nodes<N>) -> Hessian<N>;
}

/// A force without an energy: it depends on positions and velocities, and knows no step (DESIGN section 3).
pub trait Load<const N: usize> {
    /// Number of stencils.
    fn count(&self) -> usize;
    /// Nodes of stencil `s`, vertices all.
    fn nodes(&self, s: usize) -> [u32; N];
    /// Force on each node at positions `x` and velocities `v` \[N\].
    fn force(&self, s: usize, x: &Nodes<N>, v: &Nodes<N>) -> Gradient<N>;
    /// Exact derivative of the force on node i by the position of node j, as \[i\]\[j\] \[N/m\]; it need not be symmetric.
    fn by_position(&self, s: usize, x: &Nodes<N>, v: &Nodes<N>) -> Hessian<N>;
    /// Exact derivative of the force on node i by the velocity of node j, as \[i\]\[j\] \[N·s/m\].
    fn by_velocity(&self, s: usize, x: &Nodes<N>, v: &Nodes<N>) -> Hessian<N>;
}
