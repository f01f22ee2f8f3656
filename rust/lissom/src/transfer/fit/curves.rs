//! Curves: paths along edges of the source and of the target that belong together, as the rims of lids and lips do.
//!
//! They are matched by arc length: evenly between two markers that lie on both, and between the ends of paths.
//! Which way round they go, and where a loop without a marker on it begins, is what makes them most alike once
//! the source is turned as the target is: the largest
//!
//! ```text
//!     sum_i (R a_i) . b_i  /  ( sum_i |a_i|^2  sum_i |b_i|^2 )^1/2        a_i, b_i from the centroids
//! ```

use std::collections::HashSet;

use super::markers::Marker;
use crate::geometry::polyline::Polyline;
use crate::transfer::correspondence::CurvePoint;
use crate::{Error, Fault, Mat3, Mesh, Result, Vec3};

/// Markers lie on a curve within this distance, in unit coordinates.
const ON: f64 = 1e-3;

/// Most vertices of a curve that become markers: what is between them follows.
const MOST: usize = 64;

/// Places at which curves are compared.
const COMPARED: usize = 64;

/// Places where a loop may begin, and how often the way from one to the next is halved.
const BEGINNINGS: usize = 64;
const HALVINGS: usize = 8;

/// One on the source and one on the target.
pub struct Curve {
    sides: [Side; 2],
    closed: bool,
}

struct Side {
    vertices: Vec<u32>,
    line: Polyline,
}

/// How the lengths along both belong together: evenly between knots, which count from `start`.
pub struct Matched {
    start: [f64; 2],
    knots: Vec<[f64; 2]>,
    /// Whether the target's length is counted from its end.
    reversed: bool,
}

impl Matched {
    /// Where the target's side of a loop begins, on that of this length.
    fn beginning(&self, length: f64) -> f64 {
        if self.reversed { length - self.start[1] } else { self.start[1] }
    }
}

/// The curves of two meshes, by their vertices.
///
/// # Errors
///
/// [`Error::InvalidConstraint`] for fewer than two vertices, an index out of range, vertices that no edge joins, a
/// vertex that comes twice, no length, and a loop for a path.
pub fn check(source: &Mesh, target: &Mesh, curves: &[[Vec<u32>; 2]]) -> Result<Vec<Curve>> {
    if curves.is_empty() {
        return Ok(Vec::new());
    }
    let edges = [source, target].map(|mesh| mesh.adjacency().edges().iter().copied().collect());
    let curve = |(i, [s, t]): (usize, &[Vec<u32>; 2])| {
        let name = format!("curves[{i}]");
        let source = Side::new(&name, "source", source, &edges[0], s)?;
        let target = Side::new(&name, "target", target, &edges[1], t)?;
        let [closed, other] = [&source, &target].map(Side::is_closed);
        if closed != other {
            let [a, b] = if closed { ["source", "target"] } else { ["target", "source"] };
            let problem = format!(
                "the {a}'s is a loop, the {b}'s a path with two ends: choose two of a kind (a loop ends with its \
                 first vertex)"
            );
            return Err(Error::InvalidConstraint(Fault::new(name, problem)));
        }
        Ok(Curve { sides: [source, target], closed })
    };
    curves.iter().enumerate().map(curve).collect()
}

impl Side {
    fn new(name: &str, side: &str, mesh: &Mesh, edges: &HashSet<[u32; 2]>, given: &[u32]) -> Result<Self> {
        let refuse = |fault: Option<Fault>| fault.map_or(Ok(()), |f| Err(Error::InvalidConstraint(f)));
        let (n, count) = (mesh.vertices().len(), given.len());
        if count < 2 {
            let problem = format!("{count} {side} vertices; a curve has two at least, joined by edges");
            return refuse(Some(Fault::new(name, problem))).map(|()| unreachable!());
        }
        let outside = (0..count).filter(|&i| given[i] as usize >= n);
        refuse(Fault::at(name, format!("{side} vertex out of range, the mesh has {n}"), outside))?;
        let vertices: Vec<u32> = given.iter().map(|&v| mesh.representative(v)).collect();
        let closed = count > 3 && vertices[0] == vertices[count - 1];
        let mut seen = HashSet::new();
        let again = (0..count - usize::from(closed)).filter(|&i| !seen.insert(vertices[i]));
        refuse(Fault::at(
            name,
            format!("{side} vertex comes twice: a curve does not branch or cross"),
            again,
        ))?;
        let joined = |a: u32, b: u32| edges.contains(&[a.min(b), a.max(b)]);
        let apart = (1..count).filter(|&i| !joined(vertices[i - 1], vertices[i]));
        refuse(Fault::at(name, format!("no edge joins the {side} vertex to the one before"), apart))?;
        let line = Polyline::new(vertices.iter().map(|&v| mesh.rest()[v as usize]).collect());
        let no_length =
            (line.length() <= 0.0).then(|| Fault::new(name, format!("the {side}'s has no length")));
        refuse(no_length)?;
        Ok(Self { vertices, line })
    }

