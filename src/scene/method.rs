//! How a scene is solved and how often it speaks.

use serde::{Deserialize, Serialize};

/// Time scheme (DESIGN section 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// First order, strongly damping.
    BackwardEuler,
    /// Second order, variable step, damps only what the step cannot resolve.
    Bdf2,
    /// Second order, damping chosen by the spectral radius at infinite frequency.
    GeneralisedAlpha,
    /// The paper's explicit scheme (16), at its own stable step.
    CentralDifference,
    /// No time: each step ends at rest, a minimum of the energy.
    Equilibrium,
}

impl Scheme {
    /// All schemes, in the order of `toile list methods`.
    pub const ALL: [Scheme; 5] = [
        Scheme::BackwardEuler,
        Scheme::Bdf2,
        Scheme::GeneralisedAlpha,
        Scheme::CentralDifference,
        Scheme::Equilibrium,
    ];

    /// Those that follow the motion in time.
    pub const IN_TIME: [Scheme; 4] = [
        Scheme::BackwardEuler,
        Scheme::Bdf2,
        Scheme::GeneralisedAlpha,
        Scheme::CentralDifference,
    ];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Scheme::BackwardEuler => "backward-euler",
            Scheme::Bdf2 => "bdf2",
            Scheme::GeneralisedAlpha => "generalised-alpha",
            Scheme::CentralDifference => "central-difference",
            Scheme::Equilibrium => "equilibrium",
        }
    }

    /// One line on what it is.
    pub fn description(self) -> &'static str {
        match self {
            Scheme::BackwardEuler => "implicit, first order, damps strongly",
            Scheme::Bdf2 => "implicit, second order, damps what the step cannot resolve",
            Scheme::GeneralisedAlpha => "implicit, second order, damping set by rho_infinity",
            Scheme::CentralDifference => {
                "explicit, second order, substeps at its own stability limit"
            }
            Scheme::Equilibrium => {
                "no time: each step ends at rest, a tested minimum of the energy"
            }
        }
    }
}

/// What solves the equations of an implicit step (DESIGN section 3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Solver {
    /// Newton's method with a sparse Cholesky factorisation.
    #[default]
    Newton,
    /// L-BFGS from a constant matrix, the same for x, y and z, factorised once a step.
    QuasiNewton,
    /// Position-based sweeps over the faces, in many small steps: what games do, as a baseline.
    Xpbd,
}

impl Solver {
    /// All solvers.
    pub const ALL: [Solver; 3] = [Solver::Newton, Solver::QuasiNewton, Solver::Xpbd];

    /// The name in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Solver::Newton => "newton",
            Solver::QuasiNewton => "quasi-newton",
            Solver::Xpbd => "xpbd",
        }
    }

    /// One line on what it is.
    pub fn description(self) -> &'static str {
        match self {
            Solver::Newton => "solver of the implicit schemes: sparse Cholesky, line search",
            Solver::QuasiNewton => {
                "solver: L-BFGS from a constant matrix, the same for x, y and z; bdf2 unless a scheme is named"
            }
            Solver::Xpbd => {
                "solver: position-based sweeps in small steps, as in games; first order, never fully converged"
            }
        }
    }
}

/// A scheme with its solver: what a chart compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Method {
    /// In time.
    pub scheme: Scheme,
    /// Of the algebra; without meaning for the explicit scheme.
    pub solver: Solver,
}

impl From<Scheme> for Method {
    fn from(scheme: Scheme) -> Self {
        let solver = Solver::Newton;
        Self { scheme, solver }
    }
}

impl Method {
    /// Those that charts compare: every scheme that follows the motion in time, and the other solvers.
    pub const IN_TIME: [Method; 6] = [
        Method::of(Scheme::BackwardEuler, Solver::Newton),
        Method::of(Scheme::Bdf2, Solver::Newton),
        Method::of(Scheme::GeneralisedAlpha, Solver::Newton),
        Method::of(Scheme::CentralDifference, Solver::Newton),
        Method::of(Scheme::Bdf2, Solver::QuasiNewton),
        Method::of(Scheme::BackwardEuler, Solver::Xpbd),
    ];

    const fn of(scheme: Scheme, solver: Solver) -> Self {
        Self { scheme, solver }
    }

    /// Whether it estimates the error of its steps.
    pub fn knows_its_error(self) -> bool {
        let in_time_implicit = [
            Scheme::BackwardEuler,
            Scheme::Bdf2,
            Scheme::GeneralisedAlpha,
        ];
        in_time_implicit.contains(&self.scheme) && self.solver != Solver::Xpbd
    }

