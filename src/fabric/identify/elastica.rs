//! The heavy elastica: a strip clamped horizontally at one end, at rest under its own weight.
//!
//! With u the distance from the free end over l = (D / (rho g))^(1/3) and phi the angle between strip and vertical,
//! equilibrium reads `phi'' = u sin phi`, `phi(0) = phi0`, `phi'(0) = 0`, without any parameter: the clamp is where
//! phi reaches a right angle, and `Gamma = rho g L³ / D` is u³ there. One integration from the free end therefore
//! gives a strip for each phi0, and nothing has to be shot at. Integrated by Taylor series, whose coefficients the
//! equation gives by recurrence.

use std::f64::consts::FRAC_PI_2;

/// Terms of the series. With [`STEP`] the remainder is below 1e-16.
const ORDER: usize = 24;
/// Step at the free end; it shrinks as the bend sharpens, which it does as the square root of the distance.
const STEP: f64 = 0.2;
/// Gamma up to which strips are looked for: the chord is then 0.1 degrees from the vertical.
const MOST_GAMMA: f64 = 1e5;

/// A hanging strip; lengths are over the overhang L.
#[derive(Clone, Debug, PartialEq)]
pub struct HeavyElastica {
    /// rho g L³ / D \[-\].
    pub gamma: f64,
    /// Horizontal distance of the free end from the clamp \[-\].
    pub tip_x: f64,
    /// Its drop below the clamp \[-\].
    pub tip_drop: f64,
    /// Slope of the free end below the horizontal \[rad\].
    pub tip_slope: f64,
    /// Curvature at the clamp, times L \[-\].
    pub clamp_curvature: f64,
    /// Points from the clamp to the free end, x and drop \[-\].
    pub shape: Vec<[f64; 2]>,
}

impl HeavyElastica {
    /// The strip of a Gamma; none outside 0 to 100,000, both excluded.
    pub fn of_gamma(gamma: f64) -> Option<Self> {
        (gamma > 0.0 && gamma < MOST_GAMMA).then(|| Self::search(|strip| strip.gamma < gamma))
    }

    /// The strip whose chord, from clamp to free end, lies so far below the horizontal \[rad\]; none outside 0 to
    /// 89.8 degrees, both excluded.
    pub fn of_chord(angle: f64) -> Option<Self> {
        let steepest = 89.8f64.to_radians();
        (angle > 0.0 && angle < steepest).then(|| Self::search(|strip| strip.chord_angle() < angle))
    }

    /// Angle of the chord below the horizontal \[rad\].
    pub fn chord_angle(&self) -> f64 {
        self.tip_drop.atan2(self.tip_x)
    }

    /// Bending length over the overhang: l / L with l = (D / (rho g))^(1/3) \[-\].
    pub fn bending_length(&self) -> f64 {
        self.gamma.cbrt().recip()
    }

    /// Bisection on the logarithm of phi0: the stiffer the strip, the nearer it comes to a right angle.
    fn search(stiffer: impl Fn(&Self) -> bool) -> Self {
        // Where phi is small it grows as exp(2/3 u^(3/2)).
        let (mut limp, mut stiff) = (-2.0 / 3.0 * MOST_GAMMA.sqrt() - 3.0, FRAC_PI_2.ln());
        for _ in 0..64 {
            let middle = 0.5 * (limp + stiff);
            match stiffer(&Self::of_free_end(middle.exp())) {
                true => stiff = middle,
                false => limp = middle,
            }
        }
        Self::of_free_end((0.5 * (limp + stiff)).exp())
    }

    /// The strip whose free end stands at `phi0` from the vertical.
    fn of_free_end(phi0: f64) -> Self {
        let (mut u, mut phi, mut slope) = (0.0, phi0, 0.0);
        let mut place = [0.0; 2];
        let mut places = vec![place];
        loop {
            let series = Series::new(u, phi, slope);
            let step = STEP / (1.0f64 + u).sqrt();
            let (last, step) = match value(&series.phi, step) < FRAC_PI_2 {
                true => (false, step),
                false => (true, series.right_angle(step)),
            };
            place[0] += integral(&series.sin, step);
            place[1] += integral(&series.cos, step);
            places.push(place);
            (phi, slope) = (value(&series.phi, step), derivative(&series.phi, step));
            u += step;
            if last {
                break;
            }
        }
        let from_clamp = |p: &[f64; 2]| [(place[0] - p[0]) / u, (place[1] - p[1]) / u];
        Self {
            gamma: u * u * u,
            tip_x: place[0] / u,
            tip_drop: place[1] / u,
            tip_slope: FRAC_PI_2 - phi0,
            clamp_curvature: slope * u,
            shape: places.iter().rev().map(from_clamp).collect(),
        }
    }
}

type Coefficients = [f64; ORDER + 1];

/// Taylor coefficients of phi, sin phi and cos phi about a point of the strip.
struct Series {
    phi: Coefficients,
    sin: Coefficients,
    cos: Coefficients,
}

impl Series {
    fn new(u: f64, phi: f64, slope: f64) -> Self {
        let (mut p, mut s, mut c) = ([0.0; ORDER + 1], [0.0; ORDER + 1], [0.0; ORDER + 1]);
        (p[0], p[1]) = (phi, slope);
        (s[0], c[0]) = phi.sin_cos();
        for k in 1..=ORDER {
            if k >= 2 {
                let before = if k >= 3 { s[k - 3] } else { 0.0 };
                p[k] = (u * s[k - 2] + before) / (k * (k - 1)) as f64;
            }
            // (sin phi)' = phi' cos phi and (cos phi)' = -phi' sin phi, term by term.
            for j in 1..=k {
                let weight = j as f64 * p[j] / k as f64;
                s[k] += weight * c[k - j];
                c[k] -= weight * s[k - j];
            }
        }
        Self {
            phi: p,
            sin: s,
            cos: c,
        }
    }

    /// The step, `longest` at most, after which phi is a right angle: Newton from beyond it.
    fn right_angle(&self, longest: f64) -> f64 {
        let mut step = longest;
        for _ in 0..20 {
            step -= (value(&self.phi, step) - FRAC_PI_2) / derivative(&self.phi, step);
        }
        step
    }
}

fn value(series: &Coefficients, x: f64) -> f64 {
    series.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

fn derivative(series: &Coefficients, x: f64) -> f64 {
    let terms = series.iter().enumerate().skip(1).rev();
    terms.fold(0.0, |sum, (k, c)| sum * x + k as f64 * c)
}

fn integral(series: &Coefficients, x: f64) -> f64 {
    let terms = series.iter().enumerate().rev();
    terms.fold(0.0, |sum, (k, c)| sum * x + c / (k + 1) as f64) * x
}
