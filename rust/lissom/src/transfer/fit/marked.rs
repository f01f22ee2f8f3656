//! What leads a fit: markers and curves, less what is doubtful among them; and how the source lies by them.
//!
//! Of a curve its centroid stands beside the markers where doubts and the lie are found out, so that it counts as
//! one of them however long it is, and is left out as a whole or not at all.

use std::ops::Range;

use super::curves::{self, Curve, Matched};
use super::doubtful::{Doubtful, doubtful};
use super::lie::Lie;
use super::markers::{self, ELSEWHERE, Marker, PROPORTIONS};
use super::options::FitOptions;
use super::side::{Placed, Side};
use crate::transfer::alignment::{self, Found};
use crate::transfer::correspondence::CurvePoint;
use crate::{Error, Fault, Job, Mat3, Mesh, Result, Vec3};

/// Without markers, the meshes lie on each other less surely than this by chance, and are refused; ...
const GUESSED: f64 = 0.1;

/// ... less surely than this, it is said.
const UNSURE: f64 = 0.5;

/// A marker that was left out and is met within so many tolerances was right: those beside it are not. A curve that
/// is not met within them has been followed in vain.
const MET: f64 = 2.0;

/// What leads a fit.
pub struct Marked {
    /// How the source lies, with the markers to follow.
    pub lie: Lie,
    /// What these come from.
    pub led_by: LedBy,
}

/// All markers and curves.
pub struct LedBy {
    markers: Vec<Marker>,
    /// As markers, and their vertices on the target.
    curves: Vec<(Vec<Marker>, Vec<CurvePoint>)>,
    /// The curves on which the markers come in another order than on the target.
    reordered: Vec<usize>,
    /// The doubtful ones, counted through markers and curves, and how far each is off.
    doubts: Vec<(usize, f64)>,
    /// The curves that the surfaces speak against, and how far each is off by these.
    astray: Vec<(usize, f64)>,
    exact: bool,
}

/// What became of them; of two, the first is of markers, the second of curves.
pub struct Led {
    /// How far each is from where it belongs, in the target's unit coordinates.
    pub off: [Vec<f64>; 2],
    /// Those that were left out and not met all the same.
    pub doubtful: [Vec<Doubtful>; 2],
    /// The curves that were followed and not met.
    pub unmet: Vec<Doubtful>,
    /// The curves on which the markers come in another order than on the target.
    pub reordered: Vec<Doubtful>,
    /// The curves that were followed.
    pub curves: Vec<Vec<CurvePoint>>,
}

