//! Rims: places that face each other across an opening, as those of lids and lips do, and come together as it closes.
//!
//! What they ask for in a key is told in [`super::opening`]. Which places touch once an opening has
//! closed is seen in the key itself ([`super::touching`]). What is near to each other at rest, as lips are, has no
//! opening: it slides, and the gradients say how.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::choose::SourceKey;
use super::contact::{Contact, mass};
use super::correspondence::Correspondence;
use super::image::SurfacePoint;
use super::opening::{BRUSHED, Opening, Own, Place, Rim};
use super::ridges::ridges;
use super::touching::{Touching, across, at_place};
use crate::geometry::groups::Groups;
use crate::geometry::surface::Surface;
use crate::geometry::triangle::interpolate;
use crate::mesh::Paths;
use crate::{Mesh, Vec3};

/// Openings are at most so wide and at least so narrow, as fractions of the source's diagonal: eyes are 3 % of a head.
const WIDE: f64 = 0.12;
const NARROW: f64 = 0.006;

/// Places face each other by the cosine between their normals, and by that between them and the way across.
const OPPOSED: f64 = -0.3;
const FACING: f64 = 0.3;

/// What is so near to a rim, a fraction of the source's diagonal and in edges, goes with it: lids are as thick.
const BESIDE: f64 = 0.01;
const RINGS: usize = 3;

/// The openings of a source and a target that belong together.
pub struct Rims(Vec<Opening>);

impl Rims {
    /// Finds them, within components of the target; `size` is that of the target over that of the source, for each.
    pub fn new(
        source: &Mesh,
        target: &Mesh,
        matches: &Correspondence,
        size: impl Fn(usize) -> f64 + Sync,
    ) -> Self {
        let outward = source.outward_triangles();
        let corners: Vec<[Vec3; 3]> = outward.iter().map(|t| t.map(|v| source.rest()[v as usize])).collect();
        let on_ridge = ridges(source, &outward);
        let ridges: Vec<bool> = outward.iter().map(|t| t.iter().any(|&v| on_ridge[v as usize])).collect();
        let surface = Surface::in_parts(corners, |t| ridges[t], &[]);
        let image = |v: u32| {
            let image = matches.images.get(v as usize).copied().flatten()?;
            ridges[image.triangle as usize].then_some(image)
        };
        let rim = |v: u32| {
            let (image, from, there) = opposite(source, &outward, &surface, image(v)?)?;
            let place = across(target, matches, v, there)?;
            let own = target.components().of_vertex(v as usize)?;
            let here = (source.triangles()[image.triangle as usize], image.weights);
            Rim::new(target, v, place, [here, there], from, size(own))
        };
        let is_known = |v: &u32| image(*v).is_some() && !matches.back_images.is_empty();
        let mut rims = along(target, (0..target.rest().len() as u32).filter(is_known), rim);
        widen(&mut rims, source, target, matches, size);
        let paths = Paths::new(source.adjacency(), source.rest(), 0.0);
        let opening = |rims: Vec<Rim>| {
            let images = rims.iter().flat_map(|rim| rim.images.iter().flat_map(|image| image.0));
            let touching = Touching::new(source, target, matches, &paths, images);
            let own = Own::of(source, target, &paths, &rims);
            Opening { rims, touching, own }
        };
        Self(openings(target, rims).into_iter().map(opening).collect())
    }

    /// Those that gradients alone do not close.
    fn of_own_height(&self) -> impl Iterator<Item = &Opening> {
        self.0.iter().filter(|opening| opening.own.touching > 0.0)
    }

    /// The target's vertices along those that gradients alone do not close.
    pub fn vertices(&self) -> Vec<u32> {
        let rims = self.of_own_height().flat_map(|opening| &opening.rims);
        rims.flat_map(|rim| rim.place.iter().map(|&(v, _)| v).chain([rim.vertex])).collect()
    }

    /// Vertices of the source around their images.
    pub fn images(&self) -> Vec<u32> {
        let rims = self.of_own_height().flat_map(|opening| &opening.rims);
        rims.flat_map(|rim| rim.images.iter().flat_map(|image| image.0)).collect()
    }

    /// What comes together in a key: none where nothing closes. Without `all` less of what gradients alone close.
    pub fn contacts(
        &self,
        source: &Mesh,
        target: &Mesh,
        matches: &Correspondence,
        key: &SourceKey,
        size: impl Fn(usize) -> f64 + Sync,
        all: bool,
    ) -> Vec<Contact> {
        let mut contacts = BTreeMap::new();
        for opening in &self.0 {
            let own = if all { Own::ALL } else { opening.own };
            if own.touching == 0.0 {
                continue;
            }
            let mut found = opening.closing(target, key, own);
            if !found.is_empty() {
                let touching = &opening.touching;
                found.extend(touching.contacts(source, target, matches, key, &size, own.touching));
                contacts.extend(found);
            }
        }
        contacts.into_values().collect()
    }
}

