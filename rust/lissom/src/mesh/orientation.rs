//! Which side of a surface is out.

use super::adjacency::Adjacency;
use crate::Vec3;
use crate::geometry::rows::Rows;

/// The triangles turned so that, as far as that is possible, neighbours are wound alike and each part that hangs
/// together by edges encloses its volume from outside.
pub(super) fn outward(triangles: &[[u32; 3]], adjacency: &Adjacency, rest: &[Vec3]) -> Vec<[u32; 3]> {
    let joined = (0..adjacency.edges().len()).filter_map(|e| match adjacency.sides_of(e) {
        // Wound alike, the two pass their edge in opposite directions.
        [a, b] => Some((a.triangle, b.triangle, a.ascending == b.ascending)),
        _ => None,
    });
    let both = joined.flat_map(|(a, b, against)| [(a, (b, against)), (b, (a, against))]);
    let beside = Rows::sort(triangles.len(), both);
    let mut triangles = triangles.to_vec();
    let mut turned: Vec<Option<bool>> = vec![None; triangles.len()];
    for root in 0..triangles.len() as u32 {
        if turned[root as usize].is_some() {
            continue;
        }
        turned[root as usize] = Some(false);
        let (mut part, mut next, mut volume) = (vec![root], 0, 0.0);
        let origin = rest[triangles[root as usize][0] as usize];
        while let Some(&t) = part.get(next) {
            next += 1;
            let own = turned[t as usize].unwrap_or_default();
            let [a, b, c] = triangles[t as usize].map(|v| rest[v as usize] - origin);
            volume += signed_volume([a, b, c]) * if own { -1.0 } else { 1.0 };
            for &(other, against) in beside.of(t as usize) {
                if turned[other as usize].is_none() {
                    turned[other as usize] = Some(own != against);
                    part.push(other);
                }
            }
        }
        for t in part {
            let [a, b, c] = triangles[t as usize];
            if turned[t as usize].unwrap_or_default() != (volume < 0.0) {
                triangles[t as usize] = [a, c, b];
            }
        }
    }
    triangles
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
}
