//! Handles and their mirror images, which move as theirs.
//!
//! A handle whose mirror image is itself moves as what is left of its motion when it is symmetric: a turn about the
//! normal and a shift along the plane. Of two that are each other's image, one leads. Of any other the image is a
//! handle more.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::goal::{HandleMotion, image_of_matrix, symmetric};
use super::handles::{self, Handle};
use super::method::CommonOptions;
use crate::geometry::plane::expect_perpendicular;
use crate::mesh::{Plane, UnitFrame};
use crate::symmetry::Symmetry;
use crate::{Error, Fault, Mat4, Mesh, Result, Vec3};

/// Two handles are as far on the normal's side where they differ by less, of the diagonal.
const SAME_HEIGHT: f64 = 1e-9;

/// The symmetry of a pose, and its handles.
#[derive(Debug)]
pub(super) struct Mirrored {
    symmetry: Symmetry,
    /// As the caller gave them.
    given: Vec<Handle>,
    /// One for each of those, in their order, and the added ones.
    all: Vec<Follows>,
}

/// How a handle moves.
#[derive(Debug, Clone)]
struct Follows {
    /// The given handle that leads it, which may be itself.
    of: usize,
    /// Across which planes, in turn.
    across: Vec<Plane>,
    /// The planes that it is symmetric about, and its centre on them.
    about: Vec<Plane>,
    centre: Vec3,
}

impl Mirrored {
    /// The mesh that is posed, its mirror images included, and the handles on it.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidConstraint`] for bad handles, also those whose image lies in several handles;
    /// [`Error::InvalidValue`] for planes that are not at right angles, or that the mesh is not symmetric about.
    pub fn of(
        mesh: Arc<Mesh>,
        given: Vec<Handle>,
        common: &CommonOptions,
    ) -> Result<(Self, Arc<Mesh>, Vec<Handle>)> {
        let mut mirrored = Self { symmetry: Symmetry::default(), all: Vec::new(), given };
        mirrored.all = (0..mirrored.given.len()).map(Follows::itself).collect();
        let mut handles = mirrored.given.clone();
        if common.mirror.is_empty() && common.symmetry.is_empty() {
            return Ok((mirrored, mesh, handles));
        }
        handles::check(mesh.vertices().len(), &handles, common.hold())?;
        expect_perpendicular("mirror", &common.mirror)?;
        let all = [common.mirror.as_slice(), &common.symmetry].concat();
        expect_perpendicular("symmetry", &all)?;
        let tolerance = common.mirror_tolerance;
        let (mesh, symmetry) = Symmetry::completed(&mesh, &[mesh.vertices()], &common.mirror, tolerance)?;
        mirrored.symmetry = symmetry;
        mirrored.symmetry.add("symmetry", &mesh, &common.symmetry, tolerance)?;
        for (plane, twins) in mirrored.symmetry.planes() {
            mirror(&mut handles, &mut mirrored.all, plane, twins, &mesh)?;
        }
        for (own, handle) in mirrored.all.iter_mut().zip(&handles) {
            let sum: Vec3 = handle.vertices.iter().map(|&v| mesh.vertices()[v as usize]).sum();
            let centre = sum / handle.vertices.len() as f64;
            own.centre = own.about.iter().fold(centre, |c, plane| c - plane.normal * plane.height(c));
        }
        Ok((mirrored, Arc::new(mesh), handles))
    }

    /// All handles that move with some of the given ones, ascending.
    pub fn all_of(&self, given: &[usize]) -> Vec<usize> {
        let leaders: BTreeSet<usize> = given.iter().map(|&h| self.all[h].of).collect();
        (0..self.all.len()).filter(|&h| leaders.contains(&self.all[h].of)).collect()
    }

    /// Motions of all handles whose turns about their `centres` are as symmetric as the handles: rounding is not.
    pub fn symmetrise_motions(
        &self,
        motions: &[HandleMotion],
        centres: &[Vec3],
        frame: UnitFrame,
    ) -> Vec<HandleMotion> {
        let mut leading = self.leading(motions);
        for (motion, h) in leading.iter_mut().zip(self.leaders()) {
            let about = &self.all[h].about;
            if !about.is_empty() {
                let turn = about.iter().fold(motion.rotation, |turn, plane| turn - plane.tangential(turn));
                *motion = motion.turned_about(centres[h], turn);
            }
        }
        self.motions(&leading, frame)
    }

    /// The handles as given.
    pub fn given(&self) -> &[Handle] {
        &self.given
    }

    /// What the mesh and the handles are symmetric about.
    pub fn symmetry(&self) -> &Symmetry {
        &self.symmetry
    }

    /// The vertices of a region and their mirror images; vertices out of range are left to whoever checks them.
    pub fn region(&self, mut roi: Vec<u32>) -> Vec<u32> {
        for (_, twins) in self.symmetry.planes() {
            let twin = |&v: &u32| twins.get(v as usize).copied().flatten().filter(|&w| w != v);
            roi.extend(roi.iter().filter_map(twin).collect::<Vec<_>>());
        }
        roi
    }

