//! Properties that hold for random arenas, and agreement with an independent implementation.

mod arenas;
mod index;
mod poses;
mod rays;
