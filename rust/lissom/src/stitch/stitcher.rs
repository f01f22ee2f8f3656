//! The system behind the stitch: one Laplacian with its constraints, whoever owns the targets.

use std::sync::{Arc, OnceLock};

use super::fans::Fans;
use super::targets::{HatGradients, Local, Owners, Reference, Weights, corner_weights, edge_weights};
use super::triangles;
use super::turns::{AtRest, Turning};
use super::vectors::moved;
use crate::linear::{ConstrainedSystem, Constraints, SymmetricMatrix};
use crate::operators::cotangent::corner_laplacian;
use crate::operators::divergence::divergence;
use crate::operators::{corner_hat_gradients, hat_gradients_at};
use crate::{Job, Mat3, Mesh, Quat, Result, Vec3};

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
        hats: OnceLock<Vec<HatGradients>>,
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
            Elements::Triangles { weights, .. } => corner_laplacian(&mesh, weights),
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
                divergence(self.mesh.triangles(), self.hats(), changes, self.mesh.rest().len())
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
        let x = moved(base, displacements, 1.0);
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
                    let own = corner_hat_gradients(corners.map(|v| displacements[v as usize]), weights[t]);
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

    /// `div (R - I)` of rotations that vertices own.
    pub fn turn_divergence(&self, rotations: &[Quat]) -> Vec<Vec3> {
        match &self.elements {
            Elements::Fans(fans) => fans.turn_divergence(rotations, self.owners.per_edge()),
            Elements::Triangles { .. } => Vec::new(),
        }
    }

    /// The energy of rotations that vertices own, and of displacements, with its torques. `more` adds to the covariance
    /// of a vertex and to the size of its displacements.
    pub fn turning(
        &self,
        at_rest: AtRest<'_, impl Fn(Mat3) -> Mat3 + Sync + Send>,
        rotations: &[Quat],
        displacements: &[Vec3],
        more: impl Fn(usize) -> (Mat3, f64) + Sync + Send,
    ) -> Turning {
        match &self.elements {
            Elements::Fans(fans) => {
                fans.turning(at_rest, rotations, displacements, self.owners.per_edge(), more)
            }
            Elements::Triangles { .. } => Turning::default(),
        }
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
    pub fn precondition(&self, gradient: &[Vec3]) -> Vec<Vec3> {
        let mut preconditioned = [vec![Vec3::ZERO; gradient.len()]];
        self.system.solve(&[gradient], &mut preconditioned);
        let [preconditioned] = preconditioned;
        preconditioned
    }

    /// The hats at rest, of triangles.
    fn hats(&self) -> &[HatGradients] {
        let Elements::Triangles { weights, hats } = &self.elements else { return &[] };
        hats.get_or_init(|| hat_gradients_at(&self.mesh, weights, self.mesh.rest()))
    }

    fn reference_hats<'a>(&'a self, reference: Reference<'a>) -> impl Fn(usize) -> HatGradients + Sync + 'a {
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
