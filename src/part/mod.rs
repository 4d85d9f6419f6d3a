//! What a profile asks to be made of its design: the face by limits or by a number of triangles, in the digits
//! of its file formats; what is promised of each file; and warnings of what others will find too large.

mod closed;
mod face;
mod formats;
mod promise;
mod size_warnings;

pub(crate) use closed::closed;
pub(crate) use face::{
    AtPrecision, FaceError, MeshOutcome, added_to, face, left_out, limits, plan,
};
pub(crate) use formats::{MeshCodec, cad, codec, meshes, needs_mesh};
pub(crate) use promise::Promise;
pub(crate) use size_warnings::SizeWarnings;
