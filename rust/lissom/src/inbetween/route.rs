//! A path through more than two shapes: one [`Inbetween`] from each to the next.
//!
//! All shapes are hit exactly. In between each leg has a path of its own, so speed may change from one leg to the next.

use std::sync::Arc;

use super::keyframes::Keyframes;
use super::options::InbetweenOptions;
use super::path::Inbetween;
use super::shapes::shape_frame;
use crate::geometry::plane::expect_perpendicular;
use crate::symmetry::Symmetry;
use crate::{Error, Fault, Job, Mesh, Result, Vec3};

/// A path through a list of shapes.
#[derive(Debug)]
pub struct Route {
    /// The times of the shapes, from 0 to 1.
    knots: Vec<f64>,
    legs: Vec<Inbetween>,
    /// Where half shapes were completed: how, and all of the whole ones.
    mirrored: Option<(Symmetry, Vec<Vec<Vec3>>)>,
    /// Vertices that the caller knows of.
    own: usize,
}

impl Route {
    /// Prepares the path from `start` through shapes at ascending times to `end`.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for times of `through` that do not ascend between 0 and 1; as [`Inbetween::new`].
    pub fn new(
        mesh: &Arc<Mesh>,
        start: &[Vec3],
        end: &[Vec3],
        through: &[(f64, Vec<Vec3>)],
        options: &InbetweenOptions,
        job: &Job,
    ) -> Result<Self> {
        let mut knots = vec![0.0];
        knots.extend(through.iter().map(|(t, _)| *t));
        knots.push(1.0);
        let late = (1..=through.len()).filter(|&k| !(knots[k - 1] < knots[k] && knots[k] < 1.0));
        if let Some(fault) =
            Fault::at("through", "times that do not ascend between 0 and 1", late.map(|k| k - 1))
        {
            return Err(Error::InvalidValue(fault));
        }
        if options.clearance_end.is_some() && !through.is_empty() {
            let problem = "an obstacle that moves and shapes to go through do not go together";
            return Err(Error::InvalidValue(Fault::new("clearance_end", problem)));
        }
        let mut stops: Vec<Vec<Vec3>> = vec![start.to_vec()];
        stops.extend(through.iter().map(|(_, shape)| shape.clone()));
        stops.push(end.to_vec());
        let last = through.len();
        let mut mirrored = None;
        let mut whole = mesh.clone();
        if !options.mirror.is_empty() {
            expect_perpendicular("mirror", &options.mirror)?;
            for (k, stop) in stops.iter().enumerate() {
                let frame = shape_frame("start", mesh, stop);
                frame.map_err(
                    |error| if k > last { error.renamed("end") } else { name_stops(error, k, last) },
                )?;
            }
            let shapes: Vec<&[Vec3]> = stops.iter().map(Vec::as_slice).collect();
            let (completed, symmetry) =
                Symmetry::completed(mesh, &shapes, &options.mirror, options.mirror_tolerance)?;
            stops = stops.iter().map(|stop| symmetry.spread(stop)).collect();
            whole = Arc::new(completed);
            mirrored = Some((symmetry, stops.clone()));
        }
        let legs = (stops.windows(2).enumerate())
            .map(|(k, ends)| {
                let leg = Inbetween::new(whole.clone(), &ends[0], &ends[1], options.clone(), job);
                leg.map_err(|error| name_stops(error, k, last))
            })
            .collect::<Result<_>>()?;
        Ok(Self { knots, legs, mirrored, own: mesh.vertices().len() })
    }

