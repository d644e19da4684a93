//! The moves of central differences: positions and slopes from one moment to the next, rates from one half step to the
//! next. Loops over nodes are given the vector unit that there is; no unit fuses a product with a sum here, so bits are the
//! same on all.

use pulp::Arch;

use crate::sim::lanes::{Lanes, add, dot, each, scale};

/// Moves the vertices, puts their weight in for the forces, and returns their largest speed \[m/s\], which is no number if
/// one is none.
pub fn drift(
    nodes: &mut [Lanes],
    rates: &[Lanes],
    weight: &[Lanes],
    forces: &mut [Lanes],
    dt: f64,
) -> f64 {
    Arch::new().dispatch(move || {
        // Bits of squares are in the order of the squares, and above them all where one is no number.
        let mut fastest = 0;
        let moving = nodes.iter_mut().zip(rates);
        for ((x, rate), (force, weight)) in moving.zip(forces.iter_mut().zip(weight)) {
            *x = add(*x, scale(*rate, dt));
            *force = *weight;
            fastest = fastest.max(dot(*rate, *rate).to_bits());
        }
        f64::from_bits(fastest).sqrt()
    })
}

/// Moves the slopes by their impulses J s' / dt \[N·m\], to which moments only need to be added.
pub fn swing(slopes: &mut [Lanes], impulses: &[Lanes], inverse_inertia: &[f64], dt: f64) {
    Arch::new().dispatch(move || {
        for ((s, impulse), inverse) in slopes.iter_mut().zip(impulses).zip(inverse_inertia) {
            *s = add(*s, scale(*impulse, inverse * dt * dt));
        }
    });
}

/// A rate after a force has acted for `dt`.
#[inline(always)]
pub fn kicked(rate: Lanes, force: Lanes, inverse: &Lanes, dt: f64) -> Lanes {
    add(rate, each(|k| force[k] * inverse[k] * dt))
}

/// Takes the vertices' rates from one half step to the next.
pub fn kick(rates: &mut [Lanes], forces: &[Lanes], inverse: &[Lanes], dt: f64) {
    Arch::new().dispatch(move || {
        for ((rate, force), inverse) in rates.iter_mut().zip(forces).zip(inverse) {
            *rate = kicked(*rate, *force, inverse, dt);
        }
    });
}

/// The same with damping `drag` \[1/s\].
pub fn slow(rates: &mut [Lanes], forces: &[Lanes], inverse: &[Lanes], drag: &[f64], dt: f64) {
    Arch::new().dispatch(move || {
        let moving = rates.iter_mut().zip(forces).zip(inverse.iter().zip(drag));
        for ((rate, force), (inverse, drag)) in moving {
            *rate = slowed(*rate, *force, inverse, *drag, dt);
        }
    });
}

/// A rate after a force and damping have acted for `dt`.
#[inline(always)]
pub fn slowed(rate: Lanes, force: Lanes, inverse: &Lanes, drag: f64, dt: f64) -> Lanes {
    let half = 0.5 * dt * drag;
    let kept = scale(rate, 1.0 - half);
    scale(kicked(kept, force, inverse, dt), 1.0 / (1.0 + half))
}
