//! Pose a mesh by handles.
