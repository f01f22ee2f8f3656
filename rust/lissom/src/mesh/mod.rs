//! A triangle mesh, validated once; everything else may rely on it.

mod adjacency;
mod components;
mod distance;
mod linings;
mod orientation;
pub(crate) mod validate;
mod weld;

pub use crate::geometry::frame::UnitFrame;
pub use crate::geometry::plane::Plane;
pub use adjacency::{Adjacency, Corner, HalfEdge};
pub use components::Components;
pub(crate) use distance::Paths;

use crate::geometry::triangle::TriangleGeometry;
use crate::{Error, Fault, Job, Mat3, Result, Vec3};

/// A validated triangle mesh with its adjacency and geometry.
///
/// Immutable and cheap to share behind an `Arc`.
#[derive(Debug, Clone)]
pub struct Mesh {
    vertices: Vec<Vec3>,
    frame: UnitFrame,
    diagonal: f64,
    rest: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    triangle_ids: Vec<u32>,
    input_triangles: usize,
    /// Vertices from here on are mirror images, of which the caller does not know.
    images_from: usize,
    adjacency: Adjacency,
    components: Components,
    geometry: TriangleGeometry,
    /// For each vertex the one that it is welded to, which may be itself; empty where none is.
    welds: Vec<u32>,
    warnings: Vec<String>,
}

