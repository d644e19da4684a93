//! Where the sheet meets obstacles in a run of substeps, and what that does to it.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use super::super::impulse::{self, Grip, Taken};
use super::super::stable::{MARGIN, quickest, rate_of};
use super::floors::Floors;
use super::hands::Hands;
use super::portion::Portion;
use crate::contact::{FAR, Nearby, Obstacle, Pose, Search, Side, Spot};
use crate::physics::contact::{ContactLaw, weighted};
use crate::sim::lanes::{Lanes, add, dot, lanes, scale, vector};
use crate::sim::model::Model;
use crate::sim::state::State;
use crate::sim::touch::Touch;

/// [`MARGIN`] for what is looked at in every substep \[m\].
const SLIVER: f64 = 1e-4;
/// Haste where a vertex comes near that is too light for the substep.
const UNFORESEEN: f64 = 1.1;
/// Part of the margin that must be left, or what is near is collected anew.
const LEFT: f64 = 0.3;

/// Contact with obstacles, with its work space.
pub struct Meeting {
    /// What may touch each obstacle before anything has moved by [`MARGIN`].
    nearby: Vec<Nearby>,
    /// Where the vertices that are close to each obstacle were in its frame when `nearby` was collected \[m\].
    starts: Vec<Vec<Vector3<f64>>>,
    /// Motion that `nearby` still allows what is close, and the rest \[m\].
    allowance: [f64; 2],
    /// Of `nearby`, what may touch before anything has moved by [`SLIVER`]: `None` where it is all of it.
    soon: Vec<Option<Nearby>>,
    /// Motion that `soon` still allows what is near \[m\].
    sliver: f64,
    floors: Floors,
    /// Vertices over flat sides that are not in `floors`, by obstacle.
    shared: Vec<Vec<Side>>,
    /// Positions when they were needed last \[m\], shape \[vertices\].
    positions: Vec<Vector3<f64>>,
    search: Search,
    spots: Vec<Spot>,
    /// Velocities of the spots in the half step before \[m/s\].
    motions: Vec<Vector3<f64>>,
    grips: Vec<Grip>,
    /// Where moving obstacles were before the substep, and how far drawn in \[m\].
    before: Vec<(Pose, f64)>,
    /// How fast surfaces of obstacles may be \[m/s\].
    quickest: f64,
    haste: f64,
    /// Largest stiffness over mass of contacts that the substep bears \[1/s²\].
    bearable: f64,
}

/// Time since the start of the run, largest speed of the sheet, and length of a substep.
type Motion = (f64, f64, f64);

impl Meeting {
    /// For a sheet of so many vertices.
    pub fn new(vertices: usize) -> Self {
        Self {
            nearby: vec![],
            starts: vec![],
            allowance: [f64::NEG_INFINITY; 2],
            soon: vec![],
            sliver: 0.0,
            floors: Floors::default(),
            shared: vec![],
            positions: vec![Vector3::zeros(); vertices],
            search: Search::default(),
            spots: vec![],
            motions: vec![],
            grips: vec![],
            before: vec![],
            quickest: 0.0,
            haste: 0.0,
            bearable: f64::INFINITY,
        }
    }

    /// Forgets the run of substeps before: a step depends on the state alone, also after a command. What is near obstacles
    /// may have contacts of so much stiffness over mass \[1/s²\].
    pub fn begin(&mut self, bearable: f64) {
        self.bearable = bearable;
        self.allowance = [f64::NEG_INFINITY; 2];
        self.haste = 0.0;
    }

    /// Largest motion of the sheet against an obstacle near it in one substep, over half the thickness of the cloth.
    pub fn haste(&self) -> f64 {
        self.haste
    }

    /// Vertices near obstacles, in rising order.
    pub fn near(&self) -> impl Iterator<Item = u32> {
        let near = self.nearby.iter().flat_map(Nearby::vertices).copied();
        near.collect::<BTreeSet<u32>>().into_iter()
    }

