//! Transfer of shapes between meshes of different topology.
