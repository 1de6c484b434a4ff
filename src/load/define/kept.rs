//! The state of the context that defining a scene goes through, put back afterwards.

use crate::api::{Context, Error, Name, State};
use glam::{Vec3, Vec4};

/// What was bound and current.
struct Kept {
    class: Name,
    shader: Name,
    texture: Name,
    color: Vec4,
    normal: Vec3,
    tex_coord: Vec4,
}

impl Kept {
    fn of(context: &Context) -> Result<Self, Error> {
        let floats = |state| Ok::<Vec<f32>, Error>(context.get(state)?.floats().collect());
        let name = |state| Ok::<Name, Error>(context.get(state)?.as_slice()[0] as Name);
        Ok(Self {
            class: name(State::BoundShaderClass)?,
            shader: name(State::BoundShader)?,
            texture: name(State::BoundTexture)?,
            color: Vec4::from_slice(&floats(State::CurrentColor)?),
            normal: Vec3::from_slice(&floats(State::CurrentNormal)?),
            tex_coord: Vec4::from_slice(&floats(State::CurrentTexCoord)?),
        })
    }

    fn put_back(&self, context: &mut Context) -> Result<(), Error> {
        context.bind_shader_class(self.class)?;
        context.bind_shader(self.shader)?;
        context.bind_texture(self.texture)?;
        context.color(self.color)?;
        context.normal(self.normal)?;
        context.tex_coord(self.tex_coord)
    }
}

/// Runs `call` with nothing bound, white as the current colour and no current normal; what was bound and current before
/// is so again afterwards, and so is the matrix, which `call` may change.
pub fn with_state_kept<T>(
    context: &mut Context,
    call: impl FnOnce(&mut Context) -> Result<T, Error>,
) -> Result<T, Error> {
    let kept = Kept::of(context)?;
    if context.get(State::CurrentObject)?.as_slice() != [0.0] {
        return Err(Error::invalid_operation("not allowed between new_object and end_object"));
    }
    let depth = context.get(State::MatrixDepth)?;
    context.push_matrix()?;
    context.color(Vec4::ONE)?;
    context.normal(Vec3::ZERO)?;
    context.tex_coord(Vec4::W)?;
    let result = call(context);
    // One more than were pushed here when `call` was refused in between.
    while context.get(State::MatrixDepth)?.as_slice() > depth.as_slice() {
        context.pop_matrix()?;
    }
    kept.put_back(context)?;
    result
}
