//! Which side of a surface is out.

use super::adjacency::Adjacency;
use crate::Vec3;
use crate::geometry::rows::Rows;

/// The triangles turned so that, as far as that is possible, neighbours are wound alike and each part that hangs
/// together by edges encloses its volume from outside.
pub(super) fn outward(triangles: &[[u32; 3]], adjacency: &Adjacency, rest: &[Vec3]) -> Vec<[u32; 3]> {
    let volume = |t: usize, root: usize| {
        let origin = rest[triangles[root][0] as usize];
        signed_volume(triangles[t].map(|v| rest[v as usize] - origin))
    };
    turn(triangles, &against(triangles, adjacency, volume))
}

/// The triangles that are wound against their neighbours, where most of the area of the part that hangs together by edges
/// is wound alike.
pub(super) fn against_most(triangles: &[[u32; 3]], adjacency: &Adjacency, areas: &[f64]) -> Vec<bool> {
    against(triangles, adjacency, |t, _| areas[t])
}

/// These triangles with some wound the other way.
pub(super) fn turn(triangles: &[[u32; 3]], over: &[bool]) -> Vec<[u32; 3]> {
    let wound = |(&[a, b, c], &over): (&[u32; 3], &bool)| if over { [a, c, b] } else { [a, b, c] };
    triangles.iter().zip(over).map(wound).collect()
}

/// The triangles to turn so that neighbours are wound alike and the `measure` of each part, the sum of those of its
/// triangles by their winding, is not negative. It is given a triangle and the first one of its part.
fn against(
    triangles: &[[u32; 3]],
    adjacency: &Adjacency,
    measure: impl Fn(usize, usize) -> f64,
) -> Vec<bool> {
    let joined = (0..adjacency.edges().len()).filter_map(|e| match adjacency.sides_of(e) {
        // Wound alike, the two pass their edge in opposite directions.
        [a, b] => Some((a.triangle, b.triangle, a.ascending == b.ascending)),
        _ => None,
    });
    let both = joined.flat_map(|(a, b, against)| [(a, (b, against)), (b, (a, against))]);
    let beside = Rows::sort(triangles.len(), both);
    let mut turned: Vec<Option<bool>> = vec![None; triangles.len()];
    for root in 0..triangles.len() {
        if turned[root].is_some() {
            continue;
        }
        turned[root] = Some(false);
        let (mut part, mut next, mut sum) = (vec![root], 0, 0.0);
        while let Some(&t) = part.get(next) {
            next += 1;
            let own = turned[t].unwrap_or_default();
            sum += measure(t, root) * if own { -1.0 } else { 1.0 };
            for &(other, against) in beside.of(t) {
                let other = other as usize;
                if turned[other].is_none() {
                    turned[other] = Some(own != against);
                    part.push(other);
                }
            }
        }
        if sum < 0.0 {
            part.iter().for_each(|&t| turned[t] = turned[t].map(|own| !own));
        }
    }
    turned.into_iter().map(Option::unwrap_or_default).collect()
}

/// Six times the volume between a triangle and the origin.
fn signed_volume([a, b, c]: [Vec3; 3]) -> f64 {
    a.dot(b.cross(c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mesh;

    #[test]
    fn any_winding_of_a_closed_surface_is_turned_outwards() {
        let corners: Vec<Vec3> =
            (0..4).map(|k| [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z][k] + Vec3::splat(7.0)).collect();
        let outward = [[0u32, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        for pattern in 0..16 {
            let turn =
                |(k, [a, b, c]): (usize, [u32; 3])| if pattern >> k & 1 == 1 { [a, c, b] } else { [a, b, c] };
            let given = outward.into_iter().enumerate().map(turn).collect();
            let mesh = Mesh::new(corners.clone(), given).unwrap();
            for ([a, b, c], [x, y, z]) in mesh.outward_triangles().into_iter().zip(outward) {
                assert!([[x, y, z], [y, z, x], [z, x, y]].contains(&[a, b, c]), "{pattern}");
            }
        }
    }

    #[test]
    fn what_is_wound_against_most_of_the_area_is_found() {
        // A strip of squares, each of two triangles.
        let corners = (0..12).map(|k| Vec3::new(f64::from(k / 2), f64::from(k % 2), 0.0)).collect::<Vec<_>>();
        let squares = (0..5).flat_map(|k| [[2 * k, 2 * k + 2, 2 * k + 1], [2 * k + 1, 2 * k + 2, 2 * k + 3]]);
        let triangles: Vec<[u32; 3]> = squares.collect();
        for pattern in 0..1 << triangles.len() {
            let over: Vec<bool> = (0..triangles.len()).map(|k| pattern >> k & 1 == 1).collect();
            let few = over.iter().filter(|&&over| over).count();
            if 2 * few == triangles.len() {
                continue;
            }
            let mesh = Mesh::new(corners.clone(), turn(&triangles, &over)).unwrap();
            let found = against_most(mesh.triangles(), mesh.adjacency(), mesh.areas());
            let fewer = 2 * few < triangles.len();
            assert!(found.iter().zip(&over).all(|(&found, &over)| found == (over == fewer)), "{over:?}");
        }
    }
}
