//! How the source lies on the target before anything bends, by markers or by the shapes alone.

use super::markers::Marker;
use crate::geometry::rigid::{self, Alignment};
use crate::transfer::alignment::Found;
use crate::{Mat3, Mesh, Vec3, rotation};

/// Turns below are within what heads of the same bearing, marked by hand or laid on each other, seem to be turned by.
const WORTH_DEGREES: f64 = 5.0;

/// By a fitted surface alone keys turn along in full from so many degrees beyond on: a part of a head, half a face, seems
/// to be turned by as much.
const ALL_BEYOND: f64 = 2.5;

/// Fewer markers and curves, and shapes alone, tell the turn less exactly than the fitted surface does: three on a face are
/// off by 5 to 8 degrees, it is by 1 or 2.
const SURE: usize = 6;

/// A similarity, and the markers that it comes from.
pub struct Lie {
    /// Those to follow.
    pub markers: Vec<Marker>,
    /// Whether curves lead, or the fit is what those that may lead astray are judged by.
    pub by_curves: bool,
    /// How far they are off, in the target's unit coordinates.
    pub scatter: f64,
    /// The rotation of the source to the target, where it is determined and worth taking out.
    pub turn: Option<Mat3>,
    /// From the source's unit coordinates to the target's.
    pub size: f64,
    /// What is to be added to the source, once turned and scaled.
    pub shift: Vec3,
    /// 0-1; 1 by markers.
    pub certainty: f64,
    /// Whether it comes from so many places that these tell the turn.
    is_sure: bool,
}

impl Lie {
    /// By places of the source and where these belong, which are `scatter` off; `markers` are to be followed.
    pub fn of(places: &[(Vec3, Vec3)], markers: Vec<Marker>, scatter: f64) -> Self {
        let alignment = Alignment::of(places.iter().copied());
        let determined = places.len() >= 3 && alignment.is_determined();
        let turn = Some(alignment.rotation()).filter(|&turn| determined && is_worth(turn));
        let size = rigid::size_ratio(places.iter().map(|p| p.1), places.iter().map(|p| p.0));
        let (from, to) = alignment.centroids();
        let shift = to - turn.unwrap_or(Mat3::IDENTITY) * from * size;
        let (certainty, is_sure) = (1.0, places.len() >= SURE);
        Self { markers, by_curves: false, scatter, turn, size, shift, certainty, is_sure }
    }

    /// The rotation by which keys turn along, with the source's vertices fitted to `x`, some of which `lie_on` the target:
    /// the others tell nothing. By a fit `with_modes` it is surer than by a surface alone.
    pub fn settled_turn(
        &self,
        source: &Mesh,
        x: &[Vec3],
        lie_on: impl Fn(usize) -> bool,
        with_modes: bool,
    ) -> Mat3 {
        if self.is_sure {
            return self.turn.unwrap_or(Mat3::IDENTITY);
        }
        let told = source.rest().iter().zip(x).enumerate().filter(|(v, _)| lie_on(*v));
        let alignment = Alignment::of(told.map(|(_, (&from, &to))| (from, to)));
        if !alignment.is_determined() {
            return self.turn.unwrap_or(Mat3::IDENTITY);
        }
        let turn = alignment.rotation();
        if !is_worth(turn) {
            return Mat3::IDENTITY;
        }
        if with_modes {
            return turn;
        }
        let log = rotation::log(turn);
        rotation::exp(log * ((log.length().to_degrees() - WORTH_DEGREES) / ALL_BEYOND).min(1.0))
    }

    /// By the shapes of `source` and target; what is yet to be followed is `scatter` off.
    pub fn by(found: &Found, source: &Mesh, scatter: f64) -> Self {
        let turn = Some(found.rotation).filter(|&turn| is_worth(turn));
        let centre = rigid::centroid(source.rest().iter().copied());
        let turned = turn.unwrap_or(Mat3::IDENTITY) * centre;
        let shift = found.similarity.apply(centre) - turned * found.scale;
        let (size, certainty) = (found.scale, found.certainty);
        Self { markers: Vec::new(), by_curves: false, scatter, turn, size, shift, certainty, is_sure: false }
    }
}

/// Whether a rotation is worth taking out.
pub fn is_worth(turn: Mat3) -> bool {
    rotation::log(turn).length().to_degrees() > WORTH_DEGREES
}
