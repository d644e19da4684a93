use super::cholesky::Cholesky;
use super::newton::{Limits, OVERSHOOT, Problem, Scratch, newton};
use super::ordering::nested_dissection;
use super::sparse::{NO_SLOT, Pattern};

/// A chain of springs: tridiagonal, positive definite.
fn chain(size: u32) -> (Pattern, Vec<f64>) {
    let groups: Vec<[u32; 2]> = (0..size - 1).map(|i| [i, i + 1]).collect();
    let pattern = Pattern::from_groups(size as usize, groups.iter().map(|g| g.as_slice()));
    let mut values = vec![0.0; pattern.entries()];
    for i in 0..size {
        values[pattern.slot(i, i) as usize] = 2.5 + f64::from(i % 3);
    }
    for i in 0..size - 1 {
        values[pattern.slot(i + 1, i) as usize] = -1.0;
    }
    (pattern, values)
}

#[test]
fn slots_are_symmetric_and_absent_where_nothing_is_stored() {
    let groups = [vec![0, 2], vec![1, NO_SLOT, 2]];
    let pattern = Pattern::from_groups(4, groups.iter().map(Vec::as_slice));
    assert_eq!((pattern.size(), pattern.entries()), (4, 6));
    assert_eq!(pattern.slot(0, 2), pattern.slot(2, 0));
    assert_eq!(pattern.slot(0, 1), NO_SLOT);
    assert_eq!(pattern.slot(NO_SLOT, 1), NO_SLOT);
    assert_ne!(pattern.slot(3, 3), NO_SLOT, "the diagonal is always there");
}

/// y += A x for the symmetric matrix with these values of the lower triangle.
fn multiply_add(pattern: &Pattern, values: &[f64], x: &[f64], y: &mut [f64]) {
    for column in 0..pattern.size() {
        let [start, end] = [0, 1].map(|k| pattern.column_starts()[column + k] as usize);
        for k in start..end {
            let row = pattern.rows()[k] as usize;
            y[row] += values[k] * x[column];
            if row != column {
                y[column] += values[k] * x[row];
            }
        }
    }
}

#[test]
fn cholesky_solves_what_multiply_makes() {
    let (pattern, values) = chain(50);
    let wanted: Vec<f64> = (0..100).map(|i| (f64::from(i) * 0.7).sin()).collect();
    for analyse in [Cholesky::new, Cholesky::reordered] {
        let mut cholesky = analyse(pattern.clone());
        cholesky.factorise(&values).unwrap();
        let mut rhs = vec![0.0; 100];
        for column in 0..2 {
            let range = 50 * column..50 * (column + 1);
            multiply_add(&pattern, &values, &wanted[range.clone()], &mut rhs[range]);
        }
        cholesky.solve(&mut rhs, 2);
        for (a, b) in rhs.iter().zip(&wanted) {
            assert!((a - b).abs() < 1e-13);
        }
    }
}

#[test]
fn cholesky_refuses_what_is_not_positive_definite() {
    let (pattern, mut values) = chain(50);
    let mut cholesky = Cholesky::new(pattern.clone());
    values[pattern.slot(25, 25) as usize] = -1.0;
    assert!(cholesky.factorise(&values).is_err());
    values[pattern.slot(25, 25) as usize] = 3.0;
    assert!(cholesky.factorise(&values).is_ok(), "and recovers");
}

#[test]
fn dissection_is_a_permutation_with_separators_last() {
    // A strip of quads, two elements high, wide enough to be cut.
    let node = |i: u32, j: u32| i * 3 + j;
    let mut elements = vec![];
    let mut centres = vec![];
    for i in 0..20 {
        for j in 0..2 {
            elements.push([
                node(i, j),
                node(i + 1, j),
                node(i + 1, j + 1),
                node(i, j + 1),
            ]);
            centres.push([f64::from(i) + 0.5, f64::from(j) + 0.5]);
        }
    }
    let mut order = nested_dissection(&elements, &centres, 65);
    let separator: Vec<u32> = order[60..63].to_vec();
    assert_eq!(order[63..], [63, 64], "nodes in no element come last");
    let column = separator[0] / 3;
    assert!(
        (8..=12).contains(&column),
        "the last cut is near the middle: {column}"
    );
    assert!(separator.iter().all(|n| n / 3 == column));
    order.sort_unstable();
    assert_eq!(order, (0..65).collect::<Vec<_>>());
}

/// Minimises sum of cosh(z - c) along a chain of weak springs: convex, far from quadratic.
struct Wells {
    pattern: Pattern,
    target: Vec<f64>,
    now: Vec<f64>,
}

impl Problem for Wells {
    fn residual(&mut self, z: &[f64], r: &mut [f64]) -> f64 {
        self.now = z.to_vec();
        for i in 0..z.len() {
            r[i] = (z[i] - self.target[i]).sinh();
        }
        r.iter().map(|x| x.abs()).sum()
    }
    fn accept(&mut self) {}
    fn tangent(&mut self, _: f64, values: &mut [f64]) {
        values.fill(0.0);
        for i in 0..self.now.len() as u32 {
            let z = self.now[i as usize] - self.target[i as usize];
            values[self.pattern.slot(i, i) as usize] = z.cosh();
        }
    }
}

#[test]
fn newton_finds_the_minimum_from_afar_and_says_what_it_did() {
    let (pattern, _) = chain(4);
    let target = vec![1.0, -2.0, 5.0, 0.3];
    let mut problem = Wells {
        pattern: pattern.clone(),
        target: target.clone(),
        now: vec![],
    };
    let mut cholesky = Cholesky::new(pattern);
    let limits = Limits {
        tolerance: 1e-12,
        iterations: 50,
        overshoot: OVERSHOOT,
    };
    let (mut z, mut scratch) = (vec![0.0; 4], Scratch::default());
    let outcome = newton(&mut problem, &mut cholesky, &mut z, &limits, &mut scratch);
    assert!(outcome.converged && outcome.norm <= 1e-12);
    assert!(z.iter().zip(&target).all(|(a, b)| (a - b).abs() < 1e-12));
    assert_eq!(outcome.iterations, outcome.factorisations);

    let few = Limits {
        iterations: 2,
        ..limits
    };
    let mut z = vec![0.0; 4];
    let outcome = newton(&mut problem, &mut cholesky, &mut z, &few, &mut scratch);
    assert!(!outcome.converged && outcome.iterations == 2 && outcome.norm > 1e-12);
}
