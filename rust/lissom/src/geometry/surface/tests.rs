//! Closest points of a surface and rays through it, where sides, edges and slivers mislead.

use super::*;

/// Two parallel squares that face away from each other, 0.1 apart.
fn squares() -> Vec<[Vec3; 3]> {
    let at = |x: f64, y: f64, z: f64| Vec3::new(x, y, z);
    vec![
        [at(0.0, 0.0, 0.1), at(1.0, 0.0, 0.1), at(1.0, 1.0, 0.1)],
        [at(0.0, 0.0, 0.1), at(1.0, 1.0, 0.1), at(0.0, 1.0, 0.1)],
        [at(0.0, 0.0, 0.0), at(1.0, 1.0, 0.0), at(1.0, 0.0, 0.0)],
        [at(0.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(1.0, 1.0, 0.0)],
    ]
}

fn sheet() -> Surface {
    Surface::new(squares())
}

#[test]
fn the_side_is_chosen_by_the_normal_not_by_the_distance() {
    let point = Vec3::new(0.7, 0.2, 0.2);
    let hit = sheet().closest_compatible_point(point, Vec3::new(0.1, 0.0, 1.0)).unwrap();
    assert_eq!((hit.triangle, hit.point), (0, Vec3::new(0.7, 0.2, 0.1)));
    let hit = sheet().closest_compatible_point(point, Vec3::new(0.1, 0.0, -1.0)).unwrap();
    assert_eq!((hit.triangle, hit.point), (2, Vec3::new(0.7, 0.2, 0.0)));
    assert!(sheet().closest_compatible_point(point, Vec3::X).is_none());
    assert_eq!(sheet().closest_point(point).unwrap().triangle, 0);
}

#[test]
fn a_ray_leaves_through_edges_and_corners_too() {
    let up = |x: f64, y: f64| sheet().exit(Vec3::new(x, y, -1.0), Vec3::Z, |_| true);
    for [x, y] in [[0.7, 0.2], [0.4, 0.4], [0.0, 0.5], [1.0, 1.0], [0.0, 0.0]] {
        // Below is the side that faces down, through which nothing leaves upwards.
        let hit = up(x, y).unwrap();
        assert!((hit.distance - 1.1).abs() < 1e-12 && (hit.weights.element_sum() - 1.0).abs() < 1e-12);
        assert!(hit.point.distance(Vec3::new(x, y, 0.1)) < 1e-12 && hit.triangle < 2);
    }
    assert!(up(1.1, 0.5).is_none() && up(0.5, -0.1).is_none());
    assert!(sheet().exit(Vec3::new(0.7, 0.2, -1.0), Vec3::Z, |t| t != 0).is_none());
    assert!(sheet().exit(Vec3::new(0.7, 0.2, 1.0), Vec3::Z, |_| true).is_none());
}

#[test]
fn centroids_are_centroids_and_reach_is_to_the_surface() {
    let point = Vec3::new(2.0 / 3.0, 1.0 / 3.0, 0.3);
    let hit = sheet().closest_compatible_centroid_of(None, point, Vec3::Z, f64::INFINITY).unwrap();
    assert_eq!(hit.triangle, 0);
    assert!((hit.distance - 0.2).abs() < 1e-12);
    let within = |reach| sheet().closest_compatible_point_on(point, Vec3::Z, reach, |_| true).is_some();
    assert!(within(0.21) && !within(0.19));
    let parts = Surface::in_parts(squares(), |_| true, &[0, 1, 0, 1]);
    let other = parts.closest_compatible_centroid_of(Some(1), point, Vec3::Z, f64::INFINITY).unwrap();
    assert_eq!(other.triangle, 1);
}

#[test]
fn what_is_not_open_is_not_found_and_what_moves_is_found_where_it_is() {
    let (point, corners) = (Vec3::new(0.7, 0.2, 0.2), squares());
    let mut surface = Surface::in_parts(corners.clone(), |t| t != 0, &[]);
    let hit = surface.closest_compatible_point(point, Vec3::Z).unwrap();
    assert!(hit.triangle == 1 && hit.point.distance(Vec3::new(0.45, 0.45, 0.1)) < 1e-12);
    assert!(surface.normal(0) == Vec3::Z && (surface.centroid(0).z - 0.1).abs() < 1e-12);
    let moved: Vec<Vec3> = corners.iter().flatten().map(|&p| p * 2.0 + Vec3::X).collect();
    surface.follow(&[[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]], &moved);
    let hit = surface.closest_compatible_point(point * 2.0 + Vec3::X, Vec3::Z).unwrap();
    assert!(hit.triangle == 1 && hit.point.distance(Vec3::new(1.9, 0.9, 0.2)) < 1e-12);
    assert!(hit.weights.distance(Vec3::new(0.55, 0.45, 0.0)) < 1e-12);
}

#[test]
fn places_of_slivers_and_points_are_the_nearest_there_are() {
    let at = |x: f64, y: f64| Vec3::new(x, y, 0.0);
    for (corners, point, nearest) in [
        ([at(0.0, 0.0), at(1.0, 0.0), at(0.5, 1e-12)], Vec3::new(0.3, 1.0, 2.0), at(0.3, 0.0)),
        ([at(0.0, 0.0), at(1.0, 0.0), at(2.0, 0.0)], at(1.7, 3.0), at(1.7, 0.0)),
        ([at(1.0, 2.0); 3], Vec3::ZERO, at(1.0, 2.0)),
        // Beyond the edge at the obtuse corner, nearest to the corner.
        ([at(0.0, 0.0), at(1.0, 0.0), at(-1.0, 0.2)], at(-0.01, -0.3), at(0.0, 0.0)),
    ] {
        let surface = Surface::new(vec![corners]);
        let hit = surface.closest_point(point).unwrap();
        assert!(hit.point.distance(nearest) < 1e-9, "{} instead of {nearest}", hit.point);
        assert!((hit.distance - point.distance(nearest)).abs() < 1e-9);
        assert!((hit.weights.element_sum() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_part_is_searched_as_if_it_were_alone() {
    let cards = |k: usize| {
        let (x, y) = ((1.7 * k as f64).sin(), (2.3 * k as f64).cos());
        let at = |dx: f64, dz: f64| Vec3::new(x + dx, y + 0.3 * dx * x, dz);
        [[at(0.0, 0.0), at(0.3, 0.0), at(0.3, 0.5)], [at(0.0, 0.0), at(0.3, 0.5), at(0.0, 0.5)]]
    };
    let part = |t: usize| (t / 2 % 97) as u32;
    let corners: Vec<[Vec3; 3]> = (0..300).flat_map(cards).collect();
    let parts: Vec<u32> = (0..corners.len()).map(part).collect();
    let open = |t: usize| !t.is_multiple_of(5);
    let surface = Surface::in_parts(corners.clone(), open, &parts);
    for k in 0..200 {
        let own = k as u32 % 97;
        let alone = Surface::in_parts(corners.clone(), |t| open(t) && part(t) == own, &[]);
        let point = Vec3::new((1.1 * k as f64).cos(), (0.9 * k as f64).sin(), 0.2);
        let (normal, reach) = (Vec3::new(point.y, point.x, 0.1), [f64::INFINITY, 0.6][k % 2]);
        let both = [(&surface, Some(own)), (&alone, None)];
        let [found, expected] =
            both.map(|(surface, part)| surface.closest_compatible_point_of(part, point, normal, reach));
        assert_eq!(found.map(|hit| hit.distance), expected.map(|hit| hit.distance));
        assert!(found.is_none_or(|hit| part(hit.triangle) == own));
        let [found, expected] =
            both.map(|(surface, part)| surface.closest_compatible_centroid_of(part, point, normal, reach));
        assert_eq!(found.map(|hit| hit.distance), expected.map(|hit| hit.distance));
    }
}
