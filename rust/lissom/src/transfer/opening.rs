//! Opening: what lies between rims ([`super::rims`]), and closes in a key.
//!
//! ```text
//!     D' = r Q S'        S, D = from one place to the other at rest, on the source and on the target
//!                        S'   = the same on the source once the key is on
//!                        r    = |D| / |S|, where they touch the size of the target over that of the source
//!                        Q    = the least rotation from S to D
//! ```
//!
//! A lid that goes over half its opening on the source does so on the target, whatever the height of its eye, and
//! one that goes over the other goes over it by the same part of the opening. Openings that are as high as the
//! target's size makes them close so by the gradients alone, and are left to these; between the two `D'` goes over
//! from `D + s (S' - S)`, with `s` the size, sooner where the source's places come to touch.

use std::collections::BTreeMap;

use super::choose::SourceKey;
use super::contact::{Contact, mass};
use super::touching::{Touching, at_place};
use crate::mesh::Paths;
use crate::{Mesh, Quat, Vec3};

/// An opening of the target that is so many times as wide or narrow, against the size of both, is another one.
const MOST_TIMES: f64 = 10.0;

/// It lies the same way on both, by the cosine.
const SAME_WAY: f64 = 0.3;

/// An opening closes from the first part of its way on, which all but few of its rims have not gone further than, and wholly
/// from the second: what nears less is led by the gradients.
const NEARING: [f64; 2] = [0.1, 0.2];
const MOST: f64 = 0.9;

/// Each rim counts from the first part of what most of them have gone on, and wholly from the second.
const CLOSING: [f64; 2] = [0.5, 0.9];

/// What is so near to each other, a fraction of the source's diagonal, touches: it does so on the target, as lids are not as
/// thick as their eye is high. From twice that on there is an opening.
const TOUCHING: f64 = 0.005;

/// An opening is as high as the target's size makes it within the first of these factors, either way, and on its own from
/// the second: while its sides stay apart, and where they come to touch. Eyes of the ICT identities
/// differ by 5 %.
const ALIKE: [f64; 2] = [1.2, 1.4];
const ALIKE_TOUCHING: [f64; 2] = [1.06, 1.15];

/// What touches has gone on so much of its way: wholly from the second.
const TOUCHED: [f64; 2] = [0.5, 0.8];

/// So far, a fraction of the source's diagonal, it is along its edges around an opening from one side to the other: around
/// eyes 0.1, and between the paws of a cat half of it.
const AROUND: f64 = 0.3;

/// Closing along less than this, a part of the target's diagonal, is a chance touch; both lids of an eye have 0.3.
pub const BRUSHED: f64 = 0.1;

/// A place on the source: the corners of a triangle, and what each counts.
pub type Place = ([u32; 3], Vec3);

/// A target vertex and the place across.
pub struct Rim {
    pub vertex: u32,
    /// Target vertices and what each counts there; they add up to 1.
    pub place: Vec<(u32, f64)>,
    /// The images of both.
    pub images: [Place; 2],
    /// `S` and `D`.
    across: [Vec3; 2],
    /// Of the target over that of the source.
    size: f64,
}

impl Rim {
    /// `None` where the two lie otherwise on the target, `size` times as large, than `from` here to there on the source.
    pub fn new(
        target: &Mesh,
        vertex: u32,
        place: Vec<(u32, f64)>,
        images: [Place; 2],
        from: Vec3,
        size: f64,
    ) -> Option<Self> {
        let at = |v: u32| target.rest()[v as usize];
        let across = place.iter().map(|&(v, weight)| at(v) * weight).sum::<Vec3>() - at(vertex);
        let times = across.length() / (from.length() * size);
        let same = across.dot(from) > SAME_WAY * from.length() * across.length();
        let known = same && times > 1.0 / MOST_TIMES && times < MOST_TIMES;
        known.then_some(Self { vertex, place, images, across: [from, across], size })
    }

    /// From one place to the other on the source once a key is on.
    fn posed(&self, key: &SourceKey) -> Vec3 {
        let [here, there] = self.images.each_ref().map(|image| at_place(image, &key.displacement));
        self.across[0] + there - here
    }

