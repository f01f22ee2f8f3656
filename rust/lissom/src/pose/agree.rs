//! Turns that agree with where handles go (thesis of S. Zhou 2008, 3.4.2, figure 3-4).
//!
//! ```text
//!     min_r  E(r) = min_x  sum_t sum_{e in t}  w_te | e(x) - C_t(r) e(v) |^2       C_t(r) = exp( sum_h w_h(t) r_h ) S_t
//! ```
//!
//! A handle that turns by itself has the rotation vector `r_h`, about its centre, for which the handles' turns, spread
//! over the surface by harmonic weights (Zayer, Rössl, Karni & Seidel 2005), can be stitched to where all handles are
//! with the least residual: rotations lead there by themselves. The thin shell and the Laplacians, whose own energies
//! do not know a turn from a shear, take the same turns.
//!
//! Triangles of about the same weights share a target (Jacobson, Baran, Kavan, Popović & Sorkine 2012, Fast Automatic
//! Skinning Transformations). Then `E` is a quadratic form of three numbers a cluster and four a handle, the same in
//! each axis. Its matrix is made once; the search (Levenberg 1944, Marquardt 1963) costs nothing per vertex.

use super::goal::HandleMotion;
use super::region::Region;
use crate::linear::dense;
use crate::matrix::{cross, outer, trace};
use crate::rotation::{exp, left_jacobian, polar};
use crate::stitch::{Owners, Reference, Stitcher, Weights};
use crate::{Job, Mat3, Result, Vec3, memory};

/// Clusters of triangles.
const CLUSTERS: usize = 48;

/// Targets whose responses are solved for in one go.
const AT_ONCE: usize = 8;

/// Weights that spread less than this, squared, are the same.
const SAME: f64 = 1e-10;

/// Curvature by a turn, relative to the energy of the mesh itself, below which its place leaves it open.
const OPEN: f64 = 1e-9;

/// A gain below this part of the energy of the mesh itself is rounding.
const ROUNDING: f64 = 1e-14;

const ITERATIONS: usize = 100;

/// A step shorter than this, in radians, is the last.
const LAST_STEP: f64 = 1e-9;

/// The energy of the handles' turns on a region.
#[derive(Debug)]
pub(super) struct Agreement {
    /// The handles' weights in each cluster.
    clusters: Vec<Vec<f64>>,
    /// Of every handle, at rest.
    centres: Vec<Vec3>,
    /// By rows: of the columns of the clusters' changes, then of the handles' changes and of where their centres go.
    gram: Vec<f64>,
    /// `sum w |e(v)|^2`.
    size: f64,
}

/// Triangles of about the same weights.
struct Cluster {
    triangles: Vec<usize>,
    mean: Vec<f64>,
    /// Of the handle whose weight varies most, and how much it does.
    handle: usize,
    spread: f64,
}

/// What turning leaves as it is, and the rotation vectors.
struct Turning<'a> {
    agreement: &'a Agreement,
    motions: &'a [HandleMotion],
    stretches: Vec<Mat3>,
}