    fn is_closed(&self) -> bool {
        self.vertices[0] == self.vertices[self.vertices.len() - 1]
    }

    /// The vertices, each once, with their arc lengths.
    fn distinct(&self) -> impl ExactSizeIterator<Item = (u32, f64)> + '_ {
        let count = self.vertices.len() - usize::from(self.is_closed());
        (0..count).map(|i| (self.vertices[i], self.line.lengths()[i]))
    }
}

impl Curve {
    /// Where its middle is on the source and on the target.
    pub fn centroids(&self) -> (Vec3, Vec3) {
        (self.sides[0].line.centroid(), self.sides[1].line.centroid())
    }

    /// How it is matched by those of `markers` that lie on it, where the target is turned by `rotation` against
    /// the source; `Err` where these come in another order on the target, so that the lengths alone must tell.
    pub fn matched(&self, markers: &[Marker], rotation: Mat3) -> std::result::Result<Matched, Matched> {
        let on = |marker: &Marker| {
            let [s, t] = [(0, marker.rest), (1, marker.goal)].map(|(i, p)| self.sides[i].line.closest(p));
            (s.1 < ON && t.1 < ON).then_some([s.0, t.0])
        };
        let marks: Vec<[f64; 2]> = markers.iter().filter_map(on).collect();
        match self.most_alike(&marks, rotation) {
            Some(matched) => Ok(matched),
            // Without any, there is always one.
            None => self.most_alike(&[], rotation).map_or_else(|| Ok(self.evenly()), Err),
        }
    }

    fn evenly(&self) -> Matched {
        Matched { start: [0.0; 2], knots: vec![[0.0; 2], self.lengths()], reversed: false }
    }

