//! What a chooser says: whose the matrices are, what edges they act on, and how much each edge counts.

use crate::{Mat3, Mesh, Vec3};

/// Of each corner of a triangle, `sum w_te s_te` over the two edges that meet there: `area_t grad phi` where `s` are
/// the edges of the triangle itself.
pub type HatGradients = [Vec3; 3];

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
        hats: &'a (dyn Fn(usize) -> [HatGradients; 2] + Sync),
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

/// `w_te` of every triangle; one weight per edge leaves them as they are.
pub(super) fn corner_weights(mesh: &Mesh, weights: Weights) -> Vec<[f64; 3]> {
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
