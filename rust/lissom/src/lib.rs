//! Pose, transfer and interpolate triangle meshes: choose a target per element, then stitch.