/// Rims sorted by the opening that they are around, without those that are too short.
fn openings(target: &Mesh, rims: Vec<Rim>) -> Vec<Vec<Rim>> {
    let mut is_rim = vec![false; target.rest().len()];
    rims.iter().for_each(|rim| is_rim[rim.vertex as usize] = true);
    let beside = target.adjacency().edges().iter().filter(|edge| edge.iter().all(|&v| is_rim[v as usize]));
    let across = rims.iter().flat_map(|rim| rim.place.iter().map(|&(v, _)| [rim.vertex, v]));
    let groups = Groups::joining(is_rim.len(), beside.copied().chain(across));
    let mut of_group: BTreeMap<u32, Vec<Rim>> = BTreeMap::new();
    for rim in rims {
        of_group.entry(groups.of()[rim.vertex as usize]).or_default().push(rim);
    }
    let length = |rims: &[Rim]| rims.iter().map(|rim| mass(target, rim.vertex).sqrt()).sum::<f64>();
    of_group.into_values().filter(|rims| length(rims) > BRUSHED).collect()
}

/// The image of a vertex, the way from there to the nearest place of the source that it faces, and that place.
fn opposite(
    source: &Mesh,
    outward: &[[u32; 3]],
    surface: &Surface,
    image: SurfacePoint,
) -> Option<(SurfacePoint, Vec3, Place)> {
    let own = image.triangle as usize;
    let here = interpolate(source.triangles()[own].map(|v| source.rest()[v as usize]), image.weights);
    let normal = surface.normal(own);
    // An eye behind the lids is across too, and nothing that closes.
    let component = |t: usize| source.components().of_vertex(outward[t][0] as usize);
    let part = component(own);
    let faced = |t: usize| {
        let (other, way) = (surface.normal(t), surface.centroid(t) - here);
        other.dot(normal) < OPPOSED && way.dot(normal) > 0.0 && way.dot(other) < 0.0 && component(t) == part
    };
    let hit = surface.closest_compatible_point_on(here, -normal, WIDE, faced)?;
    let (from, length) = (hit.point - here, hit.distance);
    let cosines = [from.dot(normal), -from.dot(surface.normal(hit.triangle))];
    let is_opening = length > NARROW && cosines.into_iter().all(|cosine| cosine > FACING * length);
    is_opening.then_some((image, from, (outward[hit.triangle], hit.weights)))
}

/// The rims of some vertices, as far as they hang together with such of a few of them: no two that are neighbours, and
/// of all others a neighbour.
fn along(
    target: &Mesh,
    vertices: impl Iterator<Item = u32>,
    rim: impl Fn(u32) -> Option<Rim> + Sync,
) -> Vec<Rim> {
    let around = |v: u32| {
        let corners = target.adjacency().corners_of(v as usize).iter();
        corners.flat_map(|corner| target.triangles()[corner.triangle as usize])
    };
    let mut beside = vec![false; target.rest().len()];
    let mut next = Vec::new();
    for v in vertices {
        if !beside[v as usize] {
            next.push(v);
            around(v).for_each(|w| beside[w as usize] = true);
        }
    }
    let mut seen = vec![false; target.rest().len()];
    next.iter().for_each(|&v| seen[v as usize] = true);
    let mut rims = Vec::new();
    while !next.is_empty() {
        let found: Vec<Rim> = next.par_iter().filter_map(|&v| rim(v)).collect();
        next = found.iter().flat_map(|rim| around(rim.vertex)).collect();
        next.retain(|&v| !std::mem::replace(&mut seen[v as usize], true));
        rims.extend(found);
    }
    rims.sort_unstable_by_key(|rim| rim.vertex);
    rims
}

/// Takes in what is beside each rim, with the same place across.
fn widen(
    rims: &mut Vec<Rim>,
    source: &Mesh,
    target: &Mesh,
    matches: &Correspondence,
    size: impl Fn(usize) -> f64,
) {
    let at = |image: &Place| at_place(image, source.rest());
    let mut of_vertex = vec![None; target.rest().len()];
    rims.iter().enumerate().for_each(|(k, rim)| of_vertex[rim.vertex as usize] = Some(k));
    // The rim that each one comes from in the first place.
    let mut roots: Vec<usize> = (0..rims.len()).collect();
    for _ in 0..RINGS {
        let mut nearest: BTreeMap<u32, (f64, usize)> = BTreeMap::new();
        for &[a, b] in target.adjacency().edges() {
            for (known, v) in [(a, b), (b, a)] {
                let (Some(k), None) = (of_vertex[known as usize], of_vertex[v as usize]) else {
                    continue;
                };
                let Some(image) = matches.images[v as usize] else { continue };
                let here = (source.triangles()[image.triangle as usize], image.weights);
                let distance = at(&here).distance(at(&rims[roots[k]].images[0]));
                let best = nearest.get(&v).map_or(BESIDE, |best| best.0);
                if distance < best {
                    nearest.insert(v, (distance, roots[k]));
                }
            }
        }
        for (v, (_, root)) in nearest {
            let Some(image) = matches.images[v as usize] else { continue };
            let here = (source.triangles()[image.triangle as usize], image.weights);
            let (there, place) = (rims[root].images[1], rims[root].place.clone());
            let from = at(&there) - at(&here);
            let Some(own) = target.components().of_vertex(v as usize) else { continue };
            if let Some(rim) = Rim::new(target, v, place, [here, there], from, size(own)) {
                of_vertex[v as usize] = Some(rims.len());
                rims.push(rim);
                roots.push(root);
            }
        }
    }
}
