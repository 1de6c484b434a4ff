//! EXT_meshopt_compression: buffer views compressed by meshoptimizer, after the bit streams of the extension's appendix A.
//!
//! Our own, as the crates for it either wrap C++ or are not kept any more. Attributes are coded byte by byte of an element as
//! differences to the element before, in groups of 16; triangles by the edges and vertices used last.

use crate::load::gltf::json::Meshopt;

/// Decodes a view. The caller has made sure that `count` × `byte_stride` bytes may be taken.
pub fn decode(view: &Meshopt, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let (count, stride) = (view.count as usize, view.byte_stride as usize);
    let mut data = match view.mode.as_str() {
        "ATTRIBUTES" if stride > 0 && stride <= 256 && stride.is_multiple_of(4) => attributes(bytes, count, stride)?,
        "TRIANGLES" if matches!(stride, 2 | 4) && count.is_multiple_of(3) => {
            written(&triangles(bytes, count).ok_or(DAMAGED)?, stride)
        }
        "INDICES" if matches!(stride, 2 | 4) => written(&indices(bytes, count).ok_or(DAMAGED)?, stride),
        mode => return Err(format!("EXT_meshopt_compression: mode `{mode}` of {stride} bytes is not read")),
    };
    match (view.filter.as_deref().unwrap_or("NONE"), stride) {
        ("NONE", _) => {}
        ("OCTAHEDRAL", 4) => data.as_chunks_mut::<4>().0.iter_mut().for_each(octahedral_bytes),
        ("OCTAHEDRAL", 8) => words(&mut data, |v| octahedral(v, 32767.0)),
        ("QUATERNION", 8) => words(&mut data, quaternion),
        ("EXPONENTIAL", _) if stride.is_multiple_of(4) => {
            data.as_chunks_mut::<4>().0.iter_mut().for_each(|b| *b = exponential(u32::from_le_bytes(*b)).to_le_bytes());
        }
        (filter, _) => return Err(format!("EXT_meshopt_compression: filter `{filter}` of {stride} bytes is not read")),
    }
    Ok(data)
}

const DAMAGED: &str = "the data of EXT_meshopt_compression is damaged";

/// Bytes from the front of the data.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (front, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(front)
    }

    fn byte(&mut self) -> Option<u8> {
        self.take(1).map(|b| b[0])
    }

    /// Seven bits a byte, the lowest first.
    fn number(&mut self) -> Option<u32> {
        let mut number = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            number |= u32::from(byte & 127).wrapping_shl(shift);
            if byte < 128 {
                break;
            }
        }
        Some(number)
    }

    /// `last` and a difference whose lowest bit is its sign.
    fn index(&mut self, last: u32) -> Option<u32> {
        Some(last.wrapping_add(signed(self.number()?)))
    }
}

fn signed(v: u32) -> u32 {
    (v >> 1) ^ (v & 1).wrapping_neg()
}

