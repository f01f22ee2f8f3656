//! Closing: once a key is stitched, the openings that close in it are closed, and what does so is not pushed into
//! obstacles ([`super::rims`], [`super::contact`], [`super::obstacle`]).

use std::collections::BTreeMap;
use std::sync::OnceLock;

use super::anchor::Anchors;
use super::choose::{Chooser, SourceKey};
use super::contact::{self, Contact};
use super::correspondence::Correspondence;
use super::obstacle::{Least, Obstacles};
use super::place::Placer;
use super::rims::Rims;
use crate::linear::{ConstrainedSystem, SymmetricMatrix};
use crate::{Job, Mesh, Result, Vec3};

/// How often what is missing to stay out of obstacles is asked for.
const ASKED: usize = 10;

/// What contact needs besides, once a key needs it.
#[derive(Default)]
pub struct Closing(OnceLock<Prepared>);

/// The same, prepared.
pub struct Prepared {
    system: ConstrainedSystem,
    /// What is in the way on the target, and on the source.
    obstacles: Option<Obstacles>,
    of_source: Option<Obstacles>,
    /// The target's vertices that the former may be in the way of.
    vertices: Vec<u32>,
}

impl Closing {
    /// Prepares it for a target that stitching has the matrix of.
    ///
    /// # Errors
    ///
    /// As [`contact::system`].
    pub fn prepare(&self, ways: &Ways, rims: &Rims, stitching: &SymmetricMatrix, job: &Job) -> Result<()> {
        if self.0.get().is_none() {
            let meeting = rims.vertices();
            let system = contact::system(ways.target, stitching, &meeting, job)?;
            let corrected = || system.constraints().free().iter().copied();
            let obstacles = Obstacles::near(ways.target, &meeting);
            let vertices =
                obstacles.as_ref().map_or(Vec::new(), |found| found.in_the_way(ways.target, corrected()));
            let obstacles = obstacles.filter(|_| !vertices.is_empty());
            let of_source = obstacles.as_ref().and_then(|_| Obstacles::near(ways.source, &rims.images()));
            // Whoever was first has made the same.
            let _ = self.0.set(Prepared { system, obstacles, of_source, vertices });
        }
        Ok(())
    }

    /// What is prepared.
    pub fn prepared(&self) -> Option<&Prepared> {
        self.0.get()
    }
}

impl Prepared {
    /// The displacements, placed, with contacts closed and nothing pushed into obstacles; and the vertices that were asked
    /// for it.
    pub fn close(
        &self,
        ways: &Ways,
        Moving { key, moved, moves, contacts }: &Moving,
        stitched: &[Vec3],
    ) -> (Vec<Vec3>, Vec<u32>) {
        let &Ways { target, chooser, placer, .. } = ways;
        let mut y = Vec::new();
        let mut with = |contacts: &[Contact]| {
            let mut displacements = stitched.to_vec();
            contact::close(target, &self.system, contacts, &mut y, &mut displacements);
            placer.place(target, chooser, key, moves, &mut displacements);
            displacements
        };
        let mut displacements = with(contacts);
        let mut asked: Vec<u32> = contacts.iter().flat_map(Contact::vertices).collect();
        let Some(obstacles) = &self.obstacles else { return (displacements, asked) };
        let standing = obstacles.standing(target, &displacements);
        let vertices = obstacles.reached(target, &standing, &self.vertices, &displacements);
        let least = self.least(ways, key, moved, contacts, &vertices);
        // In the order in which they came, as what is found for them is.
        let (mut points, mut place) = (Vec::new(), BTreeMap::new());
        let mut pulled = contacts.clone();
        for _ in 0..ASKED {
            let short = obstacles.short(target, &standing, &least, &displacements);
            if short.is_empty() {
                break;
            }
            for (v, by) in short {
                let slot = *place.entry(v).or_insert_with(|| {
                    points.push((v, target.rest()[v as usize] + displacements[v as usize]));
                    points.len() - 1
                });
                points[slot].1 += by;
            }
            pulled.truncate(contacts.len());
            pulled.extend(points.iter().map(|&(v, point)| Contact::with_point(target, v, point)));
            displacements = with(&pulled);
        }
        asked.extend(points.iter().map(|&(v, _)| v));
        (displacements, asked)
    }

    /// How far outside of obstacles vertices must be: as far as their images are, or those that meet outside of all.
    fn least(
        &self,
        ways: &Ways,
        key: &SourceKey,
        moved: &[Vec3],
        contacts: &[Contact],
        vertices: &[u32],
    ) -> Vec<(u32, Least)> {
        let Some(of_source) = &self.of_source else {
            let mut least: BTreeMap<u32, Least> = vertices.iter().map(|&v| (v, Least::Travelled)).collect();
            let met = contacts.iter().flat_map(Contact::vertices);
            least.extend(met.map(|v| (v, Least::Outside(f64::INFINITY))));
            return least.into_iter().collect();
        };
        let image = |&v: &u32| {
            let at = ways.chooser.image(v as usize)? + moved[v as usize];
            let triangle = ways.used.images.get(v as usize).copied().flatten()?.triangle;
            Some((ways.source.triangles()[triangle as usize][0], at))
        };
        let images: Vec<_> = vertices.iter().map(image).collect();
        let outside = of_source.outside(ways.source, &key.displacement, &images);
        let size = |v: u32| ways.target.components().of_vertex(v as usize).map(|c| ways.anchors.size(c));
        let least = |k: usize| match images[k].and(size(vertices[k])) {
            Some(size) => Least::Outside(outside[k].map_or(f64::INFINITY, |outside| outside * size)),
            None => Least::Travelled,
        };
        (0..vertices.len()).map(|k| (vertices[k], least(k))).collect()
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
    /// What comes together.
    pub contacts: Vec<Contact>,
}

impl Ways<'_> {
    /// What can come together.
    pub fn rims(&self) -> Rims {
        Rims::new(self.source, self.target, self.used, |component| self.anchors.size(component))
    }

    /// What comes together in a key, without `all` as far as gradients alone do not see to it.
    pub fn contacts(&self, rims: &Rims, key: &SourceKey, all: bool) -> Vec<Contact> {
        let size = |component| self.anchors.size(component);
        rims.contacts(self.source, self.target, self.used, key, size, all)
    }
}
