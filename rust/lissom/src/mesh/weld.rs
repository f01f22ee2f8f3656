//! Vertices in one place that no triangle joins, as where a surface is stored triangle by triangle.

use rustc_hash::FxHashMap;

use crate::Vec3;

/// For each point the first within `distance` of it that stands for others or itself; only `used` points take
/// part. Each stands within `distance` of the one that stands for it, however many follow one another closely.
pub(super) fn representatives(points: &[Vec3], used: &[bool], distance: f64) -> Vec<u32> {
    // Points of one cell and its neighbours; without a distance the cells are the points themselves.
    let cell = |p: Vec3| if distance > 0.0 { (p / distance).floor() } else { p };
    let steps: &[f64] = if distance > 0.0 { &[-1.0, 0.0, 1.0] } else { &[0.0] };
    // Zero has two signs.
    let key = |c: Vec3| (c + 0.0).to_array().map(f64::to_bits);
    // The last point of each cell, and for each point the one before it in its cell.
    let mut cells: FxHashMap<[u64; 3], u32> = FxHashMap::default();
    cells.reserve(points.len());
    let mut before = vec![None; points.len()];
    let mut stands = |v: u32| {
        let p = points[v as usize];
        let around = (0..steps.len().pow(3)).map(|k| {
            let axis = |a: u32| steps[k / steps.len().pow(a) % steps.len()];
            Vec3::new(axis(0), axis(1), axis(2))
        });
        let last = around.filter_map(|step| cells.get(&key(cell(p) + step)).copied());
        let near = last.flat_map(|last| std::iter::successors(Some(last), |&w| before[w as usize]));
        let first = near.filter(|&w| points[w as usize].distance(p) <= distance).min();
        first.unwrap_or_else(|| {
            before[v as usize] = cells.insert(key(cell(p)), v);
            v
        })
    };
    (0u32..).zip(used).map(|(v, &used)| if used { stands(v) } else { v }).collect()
}
