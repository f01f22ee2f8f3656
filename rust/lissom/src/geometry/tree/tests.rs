//! The tree of boxes: that it passes over nothing nearer, and what a search costs.

use super::*;
use crate::geometry::rows::Rows;
use std::cell::Cell;

/// The bounds of the triangles of a wavy sheet of `n` by `n` squares, `lift` above the plane.
fn sheet(n: usize, lift: f64) -> Vec<Bounds> {
    let at = |i: usize, j: usize| {
        let (x, y) = (i as f64 / n as f64, j as f64 / n as f64);
        Vec3::new(x, y, lift + 0.1 * (7.0 * x).sin() * (5.0 * y).cos())
    };
    let squares = (0..n * n).map(|k| (k / n, k % n));
    let halves = squares.flat_map(|(i, j)| {
        [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    });
    halves
        .map(|[a, b, c]| {
            let normal = (b - a).cross(c - a).normalize();
            Bounds { place: [a.min(b).min(c), a.max(b).max(c)], normal }
        })
        .collect()
}

/// The least squared distance to the centre of a box that faces the way of `facing`, and how many were looked at.
fn nearest(tree: &Tree, bounds: &[Bounds], order: &[u32], point: Vec3, facing: Vec3) -> (f64, usize) {
    let looked_at = Cell::new(0);
    let at = |slot: u32, _| {
        looked_at.set(looked_at.get() + 1);
        let Bounds { place: [low, high], normal } = bounds[order[slot as usize] as usize];
        let squared = ((low + high) * 0.5).distance_squared(point);
        (normal.dot(facing) > 0.0).then_some((squared, ()))
    };
    let probe = tree.probe(point, Some(facing)).unwrap();
    let found = tree.nearest(&probe, f64::INFINITY, at);
    (found.map_or(f64::INFINITY, |found| found.0), looked_at.get())
}

#[test]
fn nothing_nearer_is_passed_over() {
    for (shift, scale) in [(Vec3::ZERO, 1.0), (Vec3::new(3e5, -1e3, 7.0), 1.0), (Vec3::ONE, 1e-7)] {
        let moved = |bounds: &Bounds| {
            let place = bounds.place.map(|p| p * scale + shift);
            Bounds { place, ..*bounds }
        };
        let (flat, bounds): (Vec<Bounds>, Vec<Bounds>) =
            sheet(13, 0.2).iter().map(|of| (Bounds { place: [shift; 2], ..*of }, moved(of))).unzip();
        let (tree, order) = Tree::new(&bounds, 0..bounds.len() as u32);
        // Sorted where all lies in one place, and then moved apart.
        let (mut late, late_order) = Tree::new(&flat, 0..flat.len() as u32);
        late.fit(|slot| bounds[late_order[slot as usize] as usize]);
        for k in 0..60 {
            let way = Vec3::new((k as f64).sin(), (2.7 * k as f64).cos(), (1.9 * k as f64).sin());
            let off = [1.0, 0.01, 1e3, 1e9][k % 4];
            let point = shift + (Vec3::new(0.5, 0.4, 0.2) + way * off) * scale;
            let facing = Vec3::new(way.y, way.z, way.x) * 1e-30;
            let all = (0..bounds.len() as u32).collect::<Vec<_>>();
            let least = all.iter().filter(|&&t| bounds[t as usize].normal.dot(facing) > 0.0);
            let squared = |&t: &u32| {
                ((bounds[t as usize].place[0] + bounds[t as usize].place[1]) * 0.5).distance_squared(point)
            };
            let expected = least.map(squared).fold(f64::INFINITY, f64::min);
            assert_eq!(nearest(&tree, &bounds, &order, point, facing).0, expected);
            assert_eq!(nearest(&late, &bounds, &late_order, point, facing).0, expected);
        }
    }
}

#[test]
fn what_faces_away_costs_next_to_nothing_however_much_there_is() {
    // Closer by, as finely cut, is what faces away: one third of it is nearer than what is looked for, of which more
    // is as near to within the size of a triangle the smaller these are.
    let cost = |n: usize| -> f64 {
        let mut bounds = sheet(n, 0.0);
        bounds.extend(sheet(n, 0.3).iter().map(|of| Bounds { normal: -of.normal, ..*of }));
        let (tree, order) = Tree::new(&bounds, 0..bounds.len() as u32);
        let queries = sheet(20, 0.29);
        let each = queries.iter().map(|of| nearest(&tree, &bounds, &order, of.place[0], of.normal).1);
        each.sum::<usize>() as f64 / queries.len() as f64
    };
    let (few, many) = (cost(20), cost(80));
    assert!(few < 50.0 && many < 5.0 * few, "{few} of 1600 triangles looked at, {many} of 25600");
}

#[test]
fn no_direction_and_no_triangles_find_nothing() {
    let (tree, order) = Tree::new(&[], 0..0);
    assert_eq!(nearest(&tree, &[], &order, Vec3::ZERO, Vec3::X), (f64::INFINITY, 0));
    assert!(tree.probe(Vec3::ZERO, Some(Vec3::ZERO)).is_none());
    assert!(tree.probe(Vec3::ZERO, Some(Vec3::splat(f64::NAN))).is_none());
}

#[test]
fn one_of_many_cards_costs_as_much_however_many_there_are() {
    // All in the same square, so that ever more of them are nearer than the one that is asked for.
    let cost = |n: usize| -> f64 {
        let card = |k: usize| {
            let at = Vec3::new((k / n) as f64 / n as f64, (k % n) as f64 / n as f64, 0.0);
            let normal = Vec3::new((2.1 * k as f64).cos(), (2.1 * k as f64).sin(), 0.0);
            [0.0, 0.1].map(|up| Bounds { place: [at + up * Vec3::Z, at + Vec3::splat(0.1 + up)], normal })
        };
        let bounds: Vec<Bounds> = (0..n * n).flat_map(card).collect();
        let (tree, order) = Tree::new(&bounds, 0..bounds.len() as u32);
        let of_slot = order.iter().map(|&t| t / 2).zip(0u32..);
        let slots = Rows::sort(n * n, of_slot);
        let nodes = Cell::new(0);
        let asked = (0..n * n).step_by(n * n / 100);
        for k in asked.clone() {
            let Bounds { place: [low, high], normal } = bounds[2 * k];
            let beside = (low + high) * 0.5 + Vec3::new(0.1, -0.1, 0.0);
            let probe = tree.probe(beside, Some(normal)).unwrap();
            let own = slots.of(k);
            let bound = |node: usize, all| {
                nodes.set(nodes.get() + 1);
                let mut bound = tree.bound(node, &probe);
                let shares = tree.nodes[node].deal(own, all, &mut bound);
                (bound, shares)
            };
            let at = |_, _| None::<(f64, ())>;
            tree.search(f64::INFINITY, 1.0, [0, own.len() as u32], bound, at);
        }
        f64::from(nodes.get()) / asked.count() as f64
    };
    let (few, many) = (cost(10), cost(80));
    assert!(few < 12.0 && many < 3.0 * few, "{few} nodes of 200 boxes looked into, {many} of 12800");
}

#[test]
fn the_middle_of_a_round_body_is_as_far_from_few_as_from_all() {
    let cost = |n: usize, slabs: bool| -> f64 {
        let at = |i: usize, j: usize| {
            let (u, v) = (i as f64 * 3.1 / n as f64 + 0.02, j as f64 * 6.25 / n as f64);
            Vec3::new(u.sin() * v.cos(), u.sin() * v.sin(), 1.1 * u.cos())
        };
        let halves = (0..n * n).map(|k| (k / n, k % n)).flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        });
        let triangles: Vec<[Vec3; 3]> = halves.collect();
        let bounds = |[a, b, c]: &[Vec3; 3]| {
            let normal = (*b - *a).cross(*c - *a).normalize_or_zero();
            Bounds { place: [a.min(*b).min(*c), a.max(*b).max(*c)], normal }
        };
        let bounds: Vec<Bounds> = triangles.iter().map(bounds).collect();
        let (mut tree, order) = Tree::new(&bounds, 0..bounds.len() as u32);
        if slabs {
            tree.add_slabs(|slot| triangles[order[slot as usize] as usize]);
        }
        let looked_at = Cell::new(0);
        for k in 0..50 {
            let way = Vec3::new((k as f64).sin(), (2.7 * k as f64).cos(), (1.9 * k as f64).sin()) * 0.02;
            let squared = |[a, b, c]: [Vec3; 3]| {
                a.distance_squared(way).min(b.distance_squared(way)).min(c.distance_squared(way))
            };
            let at = |slot: u32, _| {
                looked_at.set(looked_at.get() + 1);
                Some((squared(triangles[order[slot as usize] as usize]), ()))
            };
            let (least, ()) = tree.nearest(&tree.probe(way, None).unwrap(), f64::INFINITY, at).unwrap();
            assert_eq!(least, triangles.iter().copied().map(squared).fold(f64::INFINITY, f64::min));
        }
        f64::from(looked_at.get()) / 50.0
    };
    let (with, without) = (cost(60, true), cost(60, false));
    assert!(10.0 * with < without, "{with} of 7200 triangles looked at, {without} by boxes alone");
}