    /// What is worth saying: handles whose own motion does not count.
    pub fn warning(&self) -> Option<String> {
        let follows = |&h: &usize| self.all[h].of != h;
        let problem = "handles that follow the one on the other side, of which they are the mirror image";
        Fault::at("handles", problem, (0..self.given.len()).filter(follows)).map(|fault| fault.to_string())
    }

    /// What leads, of something per handle.
    pub fn leading<T: Copy>(&self, all: &[T]) -> Vec<T> {
        self.leaders().map(|h| all[h]).collect()
    }

    fn leaders(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.given.len()).filter(|&h| self.all[h].of == h)
    }

    /// The matrices that lead, and their whole turns, as symmetric as their handles.
    pub fn lead(&self, transforms: &[Mat4], turns: Option<&[Vec3]>) -> (Vec<Mat4>, Option<Vec<Vec3>>) {
        let (mut transforms, mut turns) = (self.leading(transforms), turns.map(|turns| self.leading(turns)));
        for (place, h) in self.leaders().enumerate() {
            let own = &self.all[h];
            for plane in &own.about {
                transforms[place] = symmetric(transforms[place], plane, own.centre);
                if let Some(turns) = &mut turns {
                    turns[place] = turns[place] - plane.tangential(turns[place]);
                }
            }
        }
        (transforms, turns)
    }

    /// Something per handle from that of those that lead, where `image` is its mirror image.
    fn follow<T: Copy>(&self, leading: &[T], image: impl Fn(T, &Plane) -> T) -> Vec<T> {
        let mut place = vec![0; self.given.len()];
        self.leaders().enumerate().for_each(|(i, h)| place[h] = i);
        let of = |own: &Follows| own.across.iter().fold(leading[place[own.of]], &image);
        self.all.iter().map(of).collect()
    }

    /// The matrices of all handles from those that lead.
    pub fn transforms(&self, leading: &[Mat4]) -> Vec<Mat4> {
        self.follow(leading, image_of_matrix)
    }

    /// The motions of all handles from those that lead; `frame` is that of the mesh.
    pub fn motions(&self, leading: &[HandleMotion], frame: UnitFrame) -> Vec<HandleMotion> {
        self.follow(leading, |motion, plane| {
            let unit = Plane { point: frame.to_unit(plane.point), ..*plane };
            let HandleMotion { rotation, whole_turns, linear, offset } = motion;
            let (matrix, origin) = (plane.matrix(), unit.image(Vec3::ZERO));
            HandleMotion {
                rotation: -plane.reflect(rotation),
                whole_turns: -plane.reflect(whole_turns),
                linear: matrix * linear * matrix,
                offset: plane.reflect(linear * origin + offset - origin),
            }
        })
    }

    /// Targets of the vertices of all `handles` from those of the given ones.
    pub fn targets(&self, mesh: &Mesh, handles: &[Handle], given: &[Vec3]) -> Vec<Vec3> {
        if self.symmetry.planes().len() == 0 {
            return given.to_vec();
        }
        let rest = mesh.vertices();
        let follows = |h: usize| self.all[h].of != h;
        let vertices = self
            .given
            .iter()
            .enumerate()
            .flat_map(|(h, handle)| handle.vertices.iter().map(move |&v| (follows(h), v)));
        let mut asked: Vec<(bool, u32, Vec3)> = vertices
            .zip(given)
            .map(|((follows, v), &target)| (follows, v, target - rest[v as usize]))
            .collect();
        asked.sort_by_key(|(follows, ..)| *follows);
        let mut known: Vec<Option<Vec3>> = vec![None; rest.len()];
        for &(_, v, d) in asked.iter().filter(|(follows, ..)| !follows) {
            known[v as usize] = Some(d);
        }
        // Handles that lead come first; what they say of the other side stands.
        for (_, v, d) in asked {
            let mut orbit = vec![(v, d)];
            for (plane, twins) in self.symmetry.planes() {
                let twin =
                    |&(u, d): &(u32, Vec3)| Some((twins[u as usize].filter(|&w| w != u)?, plane.reflect(d)));
                orbit.extend(orbit.iter().filter_map(twin).collect::<Vec<_>>());
            }
            for (w, d) in orbit {
                known[w as usize].get_or_insert(d);
            }
        }
        let vertices = handles.iter().flat_map(|handle| &handle.vertices);
        vertices.map(|&v| rest[v as usize] + known[v as usize].unwrap_or_default()).collect()
    }

    /// Makes positions as symmetric as the mesh: what is on a plane stays at its height above it, to the last bit.
    pub fn symmetrise(&self, mesh: &Mesh, vertices: &mut [Vec3]) {
        if self.symmetry.planes().len() == 0 {
            return;
        }
        let rest = mesh.vertices();
        let mut moved: Vec<Vec3> = vertices.iter().zip(rest).map(|(&x, &v)| x - v).collect();
        self.symmetry.symmetrise(&mut moved);
        vertices.iter_mut().zip(rest.iter().zip(moved)).for_each(|(x, (&v, d))| *x = v + d);
    }

    /// The same of the `targets` of the vertices of all `handles`.
    pub fn symmetrise_targets(&self, mesh: &Mesh, handles: &[Handle], targets: &mut [Vec3]) {
        if self.symmetry.planes().len() == 0 {
            return;
        }
        let rest = mesh.vertices();
        let mut moved = vec![Vec3::ZERO; rest.len()];
        let vertices: Vec<usize> = handles.iter().flat_map(|h| &h.vertices).map(|&v| v as usize).collect();
        vertices.iter().zip(&*targets).for_each(|(&v, &target)| moved[v] = target - rest[v]);
        self.symmetry.symmetrise(&mut moved);
        vertices.iter().zip(targets).for_each(|(&v, target)| *target = rest[v] + moved[v]);
    }
}

