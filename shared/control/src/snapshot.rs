//! Numbers of a state that is kept: the bound of its parts' encodings, which vectors need.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// A number that can be part of a kept state.
pub trait Number: nalgebra::Scalar + Serialize + DeserializeOwned {}

impl<T: nalgebra::Scalar + Serialize + DeserializeOwned> Number for T {}