impl Marked {
    /// By `markers`, pairs of vertices, and the curves among the options; by `None` and less than three curves, by the
    /// shapes.
    ///
    /// # Errors
    ///
    /// As [`super::fit_correspondence`].
    pub fn of(
        source_side: &Side,
        onto: &Placed,
        markers: Option<&[[u32; 2]]>,
        options: &FitOptions,
        warnings: &mut Vec<String>,
        job: &Job,
    ) -> Result<Self> {
        let (source, target, tolerance) = (source_side.mesh, onto.side.mesh, options.marker_tolerance);
        let found = markers.map(|markers| checked(source, target, markers, options)).transpose()?;
        let found = found.unwrap_or_default();
        let curves = curves::check(source, target, &options.curves)?;
        let places = found.iter().map(|m| (m.rest, m.goal)).chain(curves.iter().map(Curve::centroids));
        let places: Vec<(Vec3, Vec3)> = places.collect();
        let mut doubts = doubtful(&places, tolerance);
        if !options.points.is_empty() {
            warnings.extend(markers::beside(&onto.surface, &found));
        }
        if doubts.scatter > PROPORTIONS.max(tolerance) {
            warnings.push(format!(
                "markers: any of them is {:.0} % of the target's diagonal away from where the others put it: many are \
                 misplaced or exchanged, or the meshes have little in common",
                100.0 * doubts.scatter
            ));
        }
        let by_shapes = match markers {
            Some(_) => None,
            None => Some(alignment::align(
                source,
                target,
                &source_side.masked_vertex,
                &onto.side.masked_vertex,
                options.most_turn,
                job,
            )?),
        };
        // Few curves may bear each other out where the shapes say that they lie elsewhere.
        if let Some(found) = by_shapes.filter(|found| found.certainty >= UNSURE) {
            let off = |i: usize| (i, found.similarity.apply(places[i].0).distance(places[i].1));
            doubts.markers = (0..places.len()).map(off).filter(|&(_, off)| off > ELSEWHERE).collect();
        }
        let kept = |i: usize| tolerance == 0.0 || doubts.markers.iter().all(|d| d.0 != i);
        let kept_of = |numbers: Range<usize>| numbers.filter(|&i| kept(i)).map(|i| places[i]);
        let mut trusted: Vec<_> = kept_of(0..found.len()).collect();
        let mut open = markers::left_open(&trusted);
        if open.is_some() {
            // What markers leave open curves tell; what they do not, a curve that is cut short may tell wrong.
            trusted.extend(kept_of(found.len()..places.len()));
            open = markers::left_open(&trusted);
        }
        let mut lie = match by_shapes.filter(|_| open.is_some()) {
            Some(found) => without_markers(&found, source, tolerance, warnings)?,
            None => {
                warnings.extend(open);
                Lie::of(&trusted, Vec::new(), doubts.scatter)
            }
        };
        let followed: Vec<Marker> = (0..found.len()).filter(|&i| kept(i)).map(|i| found[i]).collect();
        let mut of_curves = Vec::with_capacity(curves.len());
        let mut reordered = Vec::new();
        for (i, curve) in curves.iter().enumerate() {
            let matched = curve.matched(&followed, lie.turn.unwrap_or(Mat3::IDENTITY));
            if matched.is_err() {
                reordered.push(i);
            }
            let matched: Matched = matched.unwrap_or_else(|matched| matched);
            let as_markers = curve.markers(source, &matched);
            of_curves.push((as_markers, curve.places(&matched)));
        }
        let led_by = LedBy {
            markers: found,
            curves: of_curves,
            reordered,
            doubts: doubts.markers,
            astray: Vec::new(),
            exact: tolerance == 0.0,
        };
        lie.markers = led_by.followed();
        lie.by_curves = !led_by.followed_curves().is_empty();
        Ok(Self { lie, led_by })
    }
}

/// Markers by pairs of vertices, or the points among the options.
///
/// # Errors
///
/// [`Error::InvalidConstraint`] for some that cannot be used.
pub fn checked(
    source: &Mesh,
    target: &Mesh,
    markers: &[[u32; 2]],
    options: &FitOptions,
) -> Result<Vec<Marker>> {
    let pairs: Vec<[u32; 2]> =
        markers.iter().map(|&[s, t]| [source.representative(s), target.representative(t)]).collect();
    let unit = |mesh: &Mesh, points: &[Vec3]| -> Vec<Vec3> {
        points.iter().map(|&p| mesh.frame().to_unit(p)).collect()
    };
    let points = [unit(source, &options.source_points), unit(target, &options.points)];
    markers::check(source, target, &pairs, points.each_ref().map(Vec::as_slice))
}

/// How the meshes lie on each other by their shapes alone.
fn without_markers(found: &Found, source: &Mesh, tolerance: f64, warnings: &mut Vec<String>) -> Result<Lie> {
    if found.certainty < GUESSED {
        let problem = "none given, and the meshes have too little in common to lie on each other without: mark at \
                       least three pairs of vertices";
        return Err(Error::InvalidConstraint(Fault::new("markers", problem)));
    }
    if found.certainty < UNSURE {
        warnings.push(format!(
            "markers: none given, and how the meshes lie on each other is {:.0} % sure only: look at the fit, or mark \
             three pairs of vertices",
            100.0 * found.certainty
        ));
    }
    Ok(Lie::by(found, source, tolerance))
}

