//! The sheet against itself: what a scene says of it, and what holds where it says nothing.

use serde::{Deserialize, Serialize};

use super::method::{Method, Scheme, Solver};
use super::spec::{Region, Scene, SupportSpec};

/// How the sheet touches itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LayersSpec {
    /// Whether it does.
    pub contact: LayerContact,
    /// Coulomb friction coefficient of cloth on cloth \[-\]; none unless given, as on obstacles.
    pub friction: f64,
    /// Distance of the middle surfaces at which layers touch \[m\]; the fabric's thickness if left out.
    pub thickness: Option<f64>,
}

/// Whether layers of the sheet touch or pass through each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LayerContact {
    /// They touch.
    #[default]
    On,
    /// They pass through each other, and reports say where they should not.
    Off,
}

impl Scene {
    /// How the sheet touches itself, if it does: as the scene says; where it says nothing, without friction, unless the
    /// sheet is held so that it cannot. A method that knows no layers has none: there the sheet passes through itself. Nor
    /// has a search for a state of rest, unless the scene says so: its iterates are no motion of cloth, and to keep their
    /// layers apart leads to other folds even where none touch in the end.
    pub fn touches_itself(&self) -> Option<LayersSpec> {
        let method = self.method.method();
        let unsaid = || {
            let moves = method.scheme != Scheme::Equilibrium && !self.support.values().any(spans);
            moves.then(LayersSpec::default)
        };
        let spec = self.layers.or_else(unsaid)?;
        (spec.contact == LayerContact::On && method.knows_layers()).then_some(spec)
    }

    /// The same scene whose sheet passes through itself unless the scene says otherwise: for comparisons of methods, of
    /// which some know no layers.
    pub fn without_unsaid_layers(mut self) -> Self {
        self.layers.get_or_insert(LayersSpec::OFF);
        self
    }
}

impl LayersSpec {
    /// No contact of layers.
    pub const OFF: Self = Self {
        contact: LayerContact::Off,
        friction: 0.0,
        thickness: None,
    };
}

impl Method {
    /// Whether it can keep layers of the sheet apart.
    pub fn knows_layers(self) -> bool {
        self.scheme == Scheme::CentralDifference || self.solver == Solver::Newton
    }
}

/// Whether a support holds the whole boundary in one piece, as an embroidery frame does: cloth stretches too little to
/// meet itself there.
fn spans(support: &SupportSpec) -> bool {
    let firm = "xyz".chars().all(|axis| support.axes.contains(axis));
    support.region == Region::Boundary && firm
}