    /// The method that a name stands for: a scheme, a solver with its usual scheme, or `SCHEME+SOLVER`.
    pub fn named(name: &str) -> Option<Self> {
        let scheme = |name: &str| Scheme::ALL.into_iter().find(|s| s.name() == name);
        let solver = |name: &str| Solver::ALL.into_iter().find(|s| s.name() == name);
        if let Some((first, second)) = name.split_once('+') {
            return Some(Self::of(scheme(first)?, solver(second)?));
        }
        match (scheme(name), solver(name)) {
            (Some(scheme), _) => Some(scheme.into()),
            (None, Some(Solver::Xpbd)) => Some(Self::of(Scheme::BackwardEuler, Solver::Xpbd)),
            (None, Some(solver)) => Some(Self::of(Scheme::Bdf2, solver)),
            (None, None) => None,
        }
    }

    /// The shortest name.
    pub fn name(self) -> String {
        match (self.scheme, self.solver) {
            (scheme, Solver::Newton) => scheme.name().to_string(),
            (Scheme::BackwardEuler, Solver::Xpbd) | (Scheme::Bdf2, Solver::QuasiNewton) => {
                self.solver.name().to_string()
            }
            (scheme, solver) => format!("{}+{}", scheme.name(), solver.name()),
        }
    }
}

/// What the explicit scheme does with a substep over its stable limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StableLimit {
    /// Refuses it.
    #[default]
    Keep,
    /// Takes it, and diverges: for charts and tests of stability.
    Ignore,
}

/// How steps are taken and solved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MethodSpec {
    /// Time scheme.
    pub scheme: Scheme,
    /// Solver of an implicit step; `xpbd` goes with `backward-euler`.
    pub solver: Solver,
    /// Step \[s\]; the outer step of `central-difference`, which substeps; the first step of the flow of `equilibrium`.
    pub dt: f64,
    /// A step has converged when its force residual is below this fraction of the sheet's weight \[-\].
    pub tolerance: f64,
    /// Newton iterations before a step is retried smaller \[-\]; `quasi-newton` has 25 for each.
    pub max_iterations: usize,
    /// Substep \[s\], at most `dt`. Left out, it is 0.85 of the stable limit for `central-difference`, and a
    /// twentieth of `dt` for `xpbd`.
    pub substep: Option<f64>,
    /// Error in position that a part of an implicit step may add \[m\], mass-weighted root of the mean square: parts are as
    /// long as it allows, `dt` at most. Left out, steps are parted only where they must be to be solved.
    pub step_tolerance: Option<f64>,
    /// Whether `central-difference` keeps to its stable limit.
    pub limit: StableLimit,
    /// Triangles of the coarsest mesh on which `equilibrium` looks for rest first; each shape is carried over to a mesh of
    /// twice as many, up to the scene's own. Left out, it starts flat on the scene's own mesh.
    pub coarsest: Option<usize>,
    /// Spectral radius of `generalised-alpha` at infinite frequency, 0 to 1 \[-\].
    pub rho_infinity: f64,
}

impl MethodSpec {
    /// Scheme and solver.
    pub fn method(&self) -> Method {
        Method::of(self.scheme, self.solver)
    }

    /// The same with another scheme and solver; what the method has no use for goes.
    pub fn with(self, method: Method) -> Self {
        Self {
            step_tolerance: self.step_tolerance.filter(|_| method.knows_its_error()),
            coarsest: self
                .coarsest
                .filter(|_| method.scheme == Scheme::Equilibrium),
            scheme: method.scheme,
            solver: method.solver,
            ..self
        }
    }
}

impl Default for MethodSpec {
    fn default() -> Self {
        Self {
            scheme: Scheme::Bdf2,
            solver: Solver::Newton,
            dt: 5e-3,
            tolerance: 1e-3,
            max_iterations: 40,
            substep: None,
            step_tolerance: None,
            limit: StableLimit::Keep,
            coarsest: None,
            rho_infinity: 0.3,
        }
    }
}

/// What goes out, and how often.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutputSpec {
    /// States and reports per simulated second \[Hz\]; a whole number of steps apart.
    pub rate: f64,
    /// Mesh markers per simulated second \[Hz\]; 0 turns them off.
    pub mesh_rate: f64,
    /// Simulated time from one keyframe, the whole state in double precision, to the next \[s\]; 0 turns them off.
    pub keyframe_interval: f64,
}

impl Default for OutputSpec {
    fn default() -> Self {
        Self {
            rate: 100.0,
            mesh_rate: 25.0,
            keyframe_interval: 1.0,
        }
    }
}