impl Agreement {
    /// Clusters the triangles and solves for what each cluster and handle does; `centres` in unit coordinates.
    ///
    /// # Errors
    ///
    /// [`crate::Error::SolveFailed`], [`crate::Error::OutOfMemory`], [`crate::Error::Cancelled`].
    pub fn of(region: &Region, centres: Vec<Vec3>, job: &Job) -> Result<Self> {
        let mesh = region.mesh();
        let (n, handles) = (mesh.rest().len(), centres.len());
        memory::check(
            "the turns of the handles",
            (mesh.triangles().len() + n) as u128 * handles as u128 * 8,
        )?;
        let constraints = region.constraints().clone();
        let stitcher =
            Stitcher::new(mesh.clone(), Owners::Triangles, Weights::Cotangent, None, constraints, job)?;
        let clusters = clusters(region, &weights(region, &stitcher, handles), handles);
        let mut cluster_of = vec![0; mesh.triangles().len()];
        for (c, cluster) in clusters.iter().enumerate() {
            cluster.triangles.iter().for_each(|&t| cluster_of[t] = c);
        }
        let in_cluster = |c: usize, by: Mat3| -> Vec<Mat3> {
            cluster_of.iter().map(|&own| if own == c { by } else { Mat3::ZERO }).collect()
        };
        let arm = |v: usize| region.handle_of(v).map_or(Vec3::ZERO, |h| mesh.rest()[v] - centres[h]);
        let at_rest =
            summed(&stitcher.covariances(Reference::Rest, mesh.rest()), &cluster_of, clusters.len());

        // The axes answer alike: a vector's three components are the answers to three numbers at once.
        let count = 3 * clusters.len() + 4 * handles;
        let mut gram = vec![0.0; count * count];
        let sources: Vec<usize> = (0..clusters.len() + 2 * handles).collect();
        for batch in sources.chunks(AT_ONCE) {
            job.report(batch[0] as f64 / sources.len() as f64, "turns of the handles");
            job.check()?;
            let still = || vec![Vec3::ZERO; n];
            let asked = |&s: &usize| match s < clusters.len() {
                true => stitcher.divergence(Reference::Rest, &in_cluster(s, Mat3::IDENTITY)),
                false => still(),
            };
            let given = |&s: &usize| match s.checked_sub(clusters.len()) {
                None => still(),
                Some(s) => {
                    let moved = |v| if s % 2 == 0 { arm(v) } else { Vec3::ONE };
                    (0..n)
                        .map(|v| if region.handle_of(v) == Some(s / 2) { moved(v) } else { Vec3::ZERO })
                        .collect()
                }
            };
            let asked: Vec<Vec<Vec3>> = batch.iter().map(asked).collect();
            let mut answers: Vec<Vec<Vec3>> = batch.iter().map(given).collect();
            stitcher.system().solve(&asked, &mut answers);
            for ((&source, answer), asked) in batch.iter().zip(&answers).zip(&asked) {
                let of_clusters =
                    summed(&stitcher.covariances(Reference::Rest, answer), &cluster_of, clusters.len());
                let product = stitcher.matrix().times_vectors(answer);
                // By handles: how hard they must pull.
                let mut pulls = vec![[Vec3::ZERO; 4]; handles];
                for (v, (&product, &asked)) in product.iter().zip(asked).enumerate() {
                    if let Some(h) = region.handle_of(v) {
                        let pull = product - asked;
                        let with_arm = outer(pull, arm(v));
                        (0..3).for_each(|k| pulls[h][k] += with_arm.col(k));
                        pulls[h][3] += pull;
                    }
                }
                let rows = match source.checked_sub(clusters.len()) {
                    None => 3 * source..3 * source + 3,
                    Some(s) if s % 2 == 0 => 3 * clusters.len() + 2 * s..3 * clusters.len() + 2 * s + 3,
                    Some(s) => 3 * clusters.len() + 2 * s + 1..3 * clusters.len() + 2 * s + 2,
                };
                for (axis, row) in rows.enumerate() {
                    let own = |c: usize, k: usize| if c == source { at_rest[c].col(k)[axis] } else { 0.0 };
                    let by_cluster = (0..clusters.len())
                        .flat_map(|c| (0..3).map(move |k| (c, k)))
                        .map(|(c, k)| own(c, k) - of_clusters[c].col(k)[axis]);
                    let by_handle = pulls.iter().flatten().map(|pull| pull[axis]);
                    let entries = gram[row * count..(row + 1) * count].iter_mut();
                    entries.zip(by_cluster.chain(by_handle)).for_each(|(entry, value)| *entry = value);
                }
            }
        }
        let size = at_rest.iter().map(|s| trace(*s)).sum();
        Ok(Self { clusters: clusters.into_iter().map(|c| c.mean).collect(), centres, gram, size })
    }

