//! As-rigid-as-possible in-betweens.