impl LedBy {
    /// Whether one is followed, counted through markers and curves.
    fn follows(&self, i: usize) -> bool {
        let mut left_out =
            self.doubts.iter().map(|d| d.0).chain(self.astray.iter().map(|d| self.markers.len() + d.0));
        self.exact || left_out.all(|out| out != i)
    }

    /// The markers that are followed, without those of curves.
    pub fn followed_points(&self) -> Vec<Marker> {
        (0..self.markers.len()).filter(|&i| self.follows(i)).map(|i| self.markers[i]).collect()
    }

    /// The numbers of the curves that are followed.
    pub fn followed_curves(&self) -> Vec<usize> {
        (0..self.curves.len()).filter(|&i| self.follows(self.markers.len() + i)).collect()
    }

    /// The markers that a curve is.
    pub fn curve(&self, number: usize) -> &[Marker] {
        &self.curves[number].0
    }

    /// All that is followed.
    pub fn followed(&self) -> Vec<Marker> {
        let curves = self.followed_curves();
        self.followed_points()
            .into_iter()
            .chain(curves.iter().flat_map(|&i| self.curve(i)).copied())
            .collect()
    }

    /// Follows a curve no longer, which is so far `off` by the surfaces.
    pub fn leave_out(&mut self, curve: usize, off: f64) {
        self.astray.push((curve, off));
    }

    /// What became of them with the source's vertices at `x`; `given` are the markers as they were given.
    pub fn told(self, x: &[Vec3], given: Option<&[[u32; 2]]>, tolerance: f64) -> Led {
        let mean = |(markers, _): &(Vec<Marker>, _)| {
            markers.iter().map(|m| m.off(x)).sum::<f64>() / markers.len().max(1) as f64
        };
        let off: [Vec<f64>; 2] =
            [self.markers.iter().map(|m| m.off(x)).collect(), self.curves.iter().map(mean).collect()];
        let count = self.markers.len();
        let of = |i: usize| if i < count { (0, i) } else { (1, i - count) };
        let mut doubtful = [Vec::new(), Vec::new()];
        let met = |i: usize| off[of(i).0][of(i).1] <= MET * tolerance;
        let unmet = self.doubts.iter().copied().filter(|d| self.exact || !met(d.0));
        // What is cut short lies on its like all the same.
        for (i, by) in unmet.chain(self.astray.iter().map(|&(number, by)| (count + number, by))) {
            let (side, number) = of(i);
            let what = if self.exact { "kept, since the tolerance is 0" } else { "left out" };
            let who = match side {
                0 => format!(
                    "markers: number {number} (source vertex {})",
                    given.map_or(0, |given| given[number][0])
                ),
                _ => format!("curves: number {number}"),
            };
            let percent = 100.0 * by;
            let warning = format!(
                "{who} is {percent:.1} % of the target's diagonal away from where the others put it; {what}: look \
                 whether it is out of place or swapped"
            );
            doubtful[side].push(Doubtful { number: number as u32, percent, warning });
        }
        let missed = |i: &usize| !self.exact && self.follows(*i) && !met(*i);
        let unmet = (count..count + self.curves.len()).filter(missed).map(|i| {
            let (number, percent) = (i - count, 100.0 * off[1][i - count]);
            let warning = format!(
                "curves: number {number} is met within {percent:.1} % of the target's diagonal only: look whether it is \
                 the same one on both meshes"
            );
            Doubtful { number: number as u32, percent, warning }
        });
        let unmet = unmet.collect();
        let reordered = self.reordered.iter().map(|&number| {
            let warning = format!(
                "curves: number {number}: the markers on it come in another order on the target, so that it is matched \
                 by its length alone: look whether any are swapped"
            );
            Doubtful { number: number as u32, percent: 100.0 * off[1][number], warning }
        });
        let reordered = reordered.collect();
        let curves = self.followed_curves().into_iter().map(|i| self.curves[i].1.clone()).collect();
        Led { off, doubtful, unmet, reordered, curves }
    }
}
