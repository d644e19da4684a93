//! Who moves the sheet: one thread alone, or a crew.

use super::crew::Helm;
use super::meet::Meeting;
use super::portion::Portion;
use crate::sim::carry::Prescribed;

/// One thread, or the first of several. A crew knows of the sheet only what is near obstacles or held by moving supports,
/// unless more is asked for.
pub enum Hands<'a> {
    Alone,
    Crew(Helm<'a>),
}

impl Hands<'_> {
    /// Moves slopes and vertices on, what moving supports hold to where it is then; the largest speed of the vertices
    /// \[m/s\].
    pub fn drift(&mut self, sheet: &mut Portion, held: &[Prescribed], dt: f64) -> f64 {
        match self {
            Self::Alone => {
                sheet.swing(dt);
                sheet.drift(held, dt)
            }
            Self::Crew(helm) => helm.drift(sheet, held),
        }
    }

    /// Adds the elastic forces; then all vertices are known, if they are asked for.
    pub fn pull(&mut self, sheet: &mut Portion, all: bool) {
        match self {
            Self::Alone => sheet.pull(),
            Self::Crew(helm) => helm.pull(sheet, all),
        }
    }

    /// Says what is near obstacles from now on.
    pub fn watch(&mut self, meeting: &Meeting) {
        if let Self::Crew(helm) = self {
            helm.watch(meeting.near());
        }
    }

    /// Takes the rates of the vertices to the next half step.
    pub fn kick(&mut self, sheet: &mut Portion, dt: f64, damped: bool) {
        match self {
            Self::Alone => sheet.kick(dt, damped),
            Self::Crew(helm) => helm.kick(sheet),
        }
    }

    /// Ends a substep.
    pub fn end(&mut self, sheet: &mut Portion, damped: bool) {
        match self {
            Self::Alone if damped => sheet.spend(),
            Self::Alone => {}
            Self::Crew(helm) => helm.end(sheet),
        }
    }
}