    /// Lets the sheet, which has drifted, meet the obstacles, and adds elastic forces and those of contact. If `all` is asked
    /// for, every vertex of the sheet then is where it is.
    pub fn meet(
        &mut self,
        model: &Model,
        state: &mut State,
        (sheet, hands): (&mut Portion, &mut Hands),
        motion: Motion,
        all: bool,
    ) {
        let Some(law) = &model.contact else {
            return hands.pull(sheet, all);
        };
        let spent = self.follow(model, &mut state.obstacles, &sheet.nodes, motion);
        // What is near is found while other threads are at work, if nothing more of the sheet must be known for it.
        if !spent {
            self.find(model, law, state, sheet, motion.2);
        }
        hands.pull(sheet, all || spent);
        if spent {
            self.look(model, law, &state.obstacles, &sheet.nodes);
            hands.watch(self);
            self.find(model, law, state, sheet, motion.2);
        }
        self.push(model, law, state, sheet);
    }

    /// Moves the obstacles to the end of the drift. Says whether sheet and obstacles may have moved so far against each
    /// other that [`Self::look`] must come before [`Self::find`].
    fn follow(
        &mut self,
        model: &Model,
        bodies: &mut [Obstacle],
        nodes: &[Lanes],
        (time, fastest, dt): Motion,
    ) -> bool {
        self.quickest = self.move_obstacles(model, bodies, nodes, (time, dt));
        let way = (fastest + self.quickest) * dt;
        self.allowance = self.allowance.map(|allowance| allowance - way);
        self.allowance[0].is_nan() || self.allowance[0] < 0.0
    }

    /// Finds what touches after a drift of `dt`.
    fn find(&mut self, model: &Model, law: &ContactLaw, state: &State, sheet: &Portion, dt: f64) {
        let bodies = &state.obstacles[..];
        let moving = (&sheet.nodes[..], &sheet.rates[..]);
        let [speed, relative] = self.speeds_near(bodies, moving, self.quickest == 0.0);
        self.haste = self.haste.max(relative * dt / law.offset.max(law.limit()));
        let way = (speed + self.quickest) * dt;
        self.narrow(law, bodies, (&sheet.nodes, &sheet.inverse_mass), way);
        self.floors.find(law, bodies, moving);
        self.spots.clear();
        for (i, body) in bodies.iter().enumerate() {
            let near = self.soon[i].as_ref().unwrap_or(&self.nearby[i]);
            let cloth = (&model.mesh, &model.features, |v: u32| {
                vector(&sheet.nodes[v as usize])
            });
            let (search, spots) = (&mut self.search, &mut self.spots);
            let near = (near, &self.shared[i][..]);
            search.spots(cloth, (i as u32, body), near, law.offset, spots);
        }
        impulse::motions(model, &self.spots, &sheet.rates, &mut self.motions);
    }

    /// Adds the forces of what touches.
    fn push(&mut self, model: &Model, law: &ContactLaw, state: &mut State, sheet: &mut Portion) {
        let forces = &mut sheet.forces;
        self.floors.push(law, forces);
        for spot in &self.spots {
            let force = lanes(&(spot.normal * law.force(spot.share, spot.distance)));
            let face = model.mesh.faces[spot.face as usize];
            for (v, w) in face.into_iter().zip(spot.weights) {
                if w > 0.0 {
                    forces[v as usize] = add(forces[v as usize], scale(force, w));
                }
            }
        }
        if self.quickest > 0.0 {
            let bodies = &state.obstacles[..];
            state.ledger.supports += self.work_of_obstacles(model, law, bodies, &sheet.nodes);
        }
    }