impl Follows {
    fn itself(handle: usize) -> Self {
        Self { of: handle, across: Vec::new(), about: Vec::new(), centre: Vec3::ZERO }
    }
}

/// Makes handles symmetric about a plane.
fn mirror(
    handles: &mut Vec<Handle>,
    all: &mut Vec<Follows>,
    plane: &Plane,
    twins: &[Option<u32>],
    mesh: &Mesh,
) -> Result<()> {
    let mut owner = vec![None; twins.len()];
    for (h, handle) in handles.iter().enumerate() {
        handle.vertices.iter().for_each(|&v| owner[v as usize] = Some(h));
    }
    let partner = |h: usize| -> Result<Option<usize>> {
        let there = handles[h].vertices.iter().filter_map(|&v| owner[twins[v as usize]? as usize]);
        let there: Vec<usize> = there.collect::<BTreeSet<_>>().into_iter().collect();
        match there[..] {
            [] => Ok(None),
            [g] => Ok(Some(g)),
            _ => {
                let others: Vec<String> = there.iter().map(|&g| all[g].of.to_string()).collect();
                let problem = format!(
                    "the mirror image of handle {} lies in handles {}: it must be one's alone",
                    all[h].of,
                    others.join(" and ")
                );
                Err(Error::InvalidConstraint(Fault::new("handles", problem)))
            }
        }
    };
    let partners = (0..handles.len()).map(partner).collect::<Result<Vec<_>>>()?;
    for (h, partner) in partners.into_iter().enumerate() {
        match partner {
            None => {
                let image = across(&handles[h], twins);
                if !image.vertices.is_empty() {
                    handles.push(image);
                    let mut follows = all[h].clone();
                    follows.across.push(*plane);
                    all.push(follows);
                }
            }
            Some(g) if g == h => {
                handles[h] = joined(&handles[h], &across(&handles[h], twins));
                all[h].about.push(*plane);
            }
            Some(g) if h < g => {
                let height = |h: usize| -> f64 {
                    let handle = &handles[h];
                    let sum: f64 =
                        handle.vertices.iter().map(|&v| plane.height(mesh.vertices()[v as usize])).sum();
                    sum / handle.vertices.len() as f64
                };
                // Mirror images of one pair must choose alike, also where rounding alone tells.
                let tie = -SAME_HEIGHT * mesh.frame().scale;
                let (leads, follows) = if height(h) - height(g) >= tie { (h, g) } else { (g, h) };
                handles[leads] = joined(&handles[leads], &across(&handles[follows], twins));
                handles[follows] = joined(&across(&handles[leads], twins), &handles[follows]);
                all[follows] = all[leads].clone();
                all[follows].across.push(*plane);
            }
            Some(_) => {}
        }
    }
    Ok(())
}

/// The mirror image of a handle.
fn across(handle: &Handle, twins: &[Option<u32>]) -> Handle {
    let own = handle.vertices.iter().enumerate();
    let (places, vertices): (Vec<usize>, Vec<u32>) =
        own.filter_map(|(i, &v)| Some((i, twins[v as usize]?))).unzip();
    let membership = handle.membership.as_ref();
    Handle { vertices, membership: membership.map(|m| places.iter().map(|&i| m[i]).collect()) }
}

/// A handle and those vertices of another that it does not have.
fn joined(own: &Handle, other: &Handle) -> Handle {
    let known: BTreeSet<u32> = own.vertices.iter().copied().collect();
    let more: Vec<usize> =
        (0..other.vertices.len()).filter(|&i| !known.contains(&other.vertices[i])).collect();
    let weight = |handle: &Handle, i: usize| handle.membership.as_ref().map_or(1.0, |m| m[i]);
    let weights = (0..own.vertices.len()).map(|i| weight(own, i));
    let weights: Vec<f64> = weights.chain(more.iter().map(|&i| weight(other, i))).collect();
    let vertices = own.vertices.iter().copied().chain(more.iter().map(|&i| other.vertices[i])).collect();
    let partly = own.membership.is_some() || other.membership.is_some();
    Handle { vertices, membership: partly.then_some(weights) }
}
