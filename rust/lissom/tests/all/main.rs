//! What the core promises, from outside. One binary: faer is linked and optimised into each anew.

mod alignment;
mod common;
mod layers;
mod operators;
mod random;
mod stitch;