    fn most_alike(&self, marks: &[[f64; 2]], rotation: Mat3) -> Option<Matched> {
        let best = |ways: &mut dyn Iterator<Item = (Vec<[f64; 2]>, bool)>| {
            let matched = ways.filter_map(|(marks, reversed)| self.between(&marks, reversed));
            let likeness = |matched: Matched| (self.likeness(&matched, rotation), matched);
            matched.map(likeness).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, matched)| matched)
        };
        if !(marks.is_empty() && self.closed) {
            return best(&mut [false, true].into_iter().map(|reversed| (marks.to_vec(), reversed)));
        }
        let mut step = self.lengths()[1] / BEGINNINGS as f64;
        let everywhere = (0..BEGINNINGS).map(|i| i as f64 * step);
        let beginning = |at: f64, reversed: bool| (vec![[0.0, at]], reversed);
        let mut found = best(&mut everywhere.flat_map(|at| [false, true].map(|way| beginning(at, way))))?;
        for _ in 0..HALVINGS {
            step *= 0.5;
            let (at, reversed) = (found.beginning(self.lengths()[1]), found.reversed);
            found = best(&mut [at - step, at, at + step].into_iter().map(|at| beginning(at, reversed)))?;
        }
        Some(found)
    }

    fn lengths(&self) -> [f64; 2] {
        self.sides.each_ref().map(|side| side.line.length())
    }

    /// Matched between these places of both; `None` where they do not follow each other.
    fn between(&self, marks: &[[f64; 2]], reversed: bool) -> Option<Matched> {
        let lengths = self.lengths();
        let mut knots: Vec<[f64; 2]> =
            marks.iter().map(|&[s, t]| [s, if reversed { lengths[1] - t } else { t }]).collect();
        let mut start = [0.0; 2];
        if self.closed {
            start = *knots.first()?;
            for knot in &mut knots {
                *knot = [0, 1].map(|i| (knot[i] - start[i]).rem_euclid(lengths[i]));
            }
        }
        knots.sort_by(|a, b| a[0].total_cmp(&b[0]));
        // Ends belong together, unless a marker puts one of them elsewhere.
        let apart = |a: [f64; 2], b: [f64; 2]| (0..2).all(|i| (a[i] - b[i]).abs() > ON);
        if !self.closed && knots.first().is_none_or(|&first| apart(first, [0.0; 2])) {
            knots.insert(0, [0.0; 2]);
        }
        if self.closed || knots.last().is_none_or(|&last| apart(last, lengths)) {
            knots.push(lengths);
        }
        let follow = |w: &[[f64; 2]]| w[1][0] > w[0][0] && w[1][1] > w[0][1];
        (knots.len() > 1 && knots.windows(2).all(follow)).then_some(Matched { start, knots, reversed })
    }

    /// The arc length on the other side that belongs to one on `side`; `None` beyond the ends.
    fn across(&self, matched: &Matched, side: usize, length: f64) -> Option<f64> {
        let (other, lengths, knots) = (1 - side, self.lengths(), &matched.knots);
        let turned = |side: usize, length: f64| match matched.reversed && side == 1 {
            true => lengths[1] - length,
            false => length,
        };
        let wrapped = |side: usize, length: f64| match self.closed {
            true => length.rem_euclid(lengths[side]),
            false => length,
        };
        let from = wrapped(side, turned(side, length) - matched.start[side]);
        let slack = 1e-12 * lengths[side];
        if from < knots[0][side] - slack || from > knots[knots.len() - 1][side] + slack {
            return None;
        }
        let next = knots.partition_point(|knot| knot[side] <= from).clamp(1, knots.len() - 1);
        let (a, b) = (knots[next - 1], knots[next]);
        let to = a[other] + (from - a[side]) / (b[side] - a[side]) * (b[other] - a[other]);
        Some(wrapped(other, turned(other, wrapped(other, to + matched.start[other]))))
    }

    fn likeness(&self, matched: &Matched, rotation: Mat3) -> f64 {
        let [source, target] = self.sides.each_ref().map(|side| &side.line);
        let places = (0..COMPARED).map(|i| (i as f64 + 0.5) / COMPARED as f64 * source.length());
        let both: Vec<(Vec3, Vec3)> = places
            .filter_map(|s| Some((rotation * source.at(s), target.at(self.across(matched, 0, s)?))))
            .collect();
        let count = both.len().max(1) as f64;
        let (a, b) =
            both.iter().fold((Vec3::ZERO, Vec3::ZERO), |(a, b), (p, q)| (a + p / count, b + q / count));
        let (mut product, mut squares) = (0.0, [0.0; 2]);
        for (p, q) in both {
            product += (p - a).dot(q - b);
            squares = [squares[0] + p.distance_squared(a), squares[1] + q.distance_squared(b)];
        }
        product / (squares[0] * squares[1]).sqrt().max(f64::MIN_POSITIVE)
    }

    /// Its vertices on the source, with where they belong.
    pub fn markers(&self, source: &Mesh, matched: &Matched) -> Vec<Marker> {
        let (count, target) = (self.sides[0].distinct().len(), &self.sides[1].line);
        let step = count.div_ceil(MOST);
        let spacing = target.length() * step as f64 / count as f64;
        let at = |t: f64| target.at(if self.closed { t.rem_euclid(target.length()) } else { t });
        let marker = |(vertex, s): (u32, f64)| {
            let t = self.across(matched, 0, s)?;
            let tangent = (at(t + spacing) - at(t - spacing)).normalize_or_zero();
            Some(Marker { tangent, ..Marker::at_vertex(source, vertex, at(t)) })
        };
        self.sides[0].distinct().step_by(step).filter_map(marker).collect()
    }

    /// Its vertices on the target, with the places of the source that belong to them.
    pub fn places(&self, matched: &Matched) -> Vec<CurvePoint> {
        let source = &self.sides[0];
        let place = |(vertex, t): (u32, f64)| {
            let (segment, fraction) = source.line.place(self.across(matched, 1, t)?);
            let edge = [source.vertices[segment], source.vertices[segment + 1]];
            Some(CurvePoint { vertex, edge, fraction })
        };
        self.sides[1].distinct().filter_map(place).collect()
    }
}