    /// What is doubtful, of all legs.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings: Vec<String> = Vec::new();
        for warning in self.legs.iter().flat_map(Inbetween::warnings) {
            if !warnings.contains(warning) {
                warnings.push(warning.clone());
            }
        }
        warnings
    }

    /// Positions at each of `times`, as [`Inbetween::at`].
    ///
    /// # Errors
    ///
    /// As [`Inbetween::at`].
    pub fn at(&self, times: &[f64], job: &Job) -> Result<Vec<Vec<Vec3>>> {
        Inbetween::check_times(times)?;
        let mut shapes = vec![Vec::new(); times.len()];
        for (k, leg) in self.legs.iter().enumerate() {
            let (from, to) = (self.knots[k], self.knots[k + 1]);
            let here: Vec<usize> = (0..times.len())
                .filter(|&i| times[i] >= from && (times[i] < to || (to == 1.0 && times[i] <= 1.0)))
                .collect();
            let own: Vec<f64> = here.iter().map(|&i| ((times[i] - from) / (to - from)).min(1.0)).collect();
            for ((i, &s), mut shape) in here.into_iter().zip(&own).zip(leg.at(&own, job)?) {
                self.halve(k, s, &mut shape);
                shapes[i] = shape;
            }
        }
        Ok(shapes)
    }

    /// Leaves the caller's own vertices of a whole shape at the time `t` of a leg, none of them across a plane that they
    /// lie on at both ends.
    fn halve(&self, leg: usize, t: f64, shape: &mut Vec<Vec3>) {
        if let Some((symmetry, stops)) = &self.mirrored
            && t > 0.0
            && t < 1.0
        {
            let line = stops[leg].iter().zip(&stops[leg + 1]).map(|(&p, &q)| p + (q - p) * t);
            let line: Vec<Vec3> = line.collect();
            let mut off: Vec<Vec3> = shape.iter().zip(&line).map(|(&x, &p)| x - p).collect();
            symmetry.symmetrise(&mut off);
            *shape = line.into_iter().zip(off).map(|(p, d)| p + d).collect();
        }
        shape.truncate(self.own);
    }

    /// The fewest times, those of all shapes among them, as [`Inbetween::keyframes`].
    ///
    /// # Errors
    ///
    /// As [`Inbetween::keyframes`]; [`Error::InvalidValue`] for fewer keys than shapes.
    pub fn keyframes(&self, tolerance: f64, max_keys: usize, job: &Job) -> Result<Keyframes> {
        if let [leg] = &self.legs[..] {
            return leg.keyframes(tolerance, max_keys, job);
        }
        self.check_count("max_keys", max_keys)?;
        let legs = self.legs.iter().map(|leg| leg.keyframes(tolerance, max_keys, job));
        let joined = self.join(&legs.collect::<Result<Vec<_>>>()?);
        if joined.times.len() <= max_keys && joined.warnings.is_empty() {
            return Ok(joined);
        }
        let mut best = self.keyframes_by_count(max_keys, job)?;
        best.warnings.push(format!("max_keys: {max_keys} keys leave an error of {:.3e}", best.error));
        Ok(best)
    }

    /// The `count` times with the least error, as [`Inbetween::keyframes_by_count`]. The leg with the largest error gets the
    /// next key: more keys never raise a leg's error, so no other share has a smaller one.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] for fewer keys than shapes.
    pub fn keyframes_by_count(&self, count: usize, job: &Job) -> Result<Keyframes> {
        if let [leg] = &self.legs[..] {
            return leg.keyframes_by_count(count, job);
        }
        self.check_count("count", count)?;
        // As fine as for the most keys that a leg can get.
        let most = count - self.legs.len() + 1;
        let sampled = self.legs.iter().map(|leg| leg.sampled_for(most, job)).collect::<Result<Vec<_>>>()?;
        let mut legs = sampled.iter().map(|leg| leg.keyframes(2, job)).collect::<Result<Vec<_>>>()?;
        for _ in self.knots.len()..count {
            let worst = (0..legs.len()).max_by(|&i, &j| legs[i].error.total_cmp(&legs[j].error));
            let Some(worst) = worst.filter(|&k| !sampled[k].is_met_by(legs[k].error)) else { break };
            legs[worst] = sampled[worst].keyframes(legs[worst].times.len() + 1, job)?;
        }
        Ok(self.join(&legs))
    }

    fn check_count(&self, argument: &str, count: usize) -> Result<()> {
        if count >= self.knots.len() {
            return Ok(());
        }
        let problem = format!("less than {}: every shape is a key", self.knots.len());
        Err(Error::InvalidValue(Fault::new(argument, problem)))
    }

    fn join(&self, legs: &[Keyframes]) -> Keyframes {
        let mut times = vec![0.0];
        for (k, leg) in legs.iter().enumerate() {
            let (from, to) = (self.knots[k], self.knots[k + 1]);
            times.extend(leg.times[1..leg.times.len() - 1].iter().map(|t| from + (to - from) * t));
            times.push(to);
        }
        Keyframes {
            times,
            error: legs.iter().map(|leg| leg.error).fold(0.0, f64::max),
            warnings: legs.iter().flat_map(|leg| leg.warnings.clone()).collect(),
        }
    }
}

/// The start and end of a leg by the caller's names for them.
fn name_stops(error: Error, leg: usize, last: usize) -> Error {
    let Error::InvalidValue(mut fault) = error else { return error };
    match fault.argument.as_str() {
        "start" if leg > 0 => fault.argument = format!("through[{}]", leg - 1),
        "end" if leg < last => fault.argument = format!("through[{leg}]"),
        _ => {}
    }
    Error::InvalidValue(fault)
}
