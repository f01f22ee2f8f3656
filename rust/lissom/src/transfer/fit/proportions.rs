//! Proportions: whether markers that a fit let go of are off, or the shapes differ by so much.
//!
//! Two fits tell, one that let go and one that followed. Where the shapes differ, as a cartoon's and a person's do, markers
//! lead what stands out of the source to what stands out of the target, and their way from one to the next is smooth: the
//! target is met better, and the source hardly bends more. Where markers are off, it bends from each to the next, and
//! meets what is beside.

use super::lie::Lie;
use super::side::{Placed, Side};
use crate::operators::gradient::deformation_gradients;
use crate::{Job, Mesh, Result, Vec3};

/// Markers that are followed may make the source bend by this factor more: those of cartoons make it up to 1.2 times as
/// much, 1.45 times when clicked half a percent of the diagonal off; those of people 2 % off from 1.5 times on.
const BENT: f64 = 1.3;

/// And the target is to be off by no more than this part: those of cartoons leave 0.2-0.85 of it, those of people from 0.9 on,
/// exact or not.
const NEARER: f64 = 0.88;

/// So many vertices of the target tell how it is met.
const ASKED: usize = 20_000;

/// Whether a fit that follows markers is better than one that let go of them. What is `far` from both has no
/// counterpart.
///
/// # Errors
///
/// [`crate::Error::Cancelled`].
pub fn differ(
    [free, led]: [&[Vec3]; 2],
    source: &Side,
    target: &Placed,
    lie: &Lie,
    far: f64,
    job: &Job,
) -> Result<bool> {
    let bent = |x| bending(source.mesh, x, lie.size, source.mesh.adjacency().triangle_pairs());
    if bent(led) > BENT * bent(free) {
        return Ok(false);
    }
    let [free, led] = [free, led].map(|x| distances(target, &Placed::new(source, x), far, job));
    let both: Vec<(f64, f64)> = free?.into_iter().zip(led?).filter(|&(a, b)| a.min(b) < far).collect();
    let unmet = |of: fn(&(f64, f64)) -> f64| root_mean_square(both.iter().map(|pair| of(pair).powi(2)));
    Ok(unmet(|pair| pair.1) < NEARER * unmet(|pair| pair.0))
}

/// How unlike neighbouring triangles of `source` change to `x`, where all grow to `size`, at the root mean square.
pub fn bending(source: &Mesh, x: &[Vec3], size: f64, pairs: impl Iterator<Item = [u32; 2]>) -> f64 {
    let in_its_size: Vec<Vec3> = x.iter().map(|&x| x / size).collect();
    let changes = deformation_gradients(source, &in_its_size);
    root_mean_square(pairs.map(|[a, b]| {
        let difference = changes[a as usize] - changes[b as usize];
        difference.to_cols_array().iter().map(|d| d * d).sum()
    }))
}

/// How far vertices of the target are from the source, `far` at most.
fn distances(target: &Placed, source: &Placed, far: f64, job: &Job) -> Result<Vec<f64>> {
    let open =
        |&v: &usize| !target.side.masked_vertex[v] && target.side.mesh.components().of_vertex(v).is_some();
    let every = target.positions.len().div_ceil(ASKED).max(1);
    let asked: Vec<usize> = (0..target.positions.len()).step_by(every).filter(open).collect();
    job.in_batches(asked.len(), |i| {
        let (point, normal) = (target.positions[asked[i]], target.normals[asked[i]].normalize_or_zero());
        source.closest(point, normal, far, None, 0.0).map_or(far, |hit| hit.distance)
    })
}

/// Of what these are the squares of; 0 of nothing.
pub fn root_mean_square(squares: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = squares.fold((0.0, 0), |(sum, count), square| (sum + square, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}
