//! Linings: what of a surface lies in a pocket, as mouth bags and eye sockets do, parted from what one sees of it by the
//! shortest loops of edges.
//!
//! ```text
//! min  sum of |e| (1/2 + exp(-(x_s - x_t)^2 / 0.15^2))   over the edges e between triangles s that line and t that do not
//! where what is seen from nowhere lines, and what is seen from much of the space in front of it does not
//! ```
//!
//! with the exposures `x` of triangles. A rim is where these jump: such edges cost a third (Boykov & Jolly 2001,
//! Interactive Graph Cuts).

use super::adjacency::Adjacency;
use crate::geometry::cut::Cut;
use crate::geometry::exposure::exposures;
use crate::{Job, Result, Vec3};

/// Exposures: up to the first a triangle is in a pocket, from the second on it is not.
const HIDDEN: f64 = 0.05;
const SEEN: f64 = 0.7;

/// By how much they differ at a rim, and what an edge costs there.
const JUMP: f64 = 0.15;
const LEAST: f64 = 0.5;

/// Of each of the triangles, which face outward, whether it lines a pocket: one sees it from nowhere, or it is behind the
/// shortest loop of edges that parts such from what one sees. None does where nothing is hidden.
pub(super) fn linings(
    rest: &[Vec3],
    outward: &[[u32; 3]],
    adjacency: &Adjacency,
    job: &Job,
) -> Result<Vec<bool>> {
    let [pocket, space] = [0, 1].map(|k| (outward.len() + k) as u32);
    let mut cut = Cut::new(outward.len() + 2);
    job.report(0.0, "pockets");
    let exposures = exposures(rest, outward, job)?;
    job.report(0.7, "pockets");
    for (t, &exposure) in (0..).zip(&exposures) {
        if exposure <= HIDDEN {
            cut.join(pocket, t, f64::INFINITY);
        } else if exposure >= SEEN {
            cut.join(t, space, f64::INFINITY);
        }
    }
    for (e, &[a, b]) in adjacency.edges().iter().enumerate() {
        let length = rest[a as usize].distance(rest[b as usize]);
        for pair in adjacency.sides_of(e).windows(2) {
            let [s, t] = [pair[0].triangle, pair[1].triangle];
            let jump = (exposures[s as usize] - exposures[t as usize]) / JUMP;
            cut.join(s, t, length * (LEAST + (-jump * jump).exp()));
        }
    }
    let mut lines = cut.side(pocket, space, job)?;
    lines.truncate(outward.len());
    job.report(1.0, "pockets");
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use crate::{Job, Mesh, Vec3};
    use std::f64::consts::PI;

    const AROUND: usize = 32;

    /// A surface of revolution about z through (radius, height), closed at both ends.
    fn turned(profile: &[[f64; 2]], squash: f64) -> Mesh {
        let place = |k: usize, [radius, height]: [f64; 2]| {
            let angle = 2.0 * PI * k as f64 / AROUND as f64;
            Vec3::new(radius * angle.cos(), squash * radius * angle.sin(), height)
        };
        let mut vertices: Vec<Vec3> =
            profile.iter().flat_map(|&at| (0..AROUND).map(move |k| place(k, at))).collect();
        let ends = [profile[0], profile[profile.len() - 1]].map(|end| Vec3::new(0.0, 0.0, end[1]));
        let [first, last] = [0, 1].map(|k| (vertices.len() + k) as u32);
        vertices.extend(ends);
        let at = |ring: usize, k: usize| (ring * AROUND + k % AROUND) as u32;
        let mut triangles = Vec::new();
        for k in 0..AROUND {
            triangles.push([first, at(0, k + 1), at(0, k)]);
            for ring in 1..profile.len() {
                let [a, b, c, d] = [at(ring - 1, k), at(ring - 1, k + 1), at(ring, k), at(ring, k + 1)];
                triangles.extend([[a, b, d], [a, d, c]]);
            }
            triangles.push([at(profile.len() - 1, k), at(profile.len() - 1, k + 1), last]);
        }
        Mesh::new(vertices, triangles).unwrap()
    }

    /// A ball with a bag: from its lower pole up over its equator to a mouth at the top, and through that down again.
    /// Returns the rings' number up to that of the mouth, too.
    fn pouch(mouth: f64, squash: f64) -> (Mesh, usize) {
        let outer = |k: usize| 0.05 + (PI - 0.05 - mouth.asin()) * k as f64 / 24.0;
        let mut profile: Vec<[f64; 2]> = (0..=24).map(|k| [outer(k).sin(), -outer(k).cos()]).collect();
        let top = profile[24][1];
        let inner = [[1.0, 0.05], [1.3, 0.15], [2.0, 0.3], [2.0, 0.6], [1.2, 0.8], [0.3, 0.85]];
        profile.extend(inner.map(|[wide, deep]| [mouth * wide, top - deep]));
        (turned(&profile, squash), 25)
    }

    #[test]
    fn a_bag_is_parted_at_its_mouth() {
        for (mouth, squash) in [(0.1, 1.0), (0.2, 1.0), (0.2, 0.7), (0.3, 0.3)] {
            let (mesh, rings) = pouch(mouth, squash);
            let linings = mesh.linings(&Job::default()).unwrap();
            let off = (0u32..).zip(mesh.triangles()).filter(|(number, t)| {
                let ring = t.iter().map(|&v| v as usize / AROUND).sum::<usize>() as f64 / 3.0;
                linings.contains(number) != (ring > (rings - 1) as f64)
            });
            assert!(off.count() <= 2 * AROUND, "{mouth} {squash}");
        }
    }

    #[test]
    fn what_is_seen_lines_nothing() {
        let ball: Vec<[f64; 2]> =
            (1..24).map(|k| PI * f64::from(k) / 24.0).map(|a| [a.sin(), -a.cos()]).collect();
        let bowl = [[0.5, -0.1], [1.0, 0.4], [1.5, 1.0], [1.4, 1.0], [0.9, 0.5], [0.4, 0.1]];
        for profile in [&ball[..], &bowl] {
            assert!(turned(profile, 1.0).linings(&Job::default()).unwrap().is_empty());
        }
    }
}
