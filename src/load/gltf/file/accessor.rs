//! Accessors: numbers in the buffers of a file, read one element at a time with every bound checked before.
//!
//! Nothing is copied, so an accessor costs no memory whatever `count` it claims.

use super::document::Document;
use crate::load::LoadError;
use crate::load::gltf::json::{Kind, Sparse};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(number: u32) -> Option<Self> {
        Some(match number {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return None,
        })
    }

    /// The number that stands for 1 where numbers are normalised.
    fn most(self) -> f32 {
        match self {
            Component::I8 => 127.0,
            Component::U8 => 255.0,
            Component::I16 => 32767.0,
            Component::U16 => 65535.0,
            Component::U32 | Component::F32 => 1.0,
        }
    }

    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }
}

/// Elements at equal distances; all are inside of `bytes`.
#[derive(Clone, Copy)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

impl<'a> Strided<'a> {
    /// None where the elements reach beyond the bytes.
    fn new(bytes: &'a [u8], offset: u64, stride: u64, size: usize, count: u64) -> Option<Self> {
        let bytes = bytes.get(usize::try_from(offset).ok()?..)?;
        if let Some(last) = count.checked_sub(1) {
            let end = stride.checked_mul(last)?.checked_add(size as u64)?;
            if stride == 0 && last > 0 || end > bytes.len() as u64 {
                return None;
            }
        }
        Some(Self { bytes, stride: stride as usize, size })
    }

    fn get(&self, i: usize) -> &'a [u8] {
        &self.bytes[i * self.stride..][..self.size]
    }
}

/// Elements that differ from those of the view.
#[derive(Clone, Copy)]
struct Replaced<'a> {
    /// Ascending numbers of elements.
    numbers: Strided<'a>,
    values: Strided<'a>,
    count: usize,
}

impl<'a> Replaced<'a> {
    fn number(&self, k: usize) -> u64 {
        self.numbers.get(k).iter().rev().fold(0, |n, &byte| n << 8 | u64::from(byte))
    }

    fn find(&self, i: usize) -> Option<&'a [u8]> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            if self.number(middle) < i as u64 { low = middle + 1 } else { high = middle }
        }
        (low < self.count && self.number(low) == i as u64).then(|| self.values.get(low))
    }
}

pub struct Accessor<'a> {
    /// None: all zero.
    elements: Option<Strided<'a>>,
    replaced: Option<Replaced<'a>>,
    component: Component,
    normalized: bool,
    pub kind: Kind,
    count: usize,
}

