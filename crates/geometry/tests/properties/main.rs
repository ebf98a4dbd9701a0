//! Properties that hold for random arenas, and agreement with an independent implementation.

mod arenas;
mod index;
mod pencil;
mod polygons;
mod poses;
mod rays;
mod sweep;
