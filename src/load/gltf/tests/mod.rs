//! Small files of every kind, put together here: what they load as, what they look like, what is said about them.

mod animations;
mod compressed;
mod faults;
mod hostile;
mod kit;
mod looks;
mod meshes;
mod textures;
