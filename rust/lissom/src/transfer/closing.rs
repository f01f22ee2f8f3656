//! Closing: contacts are closed, and nothing is pushed into solids, once a key is stitched ([`super::contact`],
//! [`super::obstacle`]).

use std::collections::BTreeMap;

use super::anchor::Anchors;
use super::choose::{Chooser, SourceKey};
use super::contact::{self, Contact};
use super::correspondence::Correspondence;
use super::obstacle::{Least, Obstacles};
use super::place::Placer;
use crate::linear::{ConstrainedSystem, SymmetricMatrix};
use crate::{Job, Mesh, Result, Vec3};

/// How often what is missing to stay out of solids is asked for.
const ASKED: usize = 10;

/// What contact needs besides.
pub struct Closing {
    system: ConstrainedSystem,
    /// What is in the way on the target, and on the source.
    obstacles: Option<Obstacles>,
    of_source: Option<Obstacles>,
}

impl Closing {
    /// For a target that stitching has the matrix of.
    ///
    /// # Errors
    ///
    /// As [`contact::system`].
    pub fn new(source: &Mesh, target: &Mesh, stitching: &SymmetricMatrix, job: &Job) -> Result<Self> {
        let system = contact::system(target, stitching, job)?;
        Ok(Self { system, obstacles: Obstacles::of(target), of_source: Obstacles::of(source) })
    }

    /// The displacements, placed, with contacts closed and nothing pushed into solids; and the vertices that were asked
    /// for it.
    pub fn close(
        &self,
        ways: &Ways,
        Moving { key, moved, moves }: &Moving,
        stitched: &[Vec3],
    ) -> (Vec<Vec3>, Vec<u32>) {
        let Self { system, obstacles, of_source } = self;
        let &Ways { target, chooser, placer, .. } = ways;
        let with = |contacts: &[Contact]| {
            let mut displacements = stitched.to_vec();
            contact::close(target, system, contacts, &mut displacements);
            placer.place(target, chooser, key, moves, &mut displacements);
            displacements
        };
        let contacts = ways.contacts(key, moved);
        let mut displacements = with(&contacts);
        let mut asked: Vec<u32> = contacts.iter().flat_map(Contact::vertices).collect();
        let Some(obstacles) = obstacles else { return (displacements, asked) };
        let least = match of_source {
            Some(solids) => ways.as_far_as_on_the_source(solids, key, moved),
            None => {
                let mut least = vec![Least::Travelled; displacements.len()];
                asked.iter().for_each(|&v| least[v as usize] = Least::Outside(f64::INFINITY));
                least
            }
        };
        let mut points: BTreeMap<u32, Vec3> = BTreeMap::new();
        for _ in 0..ASKED {
            let short = obstacles.short(target, &least, &displacements);
            if short.is_empty() {
                break;
            }
            for (v, by) in short {
                let at = target.rest()[v as usize] + displacements[v as usize];
                *points.entry(v).or_insert(at) += by;
            }
            let pulls = points.iter().map(|(&v, &point)| Contact::with_point(target, v, point));
            displacements = with(&contacts.iter().cloned().chain(pulls).collect::<Vec<_>>());
        }
        asked.extend(points.into_keys());
        (displacements, asked)
    }
}

/// What a transfer goes by.
#[derive(Clone, Copy)]
pub struct Ways<'a> {
    pub source: &'a Mesh,
    pub target: &'a Mesh,
    pub used: &'a Correspondence,
    pub chooser: &'a Chooser,
    pub anchors: &'a Anchors,
    pub placer: &'a Placer,
}

/// A key on its way.
pub struct Moving<'a> {
    pub key: SourceKey<'a>,
    /// Displacements of the images of the target's vertices.
    pub moved: Vec<Vec3>,
    /// Whether each of its triangles moves.
    pub moves: Vec<bool>,
}

impl Ways<'_> {
    /// What comes together in a key.
    pub fn contacts(&self, key: &SourceKey, moved: &[Vec3]) -> Vec<Contact> {
        let size = |component| self.anchors.size(component);
        contact::contacts(self.source, self.target, self.used, key, moved, size)
    }

    /// How far outside of solids the images of the target's vertices are.
    fn as_far_as_on_the_source(&self, solids: &Obstacles, key: &SourceKey, moved: &[Vec3]) -> Vec<Least> {
        let image = |(v, &moved): (usize, &Vec3)| {
            let at = self.chooser.image(v)? + moved;
            let triangle = self.used.images.get(v).copied().flatten()?.triangle;
            Some((self.source.triangles()[triangle as usize][0], at))
        };
        let images: Vec<_> = moved.iter().enumerate().map(image).collect();
        let outside = solids.outside(self.source, &key.displacement, &images);
        let size = |v: usize| self.target.components().of_vertex(v).map(|c| self.anchors.size(c));
        let least = |v: usize| match images[v].and(size(v)) {
            Some(size) => Least::Outside(outside[v].map_or(f64::INFINITY, |outside| outside * size)),
            None => Least::Travelled,
        };
        (0..moved.len()).map(least).collect()
    }
}
