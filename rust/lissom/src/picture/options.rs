//! Options of the mesh of a picture.

use crate::options::options;

options! {
    /// Options of [`super::picture_mesh`].
    #[derive(Debug, Clone)]
    pub struct PictureMeshOptions {
        /// Wanted length of edges; 0 takes a 25th of the square root of the opaque area, some 1500 triangles, and no less
        /// than a pixel.
        pub edge: f64 = 0.0 => at_least(0.0) unit("pixels"),
        /// Alpha from which on a place is part of the drawing.
        pub threshold: f64 = 0.5 => above(0.0) at_most(1.0),
        /// How far the outline may go from the alpha's: larger is smoother, with fewer small triangles.
        pub tolerance: f64 = 0.15 => at_least(0.0) unit("pixels"),
        /// Islands and holes of less area are left out.
        pub smallest: f64 = 2.0 => at_least(0.0) unit("square pixels"),
    }
}