fn attributes(bytes: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, String> {
    match bytes.first() {
        Some(0xa0) => {}
        Some(0xa1) => return Err("EXT_meshopt_compression: version 1 of attributes is not read".into()),
        _ => return Err(DAMAGED.into()),
    }
    attribute_blocks(bytes, count, stride).ok_or_else(|| DAMAGED.into())
}

fn attribute_blocks(bytes: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    const GROUP: usize = 16;
    let body = bytes.len().checked_sub(stride.max(32)).filter(|&n| n >= 1)?;
    let mut reader = Reader(&bytes[1..body]);
    let mut last = bytes[bytes.len() - stride..].to_vec();
    let longest = (8192 / stride / GROUP * GROUP).min(256);
    // Every group of 16 bytes takes two bits at least, so a damaged count is found before memory is taken.
    if (count.div_ceil(GROUP).checked_mul(stride)?) / 4 > bytes.len() {
        return None;
    }
    let mut data = vec![0; count.checked_mul(stride)?];
    for block in data.chunks_mut(longest * stride) {
        let elements = block.len() / stride;
        let groups = elements.div_ceil(GROUP);
        for k in 0..stride {
            let header = reader.take(groups.div_ceil(4))?;
            for g in 0..groups {
                let differences = group(&mut reader, header[g / 4] >> (g % 4 * 2) & 3)?;
                let those = block[g * GROUP * stride..].chunks_mut(stride).zip(differences);
                for (element, difference) in those {
                    last[k] = last[k].wrapping_add(signed(u32::from(difference)) as u8);
                    element[k] = last[k];
                }
            }
        }
    }
    reader.0.is_empty().then_some(data)
}

/// Sixteen numbers of 0, 2, 4 or 8 bits; the largest of 2 or 4 bits says that a byte follows the group.
fn group(reader: &mut Reader, mode: u8) -> Option<[u8; 16]> {
    let bits = match mode {
        0 => return Some([0; 16]),
        3 => return reader.take(16)?.try_into().ok(),
        mode => 2 * usize::from(mode),
    };
    let packed = reader.take(2 * bits)?;
    let most = (1_u8 << bits) - 1;
    let mut numbers = [0; 16];
    for (i, number) in numbers.iter_mut().enumerate() {
        let at = i * bits;
        let small = packed[at / 8] >> (8 - bits - at % 8) & most;
        *number = if small == most { reader.byte()? } else { small };
    }
    Some(numbers)
}

/// The last sixteen of something.
struct Recent<T> {
    items: [T; 16],
    next: usize,
}

impl<T: Copy> Recent<T> {
    fn new(first: T) -> Self {
        Self { items: [first; 16], next: 0 }
    }

    fn push(&mut self, item: T) {
        self.items[self.next] = item;
        self.next = (self.next + 1) % 16;
    }

    /// The item pushed `back` pushes ago; 1 is the last.
    fn get(&self, back: usize) -> T {
        self.items[(self.next + 16 - back) % 16]
    }
}

/// Vertices of triangles: used lately, new, or told.
struct Vertices {
    recent: Recent<u32>,
    next: u32,
    last: u32,
}

impl Vertices {
    fn fresh(&mut self) -> u32 {
        self.next = self.next.wrapping_add(1);
        self.next.wrapping_sub(1)
    }
}

fn triangles(bytes: &[u8], count: usize) -> Option<Vec<u32>> {
    let version = bytes.first()? & 0x0f;
    if bytes[0] & 0xf0 != 0xe0 || version > 1 {
        return None;
    }
    let body = bytes.len().checked_sub(16)?;
    let table = &bytes[body..];
    let mut data = Reader(bytes.get(1..body)?);
    let codes = data.take(count / 3)?;
    let mut edges = Recent::new([u32::MAX; 2]);
    let mut vertices = Vertices { recent: Recent::new(u32::MAX), next: 0, last: 0 };
    let mut corners = Vec::with_capacity(count);
    for &code in codes {
        let [a, b, c] = if code < 0xf0 {
            let [a, b] = edges.get(usize::from(code >> 4) + 1);
            let c = third(code & 15, version, &mut vertices, &mut data)?;
            edges.push([c, b]);
            edges.push([a, c]);
            [a, b, c]
        } else {
            let [a, b, c] = three(code, table, &mut vertices, &mut data)?;
            edges.push([b, a]);
            edges.push([c, b]);
            edges.push([a, c]);
            [a, b, c]
        };
        corners.extend([a, b, c]);
    }
    data.0.is_empty().then_some(corners)
}

/// The corner of a triangle whose other two are those of an edge.
fn third(code: u8, version: u8, vertices: &mut Vertices, data: &mut Reader) -> Option<u32> {
    let seen = if version == 0 { 15 } else { 13 };
    if code != 0 && code < seen {
        return Some(vertices.recent.get(usize::from(code) + 1));
    }
    let c = match code {
        0 => vertices.fresh(),
        13 => vertices.last.wrapping_sub(1),
        14 => vertices.last.wrapping_add(1),
        _ => data.index(vertices.last)?,
    };
    if code != 0 {
        vertices.last = c;
    }
    vertices.recent.push(c);
    Some(c)
}

/// The corners of a triangle without an edge that was used lately.
fn three(code: u8, table: &[u8], vertices: &mut Vertices, data: &mut Reader) -> Option<[u32; 3]> {
    let told = code >= 0xfe;
    let rest = if told { data.byte()? } else { table[usize::from(code & 15)] };
    if told && rest == 0 {
        vertices.next = 0;
    }
    let how = [if code == 0xff { 15 } else { 0 }, rest >> 4, rest & 15];
    let mut corners = [0; 3];
    for (corner, code) in corners.iter_mut().zip(how) {
        *corner = match code {
            0 => vertices.fresh(),
            15 if told => 0,
            back => vertices.recent.get(usize::from(back)),
        };
    }
    for (corner, code) in corners.iter_mut().zip(how) {
        if told && code == 15 {
            *corner = data.index(vertices.last)?;
            vertices.last = *corner;
        }
    }
    for (&corner, code) in corners.iter().zip(how) {
        if code == 0 || told && code == 15 {
            vertices.recent.push(corner);
        }
    }
    Some(corners)
}

fn indices(bytes: &[u8], count: usize) -> Option<Vec<u32>> {
    if bytes.first()? & 0xf0 != 0xd0 || bytes[0] & 0x0f > 1 {
        return None;
    }
    let mut data = Reader(bytes.get(1..bytes.len().checked_sub(4)?)?);
    // Every index takes a byte at least.
    if count > data.0.len() {
        return None;
    }
    let mut last = [0_u32; 2];
    let mut list = Vec::with_capacity(count);
    for _ in 0..count {
        let v = data.number()?;
        let base = &mut last[(v & 1) as usize];
        *base = base.wrapping_add(signed(v >> 1));
        list.push(*base);
    }
    data.0.is_empty().then_some(list)
}

fn written(numbers: &[u32], stride: usize) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes().into_iter().take(stride)).collect()
}

/// Four numbers of 16 bits at a time.
fn words(data: &mut [u8], change: impl Fn(&mut [i16; 4])) {
    for bytes in data.as_chunks_mut::<8>().0 {
        let mut values: [i16; 4] = std::array::from_fn(|i| i16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]));
        change(&mut values);
        for (pair, value) in bytes.as_chunks_mut::<2>().0.iter_mut().zip(values) {
            *pair = value.to_le_bytes();
        }
    }
}

