//! The schemes on one mass on one linear spring, where everything is known.

use nalgebra::{DMatrix, DVector, Vector3};

use super::{Rule, local_error};
use crate::sim::air::Air;
use crate::sim::dofs::Dofs;
use crate::sim::state::{History, Ledger, State};

fn at(x: f64, v: f64, a: f64, before: [f64; 2], dt: f64) -> State {
    let along = |c: f64| vec![Vector3::new(c, 0.0, 0.0)];
    State {
        step: 0,
        began: 0,
        positions: along(x),
        velocities: along(v),
        slopes: vec![],
        slope_rates: vec![],
        obstacles: vec![],
        air: Air::default(),
        history: History {
            dt,
            positions: along(before[0]),
            velocities: along(before[1]),
            accelerations: along(a),
        },
        bonds: vec![],
        layer_bonds: vec![],
        ledger: Ledger::default(),
    }
}

/// One step of a'' = -omega² x, solved exactly.
fn step(rule: Rule, state: &mut State, omega: f64, dt: f64) {
    let map = rule.map(state, dt);
    let x = -map.b_a[0].x / (map.alpha_a + omega * omega);
    rule.advance(state, &map, &[Vector3::new(x, 0.0, 0.0)], dt);
}

const RULES: [(Rule, f64, f64); 6] = [
    // Rule, order, spectral radius at infinite frequency.
    (Rule::BackwardEuler, 1.0, 0.0),
    (Rule::Bdf2, 2.0, 0.0),
    (Rule::GeneralisedAlpha(0.0), 2.0, 0.0),
    (Rule::GeneralisedAlpha(0.5), 2.0, 0.5),
    (Rule::GeneralisedAlpha(0.8), 2.0, 0.8),
    (Rule::GeneralisedAlpha(1.0), 2.0, 1.0),
];

/// Error in position and velocity after a turn and a bit, from x = 1 at rest.
#[test]
fn order_on_a_linear_spring() {
    for (rule, order, _) in RULES {
        let error = |parts: u32| {
            let dt = 7.0 / f64::from(parts);
            let mut state = at(1.0, 0.0, -1.0, [0.0; 2], 0.0);
            (0..parts).for_each(|_| step(rule, &mut state, 1.0, dt));
            let (sin, cos) = 7f64.sin_cos();
            (state.positions[0].x - cos).hypot(state.velocities[0].x + sin)
        };
        let slope = (error(800) / error(1600)).log2();
        assert!((slope - order).abs() < 0.05, "{rule:?}: order {slope}");
    }
}

/// Eigenvalues of one step as a linear map of (x, dt v, dt² a, x before, dt v before), largest in size.
fn spectral_radius(rule: Rule, omega_dt: f64) -> f64 {
    let dt = 1e-3;
    let columns: Vec<DVector<f64>> = (0..5)
        .map(|i| {
            let unit = |j: usize| f64::from(u8::from(i == j));
            let before = [unit(3), unit(4) / dt];
            let mut state = at(unit(0), unit(1) / dt, unit(2) / (dt * dt), before, dt);
            step(rule, &mut state, omega_dt / dt, dt);
            let past = &state.history;
            DVector::from_vec(vec![
                state.positions[0].x,
                state.velocities[0].x * dt,
                past.accelerations[0].x * dt * dt,
                past.positions[0].x,
                past.velocities[0].x * dt,
            ])
        })
        .collect();
    let eigenvalues = DMatrix::from_columns(&columns).complex_eigenvalues();
    eigenvalues.iter().map(|z| z.norm()).fold(0.0, f64::max)
}

/// Chung and Hulbert's rho at infinity is what they promise, and no frequency grows.
#[test]
fn stability_at_all_frequencies_and_dissipation_at_infinity() {
    for (rule, _, at_infinity) in RULES {
        for exponent in -20..=40 {
            let omega_dt = 10f64.powf(0.1 * f64::from(exponent));
            let radius = spectral_radius(rule, omega_dt);
            assert!(radius < 1.0 + 1e-6, "{rule:?} at {omega_dt}: {radius}");
        }
        // A triple root turns rounding of 1e-16 into 1e-5, and 1/(omega dt)² into 1e-2 at 1e3.
        let radius = spectral_radius(rule, 1e4);
        assert!(
            (radius - at_infinity).abs() < 0.02,
            "{rule:?}: {radius} at infinity"
        );
    }
}

/// The trapezoidal rule keeps the energy of a linear spring.
#[test]
fn energy_is_kept_by_the_trapezoidal_rule() {
    let mut state = at(1.0, 0.0, -1.0, [0.0; 2], 0.0);
    for _ in 0..1000 {
        step(Rule::GeneralisedAlpha(1.0), &mut state, 1.0, 0.3);
        let energy = state.positions[0].norm_squared() + state.velocities[0].norm_squared();
        assert!((energy - 1.0).abs() < 1e-11, "energy {energy}");
    }
}

