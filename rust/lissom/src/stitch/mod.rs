//! Stitch: from target matrices to positions. What every chooser shares.
//!
//! ```text
//!     min_x  sum_t sum_{e in t}  w_te | e(x) - C_te s_te |^2      x given at fixed vertices
//! ```
//!
//! Choosers differ in who owns the matrices ([`Owners`]) and in the edges `s` that these act on ([`Reference`]):
//! those of the rest pose, or others. With `w_te` half the cotangent opposite the edge and a matrix per triangle
//! this *is* `sum_t area_t |grad_t x - C_t (I - n n^T)|^2` (Botsch, Sumner, Pauly & Gross 2006, Deformation Transfer
//! for Detail-Preserving Surface Editing): the fourth vertices of Sumner & Popović (2004) drop out exactly.
//!
//! *Global step.* The unknown is the displacement `d` from a base, in most cases the rest pose. The normal equations
//! are `L d = div (C - I)`, so where nothing is asked for, nothing moves, to the last bit. All matrices here are
//! such *changes* `C - I`.
//!
//! *Local step.* For given positions the energy is `const - 2 sum C : cov(x)`, where the covariances are the adjoint
//! of the divergence, `<div C, x> = sum C : cov(x)`. The best rotations are those nearest to them.
//!
//! [`Stitcher::refine`] alternates the two.

mod fans;
mod lbfgs;
mod refine;
mod triangles;

use std::sync::{Arc, OnceLock};

use fans::Fans;
pub use refine::{Chooser, Fit, Refined, Stop};

use crate::linear::{ConstrainedSystem, Constraints, SymmetricMatrix};
use crate::operators::hats_of;
use crate::{Job, Mat3, Mesh, Result, Vec3};

/// Of each corner of a triangle, `sum w_te s_te` over the two edges that meet there: `area_t grad phi` where `s` are
/// the edges of the triangle itself.
pub type Hats = [Vec3; 3];

/// Who owns the target matrices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owners {
    /// Each triangle one, for its three edges.
    Triangles,
    /// Each vertex one; an edge takes the mean of its two ends'. With rotations these are the *spokes* of Sorkine &
    /// Alexa (2007).
    Edges,
    /// Each vertex one; the edges of a triangle take the mean of its three corners': *spokes and rims* (Chao,
    /// Pinkall, Sanan & Schröder 2010).
    Corners,
}

impl Owners {
    /// How many matrices the target of an edge is the mean of: in so many cells it is.
    pub fn per_edge(self) -> f64 {
        match self {
            Self::Triangles => 1.0,
            Self::Edges => 2.0,
            Self::Corners => 3.0,
        }
    }
}

