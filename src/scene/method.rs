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

/// How steps are taken and solved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MethodSpec {
    /// Time scheme.
    pub scheme: Scheme,
    /// Step \[s\]; the outer step of `central-difference`, which substeps; the first step of the flow of `equilibrium`.
    pub dt: f64,
    /// A step has converged when its force residual is below this fraction of the sheet's weight \[-\].
    pub tolerance: f64,
    /// Newton iterations before a step is retried smaller \[-\].
    pub max_iterations: usize,
    /// Substep of `central-difference` \[s\], at most `dt`; left out, it is 0.95 of the stable limit.
    pub substep: Option<f64>,
    /// Spectral radius of `generalised-alpha` at infinite frequency, 0 to 1 \[-\].
    pub rho_infinity: f64,
}

impl Default for MethodSpec {
    fn default() -> Self {
        Self {
            scheme: Scheme::Bdf2,
            dt: 5e-3,
            tolerance: 1e-3,
            max_iterations: 40,
            substep: None,
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
