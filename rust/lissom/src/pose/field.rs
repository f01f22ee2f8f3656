//! Smooth fields: values given at handles, extended over the free vertices.
//!
//! Order 0 is a membrane, `L f = 0` (Zayer, Rössl, Karni & Seidel 2005, Harmonic Guidance for Surface
//! Deformation); it has a crease where free and given vertices meet. Order 1, `L M^-1 L f = 0`, is a thin
//! plate and joins with continuous slope, order 2, `L M^-1 L M^-1 L f = 0`, with continuous curvature
//! (Botsch & Kobbelt 2004, An Intuitive Framework for Real-Time Freeform Modeling).

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::goal::Goal;
use super::region::Region;
use crate::linear::{ConstrainedSystem, SplitMatrix, SymmetricMatrix, long_rows};
use crate::operators::cotangent::cotangent_laplacian;
use crate::operators::mass::lumped_mass;
use crate::rotation::exp;
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3, memory};

/// The factored system of a field of `order` 0, 1 or 2 on a region.
pub(super) fn smooth_system(region: &Region, order: usize, job: &Job) -> Result<ConstrainedSystem> {
    ConstrainedSystem::of_split(&polyharmonic(region.mesh(), order)?, region.constraints().clone(), job)
}

/// Fields of several vectors per handle; one that is zero at all of them costs nothing.
pub(super) fn of_handles<const N: usize>(
    system: &ConstrainedSystem,
    region: &Region,
    handles: &[[Vec3; N]],
) -> [Vec<Vec3>; N] {
    let n = region.mesh().rest().len();
    let moving = |part: &usize| handles.iter().any(|h| h[*part] != Vec3::ZERO);
    let parts: Vec<usize> = (0..N).filter(moving).collect();
    let mut fields: Vec<Vec<Vec3>> =
        parts.iter().map(|&part| region.at_handles(|h| handles[h][part])).collect();
    system.extend(&mut fields);
    let mut fields = parts.iter().zip(fields).peekable();
    std::array::from_fn(|part| match fields.next_if(|field| *field.0 == part) {
        Some((_, field)) => field,
        None => vec![Vec3::ZERO; n],
    })
}

/// The handles' rotations, extended as rotation vectors.
pub(super) fn rotations(system: &ConstrainedSystem, region: &Region, goal: &Goal) -> Vec<Mat3> {
    let vectors: Vec<[Vec3; 2]> = goal.handles.iter().map(|m| [m.rotation, m.whole_turns]).collect();
    let [rotation, whole] = of_handles(system, region, &vectors);
    rotation.into_par_iter().zip(whole).map(|(r, w)| exp(r) * exp(w)).collect()
}

/// `L`, `L M^-1 L` or `L M^-1 L M^-1 L`, the Hessians of `sum w (f_j - f_i)^2`, `sum m h^2` and
/// `sum w (h_j - h_i)^2` with `h = M^-1 L f`.
pub(super) fn polyharmonic(mesh: &Mesh, order: usize) -> Result<SplitMatrix> {
    let laplacian = cotangent_laplacian(mesh);
    let inverse = inverse_mass(mesh);
    match order {
        0 => Ok(laplacian.into()),
        1 => SplitMatrix::sandwich(&laplacian, &inverse),
        2 => triharmonic(&laplacian, &inverse),
        _ => Err(Error::InvalidValue(Fault::new("border", format!("must be 0, 1 or 2, got {order}")))),
    }
}

/// `B^T L B` with `B = M^-1 L`. Long rows `b_c` of `B` are left out of it, `B = B' + sum e_c b_c^T`, and kept apart:
///
/// ```text
///     B^T L B = B'^T L B' + sum_c (b_c q_c^T + q_c b_c^T),      q_c = B'^T L_c + sum_d L_cd b_d / 2
/// ```
fn triharmonic(laplacian: &SymmetricMatrix, inverse: &[f64]) -> Result<SplitMatrix> {
    let n = laplacian.size();
    let rows = laplacian.rows();
    let long = long_rows(&rows.iter().map(<[_]>::len).collect::<Vec<_>>());
    let short = |i: usize| if long[i] { &[][..] } else { rows.of(i) };
    let values: u128 = (0..n).map(|i| (short(i).len() * rows.of(i).len()) as u128).sum();
    memory::check("the differences of the Laplacian", size_of::<(u32, f64)>() as u128 * values)?;
    let sum = |parts: &mut dyn Iterator<Item = (f64, &[(u32, f64)])>| -> Vec<(u32, f64)> {
        let mut sum: BTreeMap<u32, f64> = BTreeMap::new();
        for (factor, row) in parts {
            row.iter().for_each(|&(column, entry)| *sum.entry(column).or_default() += factor * entry);
        }
        sum.into_iter().collect()
    };
    let difference = |i: u32, j: u32| {
        let part = |i: usize, sign: f64| (sign * inverse[i], short(i));
        sum(&mut [part(i as usize, 1.0), part(j as usize, -1.0)].into_iter())
    };
    let edges = laplacian.entries().filter(|(i, j, _)| i != j);
    let mut differences: Vec<(f64, Vec<(u32, f64)>)> =
        edges.map(|(i, j, value)| (-value, difference(i, j))).collect();
    let apart: Vec<usize> = (0..n).filter(|&c| long[c]).collect();
    differences.extend(apart.iter().map(|&c| (0.0, vec![(c as u32, 1.0)])));
    let sparse =
        SymmetricMatrix::normal(n, differences.iter().map(|(weight, row)| (*weight, row.as_slice())))?;
    let norm = |row: &[(u32, f64)]| row.iter().map(|(_, x)| x * x).sum::<f64>().sqrt();
    let products = apart.iter().flat_map(|&c| {
        let own = rows.of(c);
        let q = sum(&mut own.iter().map(|&(j, entry)| {
            let share = if long[j as usize] { 0.5 } else { 1.0 };
            (share * entry * inverse[j as usize], rows.of(j as usize))
        }));
        // As squares of sum and difference, when both are of one size.
        let b = inverse[c] * (norm(&q) / (inverse[c] * norm(own)).max(f64::MIN_POSITIVE)).sqrt();
        let q_by = if b > 0.0 { inverse[c] / b } else { 0.0 };
        [1.0, -1.0].map(|sign| (0.5 * sign, sum(&mut [(b, own), (sign * q_by, &q[..])].into_iter())))
    });
    Ok(SplitMatrix::new(sparse, products.collect()))
}

/// Smallest area of a cell, that of one 1e-12 of the diagonal across: the square of its inverse is in range.
const LEAST_AREA: f64 = 1e-24;

/// One over the lumped areas, in squares of the mesh's diagonal: energies of second differences, and the lengths that
/// options weigh them by, are then the same however the mesh lies. Cells without area get a millionth of the mean.
pub(super) fn inverse_mass(mesh: &Mesh) -> Vec<f64> {
    let mass = lumped_mass(mesh);
    let least = (1e-6 * mass.iter().sum::<f64>() / mass.len() as f64).max(LEAST_AREA);
    let square = mesh.diagonal() * mesh.diagonal();
    mass.iter().map(|m| square / m.max(least)).collect()
}