fn octahedral_bytes(bytes: &mut [u8; 4]) {
    let mut values = bytes.map(|b| i16::from(b as i8));
    octahedral(&mut values, 127.0);
    *bytes = values.map(|v| v as i8 as u8);
}

/// A unit vector from a point of the octahedron; the third number is its 1, `most` that of the result.
fn octahedral(v: &mut [i16; 4], most: f32) {
    let (mut x, mut y) = (f32::from(v[0]), f32::from(v[1]));
    let z = f32::from(v[2]) - x.abs() - y.abs();
    let fold = z.min(0.0);
    x += if x >= 0.0 { fold } else { -fold };
    y += if y >= 0.0 { fold } else { -fold };
    let length = (x * x + y * y + z * z).sqrt();
    let scale = if length > 0.0 { most / length } else { 0.0 };
    (v[0], v[1], v[2]) = ((x * scale).round() as i16, (y * scale).round() as i16, (z * scale).round() as i16);
}

/// A unit quaternion from three of its numbers; the fourth word says which is missing, and the scale.
fn quaternion(v: &mut [i16; 4]) {
    let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(v[3] | 3);
    let [x, y, z] = [v[0], v[1], v[2]].map(|c| f32::from(c) * scale);
    let w = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    let missing = (v[3] & 3) as usize;
    for (k, c) in [w, x, y, z].into_iter().enumerate() {
        v[(missing + k) % 4] = (c * 32767.0).round() as i16;
    }
}

/// A signed exponent of 8 bits and a signed integer of 24.
fn exponential(v: u32) -> f32 {
    let (exponent, mantissa) = (v as i32 >> 24, (v << 8) as i32 >> 8);
    (f64::from(mantissa) * f64::from(exponent).exp2()) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view(mode: &str, count: u64, byte_stride: u64) -> Meshopt {
        Meshopt { buffer: 0, byte_offset: 0, byte_length: 0, byte_stride, count, mode: mode.into(), filter: None }
    }

    /// Two elements of four bytes: (1, 2, 3, 4), which the tail repeats, and (1, 1, 3, 8).
    #[test]
    fn attributes_are_sums_of_differences() {
        let mut bytes = vec![0xa0];
        // No differences in bytes 0 and 2; of two bits: 0, then −1 (written as 1).
        bytes.push(0);
        bytes.extend([1, 0b0001_0000, 0, 0, 0]);
        bytes.push(0);
        // Of two bits: 0, then +4 (written as 8, which is too large for two bits).
        bytes.extend([1, 0b0011_0000, 0, 0, 0, 8]);
        bytes.extend([0; 28]);
        bytes.extend([1, 2, 3, 4]);
        assert_eq!(decode(&view("ATTRIBUTES", 2, 4), &bytes).unwrap(), [1, 2, 3, 4, 1, 1, 3, 8]);
        assert!(decode(&view("ATTRIBUTES", 2, 4), &bytes[1..]).is_err());
        assert!(decode(&view("ATTRIBUTES", 1 << 40, 4), &bytes).is_err());
    }

    /// A quadrilateral: 0 1 2, then the edge 2 1 with the new vertex 3, coded as the reference encoder does.
    #[test]
    fn triangles_share_edges() {
        let mut bytes = vec![0xe1, 0xf0, 0x10];
        let table = [0; 16];
        bytes.extend(table);
        assert_eq!(triangles(&bytes, 6).unwrap(), [0, 1, 2, 2, 1, 3]);
        let words = decode(&view("TRIANGLES", 6, 2), &bytes).unwrap();
        assert_eq!(words, [0, 0, 1, 0, 2, 0, 2, 0, 1, 0, 3, 0]);
        assert!(triangles(&bytes[..bytes.len() - 1], 6).is_none());
    }

    #[test]
    fn indices_are_relative_to_one_of_two() {
        // 5 by the first, 9 by the second, 4 by the first: differences +5, +9, −1, the lowest bit is the base.
        let bytes = [0xd1, 5 << 2, 9 << 2 | 1, 1 << 1, 0, 0, 0, 0];
        assert_eq!(indices(&bytes, 3).unwrap(), [5, 9, 4]);
        assert!(indices(&bytes, 4).is_none());
    }

    #[test]
    fn filters_give_unit_vectors() {
        let mut v = [0, 0, 127, 5];
        octahedral(&mut v, 127.0);
        assert_eq!(v, [0, 0, 127, 5]);
        let mut v = [127, 0, 127, 0];
        octahedral(&mut v, 127.0);
        assert_eq!(v, [127, 0, 0, 0]);
        let mut q = [0, 0, 0, 0x7ffc | 3];
        quaternion(&mut q);
        assert_eq!(q, [0, 0, 0, 32767]);
        assert_eq!(exponential(0x0100_0003), 6.0);
        assert_eq!(exponential(0xff00_0003), 1.5);
        assert_eq!(exponential(0x00ff_ffff), -1.0);
    }
}
