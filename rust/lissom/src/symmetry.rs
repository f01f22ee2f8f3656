//! Meshes that are their own mirror image: by their shape, or because their images are added.

use crate::geometry::frame::UnitFrame;
use crate::geometry::plane::{Plane, tree, twins};
use crate::{Error, Fault, Mesh, Result, Vec3};

/// How many of the vertices must have twins.
const MOST: f64 = 0.9;

/// The planes that a mesh is symmetric about, and the vertices that are each other's mirror images.
#[derive(Debug, Default, Clone)]
pub struct Symmetry {
    planes: Vec<Plane>,
    /// For each plane the twin of every vertex; itself for one that stays on the plane.
    twins: Vec<Vec<Option<u32>>>,
    /// Added vertices: which earlier one each is the image of, and across which plane.
    images: Vec<(u32, usize)>,
}

impl Symmetry {
    /// A mesh with its mirror images, as one mesh, whose first vertices and triangles are those of `mesh`. Vertices that
    /// are within `tolerance` (of the first shape's diagonal) of their image in all `shapes` are joined with it; a plane that
    /// joins nothing adds nothing.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidMesh`] where points coincide.
    ///
    /// # Panics
    ///
    /// Where there is no shape, or one has not as many vertices as `mesh`.
    pub fn completed(
        mesh: &Mesh,
        shapes: &[&[Vec3]],
        planes: &[Plane],
        tolerance: f64,
    ) -> Result<(Mesh, Self)> {
        let within = 0.5 * tolerance * UnitFrame::of(shapes[0], mesh.triangles())?.scale;
        let mut symmetry = Self::default();
        let mut shapes: Vec<Vec<Vec3>> = shapes.iter().map(|shape| shape.to_vec()).collect();
        let (mut triangles, mut ids) = (mesh.triangles().to_vec(), mesh.triangle_ids().to_vec());
        let mut welds: Vec<u32> = (0..shapes[0].len() as u32).map(|v| mesh.representative(v)).collect();
        for &plane in planes {
            let joined = |&v: &u32| shapes.iter().all(|x| plane.height(x[v as usize]).abs() <= within);
            let joined: Vec<bool> = welds.iter().map(joined).collect();
            if !triangles.iter().flatten().any(|&v| joined[v as usize]) {
                continue;
            }
            let count = welds.len() as u32;
            let added: Vec<u32> = (0..count).filter(|&v| !joined[v as usize]).collect();
            let mut image: Vec<u32> = (0..count).collect();
            added.iter().zip(count..).for_each(|(&v, w)| image[v as usize] = w);
            for twins in &mut symmetry.twins {
                let across = |&v: &u32| twins[v as usize].map(|w| image[w as usize]);
                twins.extend(added.iter().map(across).collect::<Vec<_>>());
            }
            symmetry.twins.push(image.iter().chain(&added).map(|&v| Some(v)).collect());
            symmetry.images.extend(added.iter().map(|&v| (v, symmetry.planes.len())));
            symmetry.planes.push(plane);
            for shape in &mut shapes {
                shape.extend(added.iter().map(|&v| plane.image(shape[v as usize])).collect::<Vec<_>>());
            }
            welds.extend(added.iter().map(|&v| image[welds[v as usize] as usize]).collect::<Vec<_>>());
            // What lies in the plane is its own image.
            let apart = |&t: &usize| triangles[t].iter().any(|&v| !joined[v as usize]);
            let apart: Vec<usize> = (0..triangles.len()).filter(apart).collect();
            ids.extend(apart.iter().map(|&t| ids[t]).collect::<Vec<_>>());
            let turned = |&t: &usize| {
                let [a, b, c] = triangles[t].map(|v| image[v as usize]);
                [a, c, b]
            };
            triangles.extend(apart.iter().map(turned).collect::<Vec<_>>());
        }
        let vertices = symmetry.spread(mesh.vertices());
        Ok((mesh.extended(vertices, triangles, ids, welds)?, symmetry))
    }

