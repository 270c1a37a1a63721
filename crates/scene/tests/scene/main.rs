//! Scenes, logs and robots as text: what is read, refused and written.

mod document;
mod errors;
mod files;
mod logs;
mod overrides;
mod resolved;
mod tracks;
mod whole_rovers;
