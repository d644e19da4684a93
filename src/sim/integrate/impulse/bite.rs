//! Contact at one point in a substep: which impulse it answers a motion with.

use nalgebra::Vector3;

use super::Taken;
use crate::physics::contact::ContactLaw;
use crate::sim::touch::SLOW;

/// A contact in a substep. A motion is the velocity of its point over the obstacle \[m/s\].
pub struct Bite {
    normal: Vector3<f64>,
    /// Velocity of the obstacle there \[m/s\].
    pub ground: Vector3<f64>,
    /// Mass that the point feels \[kg\], and its inverse.
    mass: f64,
    lightness: f64,
    /// Coefficient of friction, sliding and not sliding \[-\].
    pub friction: f64,
    sticking: f64,
    /// N dt \[N·s\].
    pub load: f64,
    /// Critical damping times dt \[kg\].
    damping: f64,
    /// Whether it is so deep that it must not go deeper.
    pub deep: bool,
    /// Of that damping \[N·s\].
    braked: f64,
    /// Of friction \[N·s\].
    pub impulse: Vector3<f64>,
}

impl Bite {
    /// Of a point of the sheet with a share of the stiffness at a distance \[m\]: with the normal, the velocity of the
    /// obstacle there, the inverse of the point's mass, and the coefficients of sliding and of static friction.
    #[inline]
    pub fn new(
        law: &ContactLaw,
        (share, distance): (f64, f64),
        normal: Vector3<f64>,
        (ground, lightness): (Vector3<f64>, f64),
        [friction, sticking]: [f64; 2],
        dt: f64,
    ) -> Self {
        let mass = 1.0 / lightness;
        let [_, slope, stiffness] = law.psi(distance - law.offset);
        Self {
            normal,
            ground,
            mass,
            lightness,
            friction,
            sticking,
            load: -share * slope * dt,
            damping: 2.0 * (share * stiffness * mass).sqrt() * dt,
            deep: law.offset - distance > law.limit(),
            braked: 0.0,
            impulse: Vector3::zeros(),
        }
    }

    /// Damps the normal velocity, implicitly, without pulling; the load changes with it.
    #[inline]
    pub fn soften(&mut self, motion: &Vector3<f64>) -> Vector3<f64> {
        let speed = self.normal.dot(motion);
        let wanted = -self.damping * speed / (1.0 + self.damping * self.lightness);
        let impulse = wanted.max(-self.load);
        self.load += impulse;
        self.braked = impulse;
        self.normal * impulse
    }

    /// Keeps a deep contact from going deeper.
    #[inline]
    pub fn stop(&mut self, motion: &Vector3<f64>) -> Vector3<f64> {
        let speed = self.normal.dot(motion);
        if speed >= 0.0 {
            return Vector3::zeros();
        }
        let impulse = -speed * self.mass;
        self.load += impulse;
        self.braked += impulse;
        self.normal * impulse
    }

    /// Whether friction is greater where it does not slide.
    #[inline]
    pub fn may_stick(&self) -> bool {
        self.sticking > self.friction
    }

    /// Takes the greater friction where it hardly slides.
    pub fn stick(&mut self, motion: &Vector3<f64>) {
        if self.slip(motion).norm() < SLOW {
            self.friction = self.sticking;
        }
    }

    /// Changes the impulse of friction towards no slip within the cone, and returns the change.
    #[inline]
    pub fn tighten(&mut self, motion: &Vector3<f64>) -> Vector3<f64> {
        let limit = self.friction * self.load;
        let mut impulse = self.impulse - self.slip(motion) * self.mass;
        let square = impulse.norm_squared();
        if square > limit * limit {
            impulse *= limit / square.sqrt();
        }
        let change = impulse - self.impulse;
        self.impulse = impulse;
        change
    }

    /// All of these at a point that shares its mass with no other contact, as one sweep settles it. Returns the motion
    /// after.
    #[inline]
    pub fn settle(&mut self, motion: &Vector3<f64>) -> Vector3<f64> {
        let mut motion = motion + self.soften(motion) * self.lightness;
        if self.deep {
            motion += self.stop(&motion) * self.lightness;
        }
        if self.may_stick() {
            self.stick(&motion);
        }
        if self.friction > 0.0 {
            motion += self.tighten(&motion) * self.lightness;
        }
        motion
    }

    /// What all impulses change the velocity of such a point by \[m/s\].
    #[inline]
    pub fn kick(&self) -> Vector3<f64> {
        (self.normal * self.braked + self.impulse) * self.lightness
    }

    /// Energy exchanged, from the motions before and after.
    #[inline]
    pub fn taken(&self, before: &Vector3<f64>, after: &Vector3<f64>) -> Taken {
        let mean = (before + after) * 0.5;
        let brake = self.normal * self.braked;
        Taken {
            contact: -brake.dot(&mean),
            friction: -self.impulse.dot(&mean),
            work: self.ground.dot(&(self.impulse + brake)),
        }
    }

    fn slip(&self, motion: &Vector3<f64>) -> Vector3<f64> {
        motion - self.normal * self.normal.dot(motion)
    }
}