impl Document<'_> {
    /// The accessor `index`, which `place` names.
    pub fn accessor(&self, index: u32, place: impl Fn() -> String) -> Result<Accessor<'_>, LoadError> {
        let accessor = self.get(&self.root.accessors, "accessors", index, place)?;
        let place = || format!("accessors[{index}]");
        let fault = |text: String| self.error(format!("{}: {text}", place()));
        let component = Component::of(accessor.component_type)
            .ok_or_else(|| fault(format!("there is no component type {}", accessor.component_type)))?;
        let size = component.size() * components(accessor.kind);
        let elements = match accessor.buffer_view {
            Some(view) => {
                let (view, bytes) = self.view(view, place)?;
                let stride = view.byte_stride.unwrap_or(size as u64);
                let elements = Strided::new(bytes, accessor.byte_offset, stride, size, accessor.count);
                let beyond = || fault(format!("{} elements reach beyond the buffer view", accessor.count));
                Some(elements.ok_or_else(beyond)?)
            }
            None => None,
        };
        let replaced = match &accessor.sparse {
            Some(sparse) => Some(self.sparse(sparse, size, accessor.count, place)?),
            None => None,
        };
        let count = usize::try_from(accessor.count).unwrap_or(usize::MAX);
        Ok(Accessor { elements, replaced, component, normalized: accessor.normalized, kind: accessor.kind, count })
    }

    /// What the numbers of an accessor are divided by: 1, but where normalised integers stand for shares.
    pub fn accessor_range(&self, index: u32, place: impl Fn() -> String) -> Result<f32, LoadError> {
        let accessor = self.get(&self.root.accessors, "accessors", index, place)?;
        let component = Component::of(accessor.component_type).filter(|_| accessor.normalized);
        Ok(component.map_or(1.0, Component::most))
    }

    fn sparse(
        &self,
        sparse: &Sparse,
        size: usize,
        all: u64,
        place: impl Fn() -> String + Copy,
    ) -> Result<Replaced<'_>, LoadError> {
        let fault = |text: &str| self.error(format!("{}: {text}", place()));
        let (_, numbers) = self.view(sparse.indices.buffer_view, place)?;
        let (_, values) = self.view(sparse.values.buffer_view, place)?;
        let width = match Component::of(sparse.indices.component_type) {
            Some(Component::U8) => 1,
            Some(Component::U16) => 2,
            Some(Component::U32) => 4,
            _ => return Err(fault("the indices of a sparse accessor are not unsigned integers")),
        };
        let numbers = Strided::new(numbers, sparse.indices.byte_offset, width as u64, width, sparse.count);
        let values = Strided::new(values, sparse.values.byte_offset, size as u64, size, sparse.count);
        let (Some(numbers), Some(values)) = (numbers, values) else {
            return Err(fault("the sparse elements reach beyond their buffer views"));
        };
        let replaced = Replaced { numbers, values, count: sparse.count as usize };
        let ascending = (1..replaced.count).all(|k| replaced.number(k - 1) < replaced.number(k));
        let inside = replaced.count == 0 || replaced.number(replaced.count - 1) < all;
        if !ascending || !inside {
            return Err(fault("the indices of the sparse elements do not grow, or are too large"));
        }
        Ok(replaced)
    }

    /// The accessor `index`, which must have elements of `N` components.
    pub fn accessor_of<const N: usize>(
        &self,
        index: u32,
        place: impl Fn() -> String,
    ) -> Result<Accessor<'_>, LoadError> {
        let accessor = self.accessor(index, place)?;
        let has = components(accessor.kind);
        if has != N {
            return Err(self.error(format!("accessors[{index}]: {has} components instead of {N}")));
        }
        Ok(accessor)
    }

    /// As [`Document::accessor_of`], of unsigned integers.
    pub fn integers_of<const N: usize>(
        &self,
        index: u32,
        place: impl Fn() -> String,
    ) -> Result<Accessor<'_>, LoadError> {
        let accessor = self.accessor_of::<N>(index, place)?;
        if !matches!(accessor.component, Component::U8 | Component::U16 | Component::U32) {
            return Err(self.error(format!("accessors[{index}]: the components are not unsigned integers")));
        }
        Ok(accessor)
    }
}

fn components(kind: Kind) -> usize {
    match kind {
        Kind::Scalar => 1,
        Kind::Vec2 => 2,
        Kind::Vec3 => 3,
        Kind::Vec4 | Kind::Mat2 => 4,
        Kind::Mat3 => 9,
        Kind::Mat4 => 16,
    }
}

impl Accessor<'_> {
    pub fn len(&self) -> usize {
        self.count
    }

    fn bytes(&self, i: usize) -> Option<&[u8]> {
        self.replaced.and_then(|r| r.find(i)).or_else(|| self.elements.map(|e| e.get(i)))
    }

    /// Element `i`, which has `N` components; normalised integers become shares as the specification says.
    pub fn floats<const N: usize>(&self, i: usize) -> [f32; N] {
        let Some(bytes) = self.bytes(i) else { return [0.0; N] };
        let most = self.component.most();
        let share = |raw: f32| if self.normalized { (raw / most).max(-1.0) } else { raw };
        std::array::from_fn(|c| {
            let b = &bytes[c * self.component.size()..];
            match self.component {
                Component::I8 => share(f32::from(b[0] as i8)),
                Component::U8 => share(f32::from(b[0])),
                Component::I16 => share(f32::from(i16::from_le_bytes([b[0], b[1]]))),
                Component::U16 => share(f32::from(u16::from_le_bytes([b[0], b[1]]))),
                Component::U32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
                Component::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            }
        })
    }

    /// Element `i` of unsigned integers.
    pub fn integers<const N: usize>(&self, i: usize) -> [u32; N] {
        let Some(bytes) = self.bytes(i) else { return [0; N] };
        let size = self.component.size();
        std::array::from_fn(|c| bytes[c * size..][..size].iter().rev().fold(0, |n, &byte| n << 8 | u32::from(byte)))
    }
}
