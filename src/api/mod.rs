//! api
pub struct Context;