    /// Brakes the sheet in contact over a substep of `dt`.
    pub fn brake(&mut self, model: &Model, state: &mut State, sheet: &mut Portion, dt: f64) {
        let Some(law) = &model.contact else { return };
        let bodies = &state.obstacles[..];
        let (still, rates) = (
            (&sheet.inverse_mass[..], &sheet.nodes[..]),
            &mut sheet.rates,
        );
        let mut taken: Taken = self.floors.brake(model, law, bodies, still, rates, dt);
        let touching = (bodies, &self.spots[..], &self.motions[..]);
        let grips = &mut self.grips;
        taken.add(impulse::brake(
            model, law, touching, still, rates, dt, grips,
        ));
        taken.book(&mut state.ledger);
    }

    /// All contacts of the substep that was last.
    pub fn touch(&mut self, model: &Model, state: &State, nodes: &[Lanes]) -> Touch {
        let mut touch = Touch {
            obstacles: state.obstacles.clone(),
            ..Touch::default()
        };
        if let Some(law) = &model.contact {
            self.refresh(nodes);
            touch.find(model, law, &self.positions, Some(&self.nearby));
        }
        touch
    }

    /// Moves the obstacles that move, and returns how fast their surfaces may be \[m/s\].
    fn move_obstacles(
        &mut self,
        model: &Model,
        bodies: &mut [Obstacle],
        nodes: &[Lanes],
        (time, dt): (f64, f64),
    ) -> f64 {
        if bodies.iter().all(Obstacle::is_still) {
            return 0.0;
        }
        if bodies.iter().any(Obstacle::may_turn) {
            self.refresh(nodes);
        }
        let before = bodies.iter().map(|body| (body.pose, body.overlap.depth));
        self.before.clear();
        self.before.extend(before);
        let speeds = bodies
            .iter()
            .map(|body| quickest(model, body, &self.positions));
        let quickest = speeds.fold(0.0, f64::max);
        model.move_obstacles(bodies, time, dt);
        quickest
    }

    /// Collects what may touch, if the sheet has moved as far as it may against the obstacles.
    fn look(&mut self, model: &Model, law: &ContactLaw, bodies: &[Obstacle], nodes: &[Lanes]) {
        self.refresh(nodes);
        let [_, far] = self.allowance;
        // Most have not gone as far as the fastest.
        let left = if far > LEFT * MARGIN {
            MARGIN - self.moved(bodies)
        } else {
            0.0
        };
        self.allowance[0] = left.min(far);
        if self.allowance[0] >= LEFT * MARGIN {
            return;
        }
        let (mesh, positions) = (&model.mesh, &self.positions);
        let find = |body| Nearby::find(mesh, positions, body, law.offset, MARGIN);
        self.nearby = bodies.iter().map(find).collect();
        let near = self.nearby.iter().flat_map(Nearby::vertices).copied();
        if rate_of(model, law, near) > self.bearable {
            self.haste = self.haste.max(UNFORESEEN);
        }
        let places = |(body, near): (&Obstacle, &Nearby)| {
            let close = near.close().iter();
            body.all_to_local(close.map(|&v| &positions[v as usize]))
        };
        self.starts = bodies.iter().zip(&self.nearby).map(places).collect();
        self.allowance = [MARGIN, FAR];
        self.sliver = f64::NEG_INFINITY;
    }

    /// Largest speed of what is near, and the largest against an obstacle \[m/s\].
    fn speeds_near(
        &self,
        bodies: &[Obstacle],
        (nodes, rates): (&[Lanes], &[Lanes]),
        still: bool,
    ) -> [f64; 2] {
        let (mut square, mut relative): (f64, f64) = (0.0, 0.0);
        for (body, near) in bodies.iter().zip(&self.nearby) {
            for &v in near.vertices() {
                let rate = rates[v as usize];
                square = square.max(dot(rate, rate));
                if !still {
                    let ground = body.velocity_at(&vector(&nodes[v as usize]));
                    relative = relative.max((vector(&rate) - ground).norm_squared());
                }
            }
        }
        [square, if still { square } else { relative }].map(f64::sqrt)
    }