    /// What it asks for where the two have come to be `posed` and `touching`, by what part its height is its `own`,
    /// and counts by `weight`.
    fn contact(&self, target: &Mesh, posed: Vec3, touching: f64, own: f64, weight: f64) -> Contact {
        let [from, to] = self.across;
        let opening = to.length() / from.length();
        let turned = Quat::from_rotation_arc(from.normalize(), to.normalize()) * posed;
        let by_height = turned * (opening + (self.size - opening) * touching);
        let gap = (to + (posed - from) * self.size).lerp(by_height, own);
        Contact::across(target, self.vertex, self.place.clone(), gap, weight)
    }
}

/// What part of its height is an opening's own, and not what the target's size makes of the source's.
#[derive(Debug, Clone, Copy)]
pub struct Own {
    /// While its sides stay apart.
    pub apart: f64,
    /// Where they come to touch.
    pub touching: f64,
}

impl Own {
    /// All of it.
    pub const ALL: Self = Self { apart: 1.0, touching: 1.0 };

    /// Of an opening between these rims, whose source has these `paths`.
    pub fn of(source: &Mesh, target: &Mesh, paths: &Paths, rims: &[Rim]) -> Self {
        let height = |of: fn(&Rim) -> f64| -> f64 {
            rims.iter().map(|rim| mass(target, rim.vertex).sqrt() * of(rim)).sum()
        };
        let by_size = height(|rim| rim.size * rim.across[0].length());
        let times = (height(|rim| rim.across[1].length()) / by_size).ln().abs();
        let own = |factors: [f64; 2]| smooth(times, factors.map(f64::ln));
        let found = Self { apart: own(ALIKE), touching: own(ALIKE_TOUCHING) };
        let is_one = || rims.first().is_some_and(|rim| is_around(source, paths, rim));
        if found.touching > 0.0 && is_one() { found } else { Self { apart: 0.0, touching: 0.0 } }
    }
}

/// Whether a short way along edges leads around an opening from one side to the other: between limbs there is none.
fn is_around(source: &Mesh, paths: &Paths, rim: &Rim) -> bool {
    let mut distances = vec![f64::INFINITY; source.rest().len()];
    let [here, there] = rim.images.map(|image| image.0);
    paths.shorten(&mut distances, here.map(|v| (v, 0.0)), AROUND, |_| {});
    there.iter().any(|&v| distances[v as usize].is_finite())
}

/// Rims that hang together, as those of both lids do, and what touches around them.
pub struct Opening {
    /// By vertex.
    pub rims: Vec<Rim>,
    pub touching: Touching,
    pub own: Own,
}

impl Opening {
    /// What its rims ask for in a key where so much of its height is its `own`, by vertex of the target.
    pub fn closing(&self, target: &Mesh, key: &SourceKey, own: Own) -> BTreeMap<u32, Contact> {
        let posed: Vec<Vec3> = self.rims.iter().map(|rim| rim.posed(key)).collect();
        let nearing = |(rim, posed): (&Rim, &Vec3)| 1.0 - posed.length() / rim.across[0].length();
        let nearing: Vec<f64> = self.rims.iter().zip(&posed).map(nearing).collect();
        let mut sorted = nearing.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let most = sorted[(MOST * (sorted.len() - 1) as f64) as usize].min(1.0);
        let closes = smooth(most, NEARING);
        if closes == 0.0 {
            return BTreeMap::new();
        }
        let contact = |((rim, nearing), posed): ((&Rim, &f64), &Vec3)| {
            let touching = (2.0 - posed.length() / TOUCHING).clamp(0.0, 1.0);
            let own = own.apart.max(own.touching * touching * smooth(*nearing, TOUCHED));
            let weight = own * closes * smooth(*nearing, CLOSING.map(|part| part * most));
            (weight > 0.0).then(|| (rim.vertex, rim.contact(target, *posed, touching, own, weight)))
        };
        let found: BTreeMap<u32, Contact> =
            self.rims.iter().zip(&nearing).zip(&posed).filter_map(contact).collect();
        let along: f64 = found.values().map(Contact::length).sum();
        if along > BRUSHED { found } else { BTreeMap::new() }
    }
}

/// From 0 at the first of two values to 1 at the second.
fn smooth(value: f64, [from, to]: [f64; 2]) -> f64 {
    let part = ((value - from) / (to - from)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}