    /// The rotation vectors of all handles, those of the `free` ones found from what they are in `start` on.
    pub fn found(&self, motions: &[HandleMotion], free: &[usize], start: Vec<Vec3>) -> Vec<Vec3> {
        let stretches = motions.iter().map(|m| polar(m.linear).1).collect();
        let turning = Turning { agreement: self, motions, stretches };
        let count = 3 * free.len();
        let (mut found, mut damping) = (start, 1e-3);
        let mut energy = turning.energy(&found);
        for _ in 0..ITERATIONS {
            let changes = turning.changes(&found);
            let slopes = turning.slopes(&found, free);
            let products: Vec<Vec<Vec3>> = slopes.iter().map(|slope| self.product(slope)).collect();
            let gradient: Vec<Vec3> =
                products.iter().map(|product| Vec3::X * -inner(product, &changes)).collect();
            let curvature: Vec<f64> =
                slopes.iter().flat_map(|a| products.iter().map(|b| inner(a, b))).collect();
            let entry = |damping: f64| {
                let curvature = &curvature;
                move |i: usize, j: usize| {
                    let own = curvature[i * count + j];
                    if i == j { own * (1.0 + damping) + OPEN * self.size } else { own }
                }
            };
            let mut better = None;
            while better.is_none() && damping < 1e12 {
                let steps = dense::solve(count, entry(damping), &gradient);
                let mut next = found.clone();
                for (p, step) in steps.iter().enumerate() {
                    next[free[p / 3]][p % 3] += step.x;
                }
                let lower = turning.energy(&next);
                let length = steps.iter().map(|step| step.x * step.x).sum::<f64>().sqrt();
                if lower < energy - ROUNDING * self.size {
                    (better, energy) = (Some((next, length)), lower);
                } else if length < LAST_STEP {
                    break;
                }
                damping *= if better.is_some() { 0.1 } else { 10.0 };
            }
            let Some((next, length)) = better else { break };
            found = next;
            if length < LAST_STEP {
                break;
            }
        }
        found
    }

    fn product(&self, x: &[Vec3]) -> Vec<Vec3> {
        let row = |row: &[f64]| row.iter().zip(x).fold(Vec3::ZERO, |sum, (&g, &x)| sum + x * g);
        self.gram.chunks(x.len()).map(row).collect()
    }
}

impl Turning<'_> {
    fn energy(&self, rotations: &[Vec3]) -> f64 {
        let changes = self.changes(rotations);
        inner(&self.agreement.product(&changes), &changes)
    }

    /// The handles' values, blended by a cluster's weights.
    fn weighted(&self, cluster: &[f64], of: impl Fn(usize) -> Vec3) -> Vec3 {
        cluster.iter().enumerate().fold(Vec3::ZERO, |sum, (h, &w)| sum + of(h) * w)
    }

    /// The target matrix of a cluster.
    fn target(&self, cluster: &[f64], rotations: &[Vec3]) -> Mat3 {
        let turn = exp(self.weighted(cluster, |h| rotations[h]));
        let whole = exp(self.weighted(cluster, |h| self.motions[h].whole_turns));
        let stretches = cluster.iter().zip(&self.stretches);
        turn * whole * stretches.fold(Mat3::IDENTITY, |sum, (&w, &s)| sum + (s - Mat3::IDENTITY) * w)
    }

    /// What the matrix of the quadratic form is for.
    fn changes(&self, rotations: &[Vec3]) -> Vec<Vec3> {
        let columns = |m: Mat3| [m.x_axis - Vec3::X, m.y_axis - Vec3::Y, m.z_axis - Vec3::Z];
        let of_clusters = self.agreement.clusters.iter().flat_map(|c| columns(self.target(c, rotations)));
        let of_handles = self.motions.iter().enumerate().flat_map(|(h, m)| {
            let centre = m.displacement(self.agreement.centres[h]);
            columns(exp(rotations[h]) * self.stretches[h]).into_iter().chain([centre])
        });
        of_clusters.chain(of_handles).collect()
    }

    /// Its derivatives by the free rotation vectors.
    fn slopes(&self, rotations: &[Vec3], free: &[usize]) -> Vec<Vec<Vec3>> {
        let of_handle = |&handle: &usize| {
            let mut slopes = [0, 1, 2].map(|_| Vec::new());
            let mut push = |jacobian: Mat3, target: Mat3| {
                for (k, slope) in slopes.iter_mut().enumerate() {
                    let m = cross(jacobian.col(k)) * target;
                    slope.extend([m.x_axis, m.y_axis, m.z_axis]);
                }
            };
            for cluster in &self.agreement.clusters {
                let blended = self.weighted(cluster, |h| rotations[h]);
                push(left_jacobian(blended) * cluster[handle], self.target(cluster, rotations));
            }
            let clusters = 3 * self.agreement.clusters.len();
            push(left_jacobian(rotations[handle]), exp(rotations[handle]) * self.stretches[handle]);
            slopes.map(|mut slope| {
                let own = slope.split_off(clusters);
                slope.resize(clusters + 4 * rotations.len(), Vec3::ZERO);
                slope[clusters + 4 * handle..][..3].copy_from_slice(&own);
                slope
            })
        };
        free.iter().flat_map(of_handle).collect()
    }
}