impl Mesh {
    /// Checks and prepares a mesh of `vertices` (any units) and `triangles` (vertex indices, counted
    /// from 0).
    ///
    /// Triangles that repeat a vertex are left out, slivers are mollified; [`Mesh::warnings`] tells.
    ///
    /// # Errors
    ///
    /// [`crate::Error::InvalidMesh`] for no vertices or triangles, indices out of range, values that
    /// are not finite, and points that are all coincident or collinear.
    pub fn new(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self> {
        Self::welded(vertices, triangles, None)
    }

    /// The same, with vertices within `weld` of each other, in the mesh's own units, as one: that is where a
    /// surface has seams, or is stored triangle by triangle. Their number and order stay as they are.
    ///
    /// # Errors
    ///
    /// As [`Mesh::new`], and [`crate::Error::InvalidValue`] for a distance that is negative or not finite.
    pub fn welded(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>, weld: Option<f64>) -> Result<Self> {
        validate::numbers(&vertices, &triangles)?;
        if weld.is_some_and(|distance| !(distance >= 0.0 && distance.is_finite())) {
            return Err(Error::InvalidValue(Fault::new("weld", "must be a distance of 0 or more")));
        }
        let mut warnings = Vec::new();
        let (triangles, welds) = validate::seams(&vertices, triangles, weld, &mut warnings);
        let input_triangles = triangles.len();
        let (triangles, triangle_ids) = validate::drop_repeating(triangles, &mut warnings)?;
        let frame = UnitFrame::of(&vertices, &triangles)?;
        let rest: Vec<Vec3> = vertices.iter().map(|&v| frame.to_unit(v)).collect();
        validate::refuse_collinear(&rest, &triangles)?;
        let (adjacency, (components, geometry)) = rayon::join(
            || Adjacency::of(vertices.len(), &triangles),
            || (Components::of(vertices.len(), &triangles), TriangleGeometry::of(&rest, &triangles)),
        );
        validate::doubts(&adjacency, &triangles, &triangle_ids, &geometry, &welds, &mut warnings);
        Ok(Self {
            images_from: vertices.len(),
            vertices,
            frame,
            diagonal: diagonal(&rest, &triangles, &geometry.areas),
            rest,
            triangles,
            triangle_ids,
            input_triangles,
            adjacency,
            components,
            geometry,
            welds,
            warnings,
        })
    }

    /// The mesh turned by a rotation about the centre of its unit coordinates.
    pub(crate) fn turned(&self, turn: Mat3) -> Self {
        self.reshaped(self.rest.iter().map(|&p| turn * p).collect())
    }

    /// The triangles to turn so that each part that hangs together by edges is wound alike, as most of its area is, and
    /// then the other way if the mesh is `inside_out`.
    pub(crate) fn against(&self, inside_out: bool) -> Vec<bool> {
        let against = orientation::against_most(&self.triangles, &self.adjacency, &self.geometry.areas);
        against.into_iter().map(|against| against != inside_out).collect()
    }

    /// The mesh with some of its triangles wound the other way.
    pub(crate) fn turned_over(&self, over: &[bool]) -> Self {
        let triangles = orientation::turn(&self.triangles, over);
        let adjacency = Adjacency::of(self.vertices.len(), &triangles);
        let geometry = TriangleGeometry::of(&self.rest, &triangles);
        Self { adjacency, geometry, triangles, ..self.clone() }
    }

    /// The part of a mesh that some of its triangles make up, in the unit coordinates of the whole.
    ///
    /// `whole` lists its vertices by their index in the whole, `triangles` indexes into `whole`.
    pub(crate) fn part(&self, whole: &[u32], triangles: Vec<[u32; 3]>) -> Self {
        let rest: Vec<Vec3> = whole.iter().map(|&v| self.rest[v as usize]).collect();
        Self {
            vertices: whole.iter().map(|&v| self.vertices[v as usize]).collect(),
            frame: self.frame,
            diagonal: self.diagonal,
            triangle_ids: (0..triangles.len() as u32).collect(),
            input_triangles: triangles.len(),
            images_from: whole.len(),
            adjacency: Adjacency::of(whole.len(), &triangles),
            components: Components::of(whole.len(), &triangles),
            geometry: TriangleGeometry::of(&rest, &triangles),
            rest,
            triangles,
            welds: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// The mesh with mirror images after its own vertices and triangles.
    pub(crate) fn extended(
        &self,
        vertices: Vec<Vec3>,
        triangles: Vec<[u32; 3]>,
        triangle_ids: Vec<u32>,
        welds: Vec<u32>,
    ) -> Result<Self> {
        let frame = UnitFrame::of(&vertices, &triangles)?;
        let rest: Vec<Vec3> = vertices.iter().map(|&v| frame.to_unit(v)).collect();
        let geometry = TriangleGeometry::of(&rest, &triangles);
        Ok(Self {
            frame,
            diagonal: diagonal(&rest, &triangles, &geometry.areas),
            triangle_ids,
            input_triangles: self.input_triangles,
            images_from: self.vertices.len(),
            adjacency: Adjacency::of(vertices.len(), &triangles),
            components: Components::of(vertices.len(), &triangles),
            geometry,
            vertices,
            rest,
            triangles,
            welds,
            warnings: self.warnings.clone(),
        })
    }

    /// The same triangles on other rest positions, in the same unit coordinates.
    pub(crate) fn reshaped(&self, rest: Vec<Vec3>) -> Self {
        let vertices = rest.iter().map(|&p| self.frame.from_unit(p)).collect();
        let geometry = TriangleGeometry::of(&rest, &self.triangles);
        Self { vertices, geometry, rest, ..self.clone() }
    }

    /// Positions as given, in the mesh's own units.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// The vertex that triangles use in the place of this one: itself, but for one that is welded to another.
    pub fn representative(&self, vertex: u32) -> u32 {
        self.welds.get(vertex as usize).copied().unwrap_or(vertex)
    }

    /// The vertices that are welded to another, with that one.
    pub fn welds(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        (0u32..).zip(self.welds.iter().copied()).filter(|(v, w)| v != w)
    }

    /// Gives every vertex that is welded to another what that one has.
    pub fn follow<T: Copy>(&self, values: &mut [T]) {
        self.welds().for_each(|(v, w)| values[v as usize] = values[w as usize]);
    }

    /// Whether another mesh has the same faces in the same order.
    pub fn is_like(&self, other: &Self) -> bool {
        self.vertices().len() == other.vertices().len()
            && self.triangles() == other.triangles()
            && self.triangle_ids() == other.triangle_ids()
    }

    /// Whether a vertex was added as a mirror image: nothing to speak of to the caller.
    pub fn is_mirror_image(&self, vertex: usize) -> bool {
        vertex >= self.images_from
    }

    /// Positions in unit coordinates.
    pub fn rest(&self) -> &[Vec3] {
        &self.rest
    }

    /// The map between the mesh's own units and unit coordinates.
    pub fn frame(&self) -> UnitFrame {
        self.frame
    }

    /// What options call the diagonal of the mesh, in unit coordinates: the square root of 12 times the radius of gyration
    /// of its surface. For a rectangle it is the diagonal, for a sphere that of its box, and unlike a box's it is the
    /// same however the mesh lies.
    pub fn diagonal(&self) -> f64 {
        self.diagonal
    }

    /// The triangles in use: those that do not repeat a vertex.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// For each triangle in use, its index in the input.
    pub fn triangle_ids(&self) -> &[u32] {
        &self.triangle_ids
    }

    /// Number of triangles in the input, those left out included.
    pub fn input_triangles(&self) -> usize {
        self.input_triangles
    }

    /// Which triangles meet at each vertex and across each edge.
    pub fn adjacency(&self) -> &Adjacency {
        &self.adjacency
    }

    /// Connected components.
    pub fn components(&self) -> &Components {
        &self.components
    }

    /// The vertices on open borders, ascending: those at an edge with a triangle on one side only. Welded seams are none.
    pub fn border(&self) -> Vec<u32> {
        let mut on_border = vec![false; self.vertices.len()];
        for (e, edge) in self.adjacency.edges().iter().enumerate() {
            if self.adjacency.sides_of(e).len() == 1 {
                edge.iter().for_each(|&v| on_border[v as usize] = true);
            }
        }
        self.follow(&mut on_border);
        (0u32..).zip(on_border).filter_map(|(v, on)| on.then_some(v)).collect()
    }

    /// How far each vertex is from the nearest of `sources` along edges, in the mesh's own units; infinite where no
    /// edges lead.
    ///
    /// # Errors
    ///
    /// [`crate::Error::InvalidConstraint`] for none and for indices out of range.
    pub fn edge_distances(&self, sources: &[u32]) -> Result<Vec<f64>> {
        if sources.is_empty() {
            return Err(Error::InvalidConstraint(Fault::new("vertices", "there is none")));
        }
        if let Some(fault) = Fault::out_of_range("vertices", sources, self.vertices.len()) {
            return Err(Error::InvalidConstraint(fault));
        }
        let mut distances = vec![f64::INFINITY; self.vertices.len()];
        let sources = sources.iter().map(|&v| (self.representative(v), 0.0));
        Paths::new(&self.adjacency, &self.vertices, 0.0).shorten(
            &mut distances,
            sources,
            f64::INFINITY,
            |_| {},
        );
        self.follow(&mut distances);
        Ok(distances)
    }

    /// The triangles turned so that, as far as that is possible, neighbours are wound alike and each part that hangs
    /// together by edges encloses its volume, at rest, from outside.
    pub fn outward_triangles(&self) -> Vec<[u32; 3]> {
        orientation::outward(&self.triangles, &self.adjacency, &self.rest)
    }

    /// The input triangles that line a pocket, as mouth bags and eye sockets do ([`linings`]).
    ///
    /// # Errors
    ///
    /// [`Error::Cancelled`].
    pub fn linings(&self, job: &Job) -> Result<Vec<u32>> {
        let lines = linings::linings(self.rest(), &self.outward_triangles(), &self.adjacency, job)?;
        Ok(self.triangle_ids().iter().zip(lines).filter(|(_, lines)| *lines).map(|(&t, _)| t).collect())
    }

    /// Area of each triangle in unit coordinates.
    pub fn areas(&self) -> &[f64] {
        &self.geometry.areas
    }

    /// Area of all triangles, likewise.
    pub fn area(&self) -> f64 {
        self.areas().iter().sum()
    }

    /// Area of each component, likewise.
    pub fn component_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.components.count()];
        for (t, area) in self.triangles.iter().zip(self.areas()) {
            self.components.of_vertex(t[0] as usize).into_iter().for_each(|c| areas[c] += area);
        }
        areas
    }

    /// Unit normal of each triangle; some direction across its longest edge where the area is zero.
    pub fn normals(&self) -> &[Vec3] {
        &self.geometry.normals
    }

    /// Half the cotangent at each corner, which weighs the edge opposite to it; from mollified edge
    /// lengths, so finite even for triangles without area.
    pub fn half_cotangents(&self) -> &[[f64; 3]] {
        &self.geometry.half_cotangents
    }

    /// What was mended or is doubtful.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

/// As [`Mesh::diagonal`] says; 1 without area.
fn diagonal(rest: &[Vec3], triangles: &[[u32; 3]], areas: &[f64]) -> f64 {
    let (mut area, mut first, mut second) = (0.0, Vec3::ZERO, 0.0);
    for (t, &part) in triangles.iter().zip(areas) {
        let corners = t.map(|v| rest[v as usize]);
        let sum: Vec3 = corners.iter().sum();
        area += part;
        first += sum * (part / 3.0);
        second +=
            (corners.iter().map(|p| p.length_squared()).sum::<f64>() + sum.length_squared()) * (part / 12.0);
    }
    let gyration = second / area - (first / area).length_squared();
    if gyration > 0.0 { (12.0 * gyration).sqrt() } else { 1.0 }
}
