//! The energy of [`super::arap`] as a function of its rotations, for a descent: of a region on its way to a goal,
//! the shape that matches rotations best, and the torques that the energy puts on them there.

use super::flat::Turns;
use super::goal::Goal;
use super::lever::{self, Lever};
use super::region::Region;
use crate::linear::ConstrainedSystem;
use crate::stitch::{AtRest, Descent, Differences, Stitcher, turned, turned_less};
use crate::symmetry::Symmetry;
use crate::{Mat3, Quat, Vec3};

/// What the energy of a region is made of.
#[derive(Debug)]
pub(super) struct Energy {
    /// Of weights times `1 - l`.
    pub(super) stitcher: Stitcher,
    /// Covariances of the cells at rest.
    pub(super) rest: Vec<Mat3>,
    /// `a` times the region's area, against weights times `1 - l`, over the number of cells of an edge.
    pub(super) rotation_smoothing: f64,
    /// What vertices own besides their edges.
    pub(super) differences: Vec<Differences>,
    /// Of the descent, where rotations are smoothed.
    pub(super) metric: Option<ConstrainedSystem>,
}

/// A region on its way to a goal.
pub(super) struct Posing<'a> {
    pub(super) energy: &'a Energy,
    pub(super) symmetry: &'a Symmetry,
    pub(super) goal: &'a Goal,
    /// Those of the goal's pivots.
    pub(super) levers: Vec<Lever<'a>>,
    pub(super) turns: Turns,
}

/// Rotations, and the shape that matches them best.
#[derive(Debug)]
pub(super) struct Turned {
    pub(super) rotations: Vec<Quat>,
    /// Of the levers, further than the goal.
    pub(super) turns: Vec<Quat>,
    pub(super) displacements: Vec<Vec3>,
    /// Half the gradient by the rotations, then by the turns.
    pub(super) torques: Vec<Vec3>,
    /// How far each is from the one that fits best, where they are not smoothed.
    pub(super) misfits: Vec<Vec3>,
    pub(super) energy: f64,
    pub(super) size: f64,
}

impl<'a> Posing<'a> {
    /// A region's way to a goal, as its handles turn.
    pub(super) fn of(
        energy: &'a Energy,
        levers: &'a [Option<(Vec<f64>, Mat3)>],
        region: &'a Region,
        goal: &'a Goal,
    ) -> Self {
        let levers = goal.pivots.iter().filter_map(|&(h, pivot)| {
            let (weights, compliance) = levers.get(h)?.as_ref()?;
            Some(Lever::of(region, goal, (h, pivot), weights, *compliance))
        });
        let (levers, turns) = (levers.collect(), Turns::of(region, goal));
        Self { energy, symmetry: region.symmetry(), goal, levers, turns }
    }

    /// The shape that matches rotations best.
    pub(super) fn stitched(&self, rotations: Vec<Quat>, turns: Vec<Quat>) -> Turned {
        let asked = self.asked(&rotations);
        let mut displacements = [lever::asked(&self.goal.displacements, &self.levers, &turns)];
        self.energy.stitcher.system().solve(&[&asked], &mut displacements);
        let [displacements] = displacements;
        self.at(rotations, turns, displacements, &asked)
    }

    /// What rotations ask of the displacements.
    fn asked(&self, rotations: &[Quat]) -> Vec<Vec3> {
        let mut asked = self.energy.stitcher.turn_divergence(rotations);
        for differences in &self.energy.differences {
            differences.add_divergence(|i, v| turned_less(rotations[i], v), &mut asked);
        }
        asked
    }

    /// Rotations with the shape that matches them best. `asked` is what they ask of it, where there are levers.
    pub(super) fn at(
        &self,
        rotations: Vec<Quat>,
        turns: Vec<Quat>,
        displacements: Vec<Vec3>,
        asked: &[Vec3],
    ) -> Turned {
        let Energy { stitcher, rest, rotation_smoothing, differences, .. } = self.energy;
        let more = |i: usize| {
            let at = differences.iter().map(|differences| differences.at(i, &displacements));
            at.fold((Mat3::ZERO, 0.0), |sum, own| (sum.0 + own.0, sum.1 + own.1))
        };
        let nearest = |m| self.turns.nearest(m);
        let at_rest = AtRest { covariances: rest, smoothing: *rotation_smoothing, nearest };
        let mut turning = stitcher.turning(at_rest, &rotations, &displacements, more);
        // Else rounding grows where a symmetric shape is no minimum, as one that buckles.
        self.symmetry.symmetrise_turns(&mut turning.torques);
        if !turning.misfits.is_empty() {
            self.symmetry.symmetrise_turns(&mut turning.misfits);
            turning.misfits.resize(rotations.len() + turns.len(), Vec3::ZERO);
        }
        let soft = stitcher.system().constraints().soft();
        let given = match soft {
            [] => Vec::new(),
            _ => lever::asked(&self.goal.displacements, &self.levers, &turns),
        };
        let missed = |&(v, weight): &(u32, f64)| {
            weight * displacements[v as usize].distance_squared(given[v as usize])
        };
        let pulls: f64 = soft.iter().map(missed).sum();
        let (energy, size) = (turning.energy + pulls, turning.size + pulls);
        let (mut torques, misfits) = (turning.torques, turning.misfits);
        if !self.levers.is_empty() {
            let mut forces = stitcher.matrix().times_vectors(&displacements);
            forces.iter_mut().zip(asked).for_each(|(force, &asked)| *force -= asked);
            lever::add_torques(&mut torques, &self.levers, (&rotations, &turns), &forces);
        }
        self.turns.project(&mut torques);
        Turned { rotations, turns, displacements, torques, misfits, energy, size }
    }
}

impl Descent for Posing<'_> {
    type Point = Turned;

    fn energy(&self, at: &Turned) -> (f64, f64) {
        (at.energy, at.size)
    }

    fn gradient(&self, at: &Turned) -> [Vec<Vec3>; 2] {
        let (own, of_handles) = at.torques.split_at(at.rotations.len());
        let mut divided: Vec<Vec3> = match &self.energy.metric {
            None => at.misfits[..own.len()].iter().map(|&misfit| -misfit).collect(),
            Some(metric) => {
                let mut divided = [vec![Vec3::ZERO; own.len()]];
                metric.solve(&[own], &mut divided);
                let [mut divided] = divided;
                self.symmetry.symmetrise_turns(&mut divided);
                divided
            }
        };
        divided.extend(self.levers.iter().zip(of_handles).map(|(lever, &torque)| lever.compliance * torque));
        self.turns.project(&mut divided);
        [at.torques.clone(), divided]
    }

    fn moved(&self, from: &Turned, direction: &[Vec3], length: f64) -> Turned {
        if self.levers.is_empty() {
            return self.stitched(turned(&from.rotations, direction, length), Vec::new());
        }
        let of_vertices = lever::with_levers(direction, &self.levers, (&from.rotations, &from.turns));
        let turns = turned(&from.turns, &direction[of_vertices.len()..], length);
        self.stitched(turned(&from.rotations, &of_vertices, length), turns)
    }
}