    /// Adds planes that `mesh` is symmetric about as it is; vertices within `tolerance` (of the diagonal) of each other's
    /// mirror image are twins.
    ///
    /// # Errors
    ///
    /// [`Error::InvalidValue`] by the name `argument` where most vertices have no twin.
    pub fn add(&mut self, argument: &str, mesh: &Mesh, planes: &[Plane], tolerance: f64) -> Result<()> {
        let mut used = vec![false; mesh.rest().len()];
        mesh.triangles().iter().flatten().for_each(|&v| used[v as usize] = true);
        let used: Vec<u32> = (0..used.len() as u32).filter(|&v| used[v as usize]).collect();
        let points: Vec<Vec3> = used.iter().map(|&v| mesh.rest()[v as usize]).collect();
        let tree = tree(&points);
        for &plane in planes {
            let unit = Plane { point: mesh.frame().to_unit(plane.point), ..plane };
            let found = twins(&tree, &points, &unit, tolerance);
            let without =
                found.iter().zip(&used).filter(|(twin, _)| twin.is_none()).map(|(_, &v)| v as usize);
            let problem = "the mesh is not symmetric: vertices without a mirror image on the other side";
            let few = (found.iter().flatten().count() as f64) < MOST * found.len() as f64;
            if let Some(fault) = Fault::at(argument, problem, without).filter(|_| few) {
                return Err(Error::InvalidValue(fault));
            }
            let mut twins = vec![None; mesh.rest().len()];
            for (&v, twin) in used.iter().zip(found) {
                twins[v as usize] = twin.map(|i| used[i as usize]);
            }
            let on_plane = |&(_, w): &(u32, u32)| twins[w as usize] == Some(w);
            let welded: Vec<(u32, u32)> = mesh.welds().filter(on_plane).collect();
            welded.into_iter().for_each(|(v, _)| twins[v as usize] = Some(v));
            self.planes.push(plane);
            self.twins.push(twins);
        }
        Ok(())
    }

    /// The planes, each with the twins of all vertices.
    pub fn planes(&self) -> impl ExactSizeIterator<Item = (&Plane, &[Option<u32>])> {
        self.planes.iter().zip(self.twins.iter().map(Vec::as_slice))
    }

    /// Positions of the added vertices after those of the mesh.
    pub fn spread(&self, own: &[Vec3]) -> Vec<Vec3> {
        let mut all = own.to_vec();
        all.reserve(self.images.len());
        self.images.iter().for_each(|&(v, plane)| all.push(self.planes[plane].image(all[v as usize])));
        all
    }

    /// That of the vertices of a part, which `whole` lists by their index in the whole.
    pub fn of_part(&self, whole: &[u32]) -> Self {
        let of = |twins: &Vec<Option<u32>>| {
            let mut place = vec![None; twins.len()];
            whole.iter().zip(0..).for_each(|(&v, i)| place[v as usize] = Some(i));
            whole.iter().map(|&v| place[twins[v as usize]? as usize]).collect()
        };
        Self { planes: self.planes.clone(), twins: self.twins.iter().map(of).collect(), images: Vec::new() }
    }

    /// Displacements as the mean of themselves and their mirror images: on a plane, nothing across it is left.
    pub fn symmetrise(&self, displacements: &mut [Vec3]) {
        self.average(displacements, Plane::reflect);
    }

    /// The same of rotation vectors and torques, whose mirror images turn the other way: on a plane, what turns about the
    /// normal is left.
    pub fn symmetrise_turns(&self, turns: &mut [Vec3]) {
        self.average(turns, |plane, turn| -plane.reflect(turn));
    }

    fn average(&self, values: &mut [Vec3], image: impl Fn(&Plane, Vec3) -> Vec3) {
        for (plane, twins) in self.planes() {
            for (v, twin) in twins.iter().enumerate() {
                if let Some(w) = twin.map(|w| w as usize).filter(|&w| v <= w) {
                    let mean = (values[v] + image(plane, values[w])) * 0.5;
                    values[w] = image(plane, mean);
                    values[v] = mean;
                }
            }
        }
    }
}