fn inner(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}

fn summed(covariances: &[Mat3], cluster_of: &[usize], clusters: usize) -> Vec<Mat3> {
    let mut sums = vec![Mat3::ZERO; clusters];
    covariances.iter().zip(cluster_of).for_each(|(covariance, &c)| sums[c] += *covariance);
    sums
}

/// The handles' weights in every triangle.
fn weights(region: &Region, stitcher: &Stitcher, handles: usize) -> Vec<Vec<f64>> {
    let three = |first: usize| {
        let axis = |h: usize| h.checked_sub(first).and_then(|k| Vec3::AXES.get(k));
        region.at_handles(|h| axis(h).copied().unwrap_or(Vec3::ZERO))
    };
    let mut fields: Vec<Vec<Vec3>> = (0..handles).step_by(3).map(three).collect();
    stitcher.system().extend(&mut fields);
    let mean = |t: &[u32; 3]| {
        let at = |h: usize| t.iter().map(|&v| fields[h / 3][v as usize][h % 3]).sum::<f64>() / 3.0;
        (0..handles).map(at).collect()
    };
    region.mesh().triangles().iter().map(mean).collect()
}

/// Triangles by their weights: what varies most is split at its mean, again and again.
fn clusters(region: &Region, weights: &[Vec<f64>], handles: usize) -> Vec<Cluster> {
    let areas = region.mesh().areas();
    let cluster = |triangles: Vec<usize>| {
        let area = triangles.iter().map(|&t| areas[t]).sum::<f64>().max(f64::MIN_POSITIVE);
        let sum = |of: &dyn Fn(usize) -> f64| triangles.iter().map(|&t| areas[t] * of(t)).sum::<f64>();
        let mean: Vec<f64> = (0..handles).map(|h| sum(&|t| weights[t][h]) / area).collect();
        let spreads = (0..handles).map(|h| (h, sum(&|t| (weights[t][h] - mean[h]).powi(2))));
        let (handle, spread) = spreads.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
        Cluster { triangles, mean, handle, spread }
    };
    let mut clusters = vec![cluster((0..weights.len()).collect())];
    while clusters.len() < CLUSTERS {
        let widest = (0..clusters.len()).max_by(|&a, &b| clusters[a].spread.total_cmp(&clusters[b].spread));
        let Some(widest) = widest.filter(|&c| clusters[c].spread > SAME) else { break };
        let Cluster { triangles, mean, handle, .. } = clusters.swap_remove(widest);
        let (below, above): (Vec<usize>, Vec<usize>) =
            triangles.into_iter().partition(|&t| weights[t][handle] < mean[handle]);
        clusters.extend([cluster(below), cluster(above)]);
    }
    clusters
}