    /// Collects what may touch soon, after what is near may have moved by `way` against the obstacles.
    fn narrow(
        &mut self,
        law: &ContactLaw,
        bodies: &[Obstacle],
        (nodes, inverse_mass): (&[Lanes], &[Lanes]),
        way: f64,
    ) {
        self.sliver -= way;
        if self.sliver >= 0.0 {
            return;
        }
        let position = |v: u32| vector(&nodes[v as usize]);
        let narrow =
            |(near, body): (&Nearby, &Obstacle)| near.narrow(position, body, law.offset, SLIVER);
        self.soon = self.nearby.iter().zip(bodies).map(narrow).collect();
        let soon = self.soon.iter().zip(&self.nearby);
        let soon: Vec<&Nearby> = soon
            .map(|(soon, all)| soon.as_ref().unwrap_or(all))
            .collect();
        self.shared = self.floors.sort(&soon, inverse_mass);
        self.sliver = SLIVER;
    }

    /// How far anything close to an obstacle has moved against it since \[m\].
    fn moved(&self, bodies: &[Obstacle]) -> f64 {
        let mut farthest: f64 = 0.0;
        for (body, (near, starts)) in bodies.iter().zip(self.nearby.iter().zip(&self.starts)) {
            let close = near.close().iter();
            let now = body.all_to_local(close.map(|&v| &self.positions[v as usize]));
            let squares = now
                .iter()
                .zip(starts)
                .map(|(now, start)| (now - start).norm_squared());
            farthest = squares.fold(farthest, f64::max);
        }
        farthest.sqrt()
    }

    /// Work that moving obstacles do on the sheet by normal forces while they go to where they are \[J\].
    fn work_of_obstacles(
        &self,
        model: &Model,
        law: &ContactLaw,
        bodies: &[Obstacle],
        nodes: &[Lanes],
    ) -> f64 {
        let place = |v: u32| vector(&nodes[v as usize]);
        let spots = self.spots.iter().map(|spot| {
            let face = model.mesh.faces[spot.face as usize];
            let at = weighted(&spot.weights, &face.map(place));
            let force = law.force(spot.share, spot.distance);
            (spot.obstacle as usize, at, spot.normal, force)
        });
        let work = |(obstacle, at, normal, force): (usize, Vector3<f64>, Vector3<f64>, f64)| {
            let (body, (pose, depth)) = (&bodies[obstacle], &self.before[obstacle]);
            let from = (pose * body.pose.inverse_transform_point(&at.into())).coords;
            force * (normal.dot(&(at - from)) + depth - body.overlap.depth)
        };
        self.floors.loads(law, nodes).chain(spots).map(work).sum()
    }

    fn refresh(&mut self, nodes: &[Lanes]) {
        let places = self.positions.iter_mut().zip(nodes);
        places.for_each(|(place, node)| *place = vector(node));
    }
}

/// Contact in a substep of `dt` in which nothing moves far, once more each time.
pub fn meet_once<'a>(model: &'a Model, state: &State, dt: f64) -> impl FnMut() + use<'a> {
    let mut state = state.clone();
    let mut sheet = Portion::whole(model, &state.nodes(), &[]);
    sheet.nodes = state.positions.iter().map(lanes).collect();
    sheet.rates = state.velocities.iter().map(lanes).collect();
    sheet.begin(dt);
    let mut meeting = Meeting::new(sheet.nodes.len());
    let motion = (model.script_time(&state, 0.0), 0.0, dt);
    let mut once = move || {
        let Some(law) = &model.contact else { return };
        if meeting.follow(model, &mut state.obstacles, &sheet.nodes, motion) {
            meeting.look(model, law, &state.obstacles, &sheet.nodes);
        }
        meeting.find(model, law, &state, &sheet, dt);
        meeting.push(model, law, &mut state, &mut sheet);
        meeting.brake(model, &mut state, &mut sheet, dt);
    };
    // The first time collects what is near.
    once();
    once
}