/// How much each edge counts.
#[derive(Debug, Clone, Copy)]
pub enum Weights<'a> {
    /// `w_te`, half the cotangent opposite.
    Cotangent,
    /// The same times a factor per triangle.
    Scaled(&'a [f64]),
    /// `w_te` per triangle, opposite to each corner.
    Corners(&'a [[f64; 3]]),
    /// One weight per edge, whatever the triangles beside it: for [`Owners::Edges`].
    Edges(&'a [f64]),
}

/// The edges that target matrices act on, and what displacements count from.
#[derive(Clone, Copy)]
pub enum Reference<'a> {
    /// Both are the rest pose.
    Rest,
    /// Edges of each triangle's own, for [`Owners::Triangles`].
    Edges {
        /// Of each triangle, the hats of its reference edges, and those less the hats of the base.
        hats: &'a (dyn Fn(usize) -> [Hats; 2] + Sync),
        /// What displacements count from, in unit coordinates.
        base: &'a [Vec3],
    },
}

/// What a local step found.
#[derive(Debug)]
pub struct Local {
    /// `C - I` of every owner.
    pub changes: Vec<Mat3>,
    /// The energy at its best targets, up to what does not depend on the positions where the reference is not the
    /// rest pose.
    pub energy: f64,
    /// The weighted size of all edges, which rounding of the energy is relative to.
    pub size: f64,
}

/// The factored stitching system of one mesh and one set of constraints.
#[derive(Debug)]
pub struct Stitcher {
    mesh: Arc<Mesh>,
    owners: Owners,
    matrix: SymmetricMatrix,
    system: ConstrainedSystem,
    elements: Elements,
    floating: Vec<Vec<u32>>,
}

/// The edges at rest, in the layout that suits their owners.
#[derive(Debug)]
enum Elements {
    Triangles {
        /// `w_te` opposite to each corner.
        weights: Vec<[f64; 3]>,
        /// Made when the rest pose is first the reference.
        hats: OnceLock<Vec<Hats>>,
    },
    Fans(Fans),
}

impl Stitcher {
    /// Prepares to stitch `mesh` under `constraints`; `extra` quadratic terms `x^T A x` join the energy.
    ///
    /// Connected components without a fixed or soft vertex float: one vertex of each is pinned, and
    /// [`Stitcher::floating`] lists them, for the caller to put where they belong. Vertices in no triangle are fixed.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`], [`crate::Error::OutOfMemory`] and [`crate::Error::Cancelled`].
    pub fn new(
        mesh: Arc<Mesh>,
        owners: Owners,
        weights: Weights,
        extra: Option<&SymmetricMatrix>,
        constraints: Constraints,
        job: &Job,
    ) -> Result<Self> {
        let (constraints, floating) = pin_floating(&mesh, constraints);
        let corner_weights = corner_weights(&mesh, weights);
        let elements = match (owners, weights) {
            (Owners::Edges, Weights::Edges(weights)) => Elements::Fans(Fans::of_edges(&mesh, weights)),
            (Owners::Edges, _) => {
                Elements::Fans(Fans::of_edges(&mesh, &edge_weights(&mesh, &corner_weights)))
            }
            (Owners::Corners, _) => Elements::Fans(Fans::of_corners(&mesh, &corner_weights)),
            (Owners::Triangles, _) => Elements::Triangles { weights: corner_weights, hats: OnceLock::new() },
        };
        let laplacian = match &elements {
            Elements::Triangles { weights, .. } => triangles::laplacian(&mesh, weights),
            Elements::Fans(fans) => SymmetricMatrix::laplacian(mesh.rest().len(), fans.edges()),
        };
        let matrix = match extra {
            Some(extra) => laplacian.combine(1.0, extra, 1.0),
            None => laplacian,
        };
        let system = ConstrainedSystem::new(&matrix, constraints, job)?;
        Ok(Self { mesh, owners, matrix, system, elements, floating })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// Who owns the targets.
    pub fn owners(&self) -> Owners {
        self.owners
    }

    /// `L` and the extra terms, without constraints.
    pub fn matrix(&self) -> &SymmetricMatrix {
        &self.matrix
    }

    /// The system behind it.
    pub fn system(&self) -> &ConstrainedSystem {
        &self.system
    }

    /// The vertices of each component that nothing but a pin holds.
    pub fn floating(&self) -> &[Vec<u32>] {
        &self.floating
    }

    /// Global step: the displacements that match the targets best. On entry those of fixed and soft vertices are
    /// what is asked of them.
    pub fn stitch(&self, reference: Reference, changes: &[Mat3], displacements: &mut Vec<Vec3>) {
        let rhs = [self.divergence(reference, changes)];
        let mut solved = [std::mem::take(displacements)];
        self.system.solve(&rhs, &mut solved);
        [*displacements] = solved;
    }

    /// `div (C - I)`: what the targets ask of each vertex, the right-hand side of the global step.
    pub fn divergence(&self, reference: Reference, changes: &[Mat3]) -> Vec<Vec3> {
        match (&self.elements, reference) {
            (Elements::Triangles { .. }, Reference::Rest) => {
                triangles::divergence_at_rest(&self.mesh, self.hats(), changes)
            }
            (Elements::Triangles { .. }, Reference::Edges { hats, .. }) => {
                triangles::gather(&self.mesh, |t, _| {
                    let [reference, beyond] = hats(t);
                    [0, 1, 2].map(|c| changes[t] * reference[c] + beyond[c])
                })
            }
            (Elements::Fans(fans), _) => fans.divergence(changes, self.owners.per_edge()),
        }
    }

    /// `cov(x)` of every owner, the adjoint of the divergence.
    pub fn covariances(&self, reference: Reference, x: &[Vec3]) -> Vec<Mat3> {
        match &self.elements {
            Elements::Triangles { .. } => {
                triangles::covariances(&self.mesh, self.reference_hats(reference), x)
            }
            Elements::Fans(fans) => fans.covariances(x, self.owners.per_edge()),
        }
    }

    /// Local step: `pick(owner, covariance)` chooses the target of every owner, a rotation as near to its covariance as
    /// it may be.
    pub fn local_step(
        &self,
        reference: Reference,
        displacements: &[Vec3],
        pick: impl Fn(usize, Mat3) -> Mat3 + Sync,
    ) -> Local {
        let base = match reference {
            Reference::Rest => self.mesh.rest(),
            Reference::Edges { base, .. } => base,
        };
        let x = refine::moved(base, displacements, 1.0);
        match &self.elements {
            Elements::Triangles { weights, .. } => {
                triangles::local_step(&self.mesh, weights, self.reference_hats(reference), &x, pick)
            }
            Elements::Fans(fans) => fans.local_step(&x, self.owners.per_edge(), pick),
        }
    }

    /// Half the gradient of the energy by the displacements, for fixed targets and without the extra terms; zero at
    /// fixed vertices. `given` holds the displacements that soft vertices are pulled to.
    pub fn gradient(
        &self,
        reference: Reference,
        changes: &[Mat3],
        displacements: &[Vec3],
        given: &[Vec3],
    ) -> Vec<Vec3> {
        let constraints = self.system.constraints();
        let mut gradient = match &self.elements {
            Elements::Fans(fans) => {
                fans.gradient(changes, displacements, constraints, self.owners.per_edge())
            }
            Elements::Triangles { weights, .. } => {
                let mut gradient = triangles::gather(&self.mesh, |t, corners| {
                    let [reference, beyond] = match reference {
                        Reference::Rest => [self.hats()[t], [Vec3::ZERO; 3]],
                        Reference::Edges { hats, .. } => hats(t),
                    };
                    let own = hats_of(corners.map(|v| displacements[v as usize]), weights[t]);
                    [0, 1, 2].map(|c| own[c] - changes[t] * reference[c] - beyond[c])
                });
                for (v, gradient) in (0u32..).zip(&mut gradient) {
                    if constraints.slot(v).is_none() {
                        *gradient = Vec3::ZERO;
                    }
                }
                gradient
            }
        };
        for &(v, weight) in constraints.soft().iter().filter(|(v, _)| constraints.slot(*v).is_some()) {
            let v = v as usize;
            gradient[v] += (displacements[v] - given[v]) * weight;
        }
        gradient
    }

    /// The neighbours of a vertex that owns a target, with the weights of the edges to them.
    pub fn neighbours(&self, vertex: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let spokes = match &self.elements {
            Elements::Fans(fans) => fans.at(vertex),
            Elements::Triangles { .. } => &[],
        };
        spokes.iter().map(|spoke| (spoke.neighbour as usize, spoke.weight))
    }

    /// `K^-1` of a gradient, where `K` is the matrix of the global step.
    pub fn lift(&self, gradient: &[Vec3]) -> Vec<Vec3> {
        let mut lifted = [vec![Vec3::ZERO; gradient.len()]];
        self.system.solve(&[gradient], &mut lifted);
        let [lifted] = lifted;
        lifted
    }

    /// The hats at rest, of triangles.
    fn hats(&self) -> &[Hats] {
        let Elements::Triangles { weights, hats } = &self.elements else { return &[] };
        hats.get_or_init(|| triangles::hats(&self.mesh, weights, self.mesh.rest()))
    }

    fn reference_hats<'a>(&'a self, reference: Reference<'a>) -> impl Fn(usize) -> Hats + Sync + 'a {
        let at_rest = match reference {
            Reference::Rest => self.hats(),
            Reference::Edges { .. } => &[],
        };
        move |t| match reference {
            Reference::Rest => at_rest[t],
            Reference::Edges { hats, .. } => hats(t)[0],
        }
    }
}

/// `w_te` of every triangle; one weight per edge leaves them as they are.
fn corner_weights(mesh: &Mesh, weights: Weights) -> Vec<[f64; 3]> {
    match weights {
        Weights::Cotangent | Weights::Edges(_) => mesh.half_cotangents().to_vec(),
        Weights::Scaled(factors) => {
            mesh.half_cotangents().iter().zip(factors).map(|(w, factor)| w.map(|w| w * factor)).collect()
        }
        Weights::Corners(weights) => weights.to_vec(),
    }
}

/// The weight of every edge: the sum of its triangles'.
pub fn edge_weights(mesh: &Mesh, corner_weights: &[[f64; 3]]) -> Vec<f64> {
    let opposite = |edge: &[u32; 2], t: usize| {
        let apex = mesh.triangles()[t].iter().position(|v| !edge.contains(v));
        apex.map_or(0.0, |corner| corner_weights[t][corner])
    };
    let sum = |(e, edge): (usize, &[u32; 2])| {
        mesh.adjacency().sides_of(e).iter().map(|side| opposite(edge, side.triangle as usize)).sum()
    };
    mesh.adjacency().edges().iter().enumerate().map(sum).collect()
}

/// The constraints with a pin in every component that has none, and those components.
fn pin_floating(mesh: &Mesh, constraints: Constraints) -> (Constraints, Vec<Vec<u32>>) {
    let components = mesh.components();
    let mut held = vec![false; components.count()];
    let fixed = (0..mesh.rest().len() as u32).filter(|&v| constraints.slot(v).is_none());
    for v in fixed.chain(constraints.soft().iter().map(|&(v, _)| v)) {
        if let Some(c) = components.of_vertex(v as usize) {
            held[c] = true;
        }
    }
    let mut floating = components.members();
    let mut component = 0..;
    floating.retain(|_| component.next().is_some_and(|c: usize| !held[c]));
    let mut pinned: Vec<bool> = (0..mesh.rest().len()).map(|v| components.of_vertex(v).is_none()).collect();
    floating.iter().for_each(|members| pinned[members[0] as usize] = true);
    (constraints.also_fixed(|v| pinned[v]), floating)
}