/// BDF2 with a step that changes is still exact for what is quadratic in time.
#[test]
fn bdf2_takes_a_variable_step() {
    let place = |t: f64| 0.3 + 0.7 * t - 4.0 * t * t;
    let speed = |t: f64| 0.7 - 8.0 * t;
    let (before, dt) = (0.02, 0.035);
    let state = at(
        place(0.0),
        speed(0.0),
        -8.0,
        [place(-before), speed(-before)],
        before,
    );
    let map = Rule::Bdf2.map(&state, dt);
    let x = place(dt);
    assert!((map.alpha_v * x + map.b_v[0].x - speed(dt)).abs() < 1e-12);
    assert!((map.alpha_a * x + map.b_a[0].x + 8.0).abs() < 1e-9);
}

/// From rest at 1 on a unit spring over 7 s in steps whose lengths go round `ratios`, each over the one before.
fn bdf2_error(ratios: &[f64], parts: u32) -> f64 {
    let whole: f64 = {
        let mut dt = 1.0;
        (0..parts)
            .map(|k| {
                let now = dt;
                dt *= ratios[k as usize % ratios.len()];
                now
            })
            .sum()
    };
    let mut dt = 7.0 / whole;
    let mut state = at(1.0, 0.0, -1.0, [0.0; 2], 0.0);
    for k in 0..parts {
        step(Rule::Bdf2, &mut state, 1.0, dt);
        dt *= ratios[k as usize % ratios.len()];
    }
    let (sin, cos) = 7f64.sin_cos();
    (state.positions[0].x - cos).hypot(state.velocities[0].x + sin)
}

/// Steps that go up and down by 1.5, and by 3 (beyond 1 + sqrt 2, but never twice in a row), keep order two; 1.5 costs
/// less than twice the error of equal steps.
#[test]
fn bdf2_keeps_its_order_while_steps_change() {
    for ratio in [1.5, 3.0] {
        let around = [ratio, 1.0 / ratio];
        let errors = [800, 1600].map(|parts| bdf2_error(&around, parts));
        let order = (errors[0] / errors[1]).log2();
        assert!((order - 2.0).abs() < 0.1, "ratio {ratio}: order {order}");
        let more = errors[1] / bdf2_error(&[1.0], 1600);
        assert!(
            more < if ratio < 2.0 { 2.0 } else { 6.0 },
            "ratio {ratio}: {more} times the error"
        );
    }
}

/// What a disturbance of a particle without forces grows by in 20 steps, each `ratio` times the one before.
fn bdf2_growth(ratio: f64) -> f64 {
    let (mut dt, mut before, mut now) = (1e-9, 0.0, 1.0);
    for _ in 0..20 {
        let state = at(now, 0.0, 0.0, [before, 0.0], dt / ratio);
        let map = Rule::Bdf2.map(&state, dt);
        // At a velocity of nothing.
        (before, now) = (now, -map.b_v[0].x / map.alpha_v);
        dt *= ratio;
    }
    now.abs()
}

/// Zero-stable up to a ratio of 1 + sqrt 2 from step to step, and not beyond: with 3, 9/7 a step.
#[test]
fn bdf2_fails_beyond_its_ratio() {
    assert!(bdf2_growth(2.0) < 10.0, "{}", bdf2_growth(2.0));
    assert!(bdf2_growth(3.0) > 100.0, "{}", bdf2_growth(3.0));
}

/// Error that a part adds to the position of a particle with the jerk 1, over what `local_error` says of it; the error
/// that its velocity brings along is not the part's.
fn added(rule: Rule) -> f64 {
    let dt = 1e-2;
    let exact = |t: f64| [t * t * t / 6.0, t * t / 2.0];
    let [x, v] = exact(1.0);
    let before = exact(1.0 - dt);
    let mut state = at(x, v, 1.0, before, dt);
    state.history.accelerations[0].x = 1.0;
    let mut ratio = 0.0;
    for part in 0..60 {
        let start = 1.0 + f64::from(part) * dt;
        let off = |state: &State, t: f64| {
            let [x, v] = exact(t);
            [state.positions[0].x - x, state.velocities[0].x - v]
        };
        let from = off(&state, start);
        let map = rule.map(&state, dt);
        let force = start + map.fraction * dt;
        let x = (force - map.b_a[0].x) / map.alpha_a;
        rule.advance(&mut state, &map, &[Vector3::new(x, 0.0, 0.0)], dt);
        let to = off(&state, start + dt);
        let growth = to[0] - from[0] - 0.5 * dt * (from[1] + to[1]);
        let dofs = Dofs {
            index: vec![[0, 1, 2]],
            size: 3,
        };
        ratio = growth.abs() / local_error(rule, &state, &[0.3], &dofs);
    }
    ratio
}

#[test]
fn the_estimate_is_what_a_part_adds_to_the_error() {
    for (rule, _, _) in RULES {
        let ratio = added(rule);
        assert!((ratio - 1.0).abs() < 0.02, "{rule:?}: {ratio}");
    }
}
