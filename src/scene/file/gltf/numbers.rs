//! Numbers out of a document's buffers, every place checked against what is there.

use gltf::accessor::{DataType, sparse};
use gltf::buffer::View;

/// The bytes of every buffer.
pub(super) type Buffers<'a> = &'a [Vec<u8>];

/// The vectors of an accessor as f32, whole numbers made fractions where it says so.
pub(super) fn vectors<const N: usize>(
    buffers: Buffers<'_>,
    accessor: &gltf::Accessor<'_>,
) -> Result<Vec<[f32; N]>, String> {
    let found = accessor.dimensions().multiplicity();
    if found != N {
        return Err(format!("accessor {} has {found} numbers an element, {N} are wanted", accessor.index()));
    }
    let (kind, fraction) = (accessor.data_type(), accessor.normalized());
    let value = |bytes: &[u8]| std::array::from_fn(|i| as_f32(kind, fraction, &bytes[i * kind.size()..]));
    elements(buffers, accessor, N * kind.size(), [0.0; N], value)
}

/// The whole numbers of an accessor.
pub(super) fn indices(buffers: Buffers<'_>, accessor: &gltf::Accessor<'_>) -> Result<Vec<u32>, String> {
    let kind = accessor.data_type();
    if accessor.dimensions().multiplicity() != 1 || !matches!(kind, DataType::U8 | DataType::U16 | DataType::U32) {
        return Err(format!("accessor {} holds no indices", accessor.index()));
    }
    elements(buffers, accessor, kind.size(), 0, |bytes| as_u32(kind, bytes))
}

/// The elements of an accessor, those replaced that it says to.
fn elements<T: Copy>(
    buffers: Buffers<'_>,
    accessor: &gltf::Accessor<'_>,
    size: usize,
    zero: T,
    value: impl Fn(&[u8]) -> T,
) -> Result<Vec<T>, String> {
    let count = accessor.count();
    let damaged = || format!("accessor {} reaches beyond its buffer", accessor.index());
    let mut found = match accessor.view() {
        Some(view) => {
            let bytes = Strided::new(buffers, &view, accessor.offset(), count, size).ok_or_else(damaged)?;
            (0..count).map(|i| value(bytes.element(i))).collect()
        }
        // Without a view all elements are zero; a file must not ask for more of them than it could hold.
        None if count <= MOST_ZEROS => vec![zero; count],
        None => return Err(format!("accessor {} has {count} elements of nothing", accessor.index())),
    };
    if let Some(sparse) = accessor.sparse() {
        let (places, values) = (sparse.indices(), sparse.values());
        let kind = match places.index_type() {
            sparse::IndexType::U8 => DataType::U8,
            sparse::IndexType::U16 => DataType::U16,
            sparse::IndexType::U32 => DataType::U32,
        };
        let n = sparse.count();
        let at = Strided::new(buffers, &places.view(), places.offset(), n, kind.size()).ok_or_else(damaged)?;
        let new = Strided::new(buffers, &values.view(), values.offset(), n, size).ok_or_else(damaged)?;
        for i in 0..n {
            let place = found.get_mut(as_u32(kind, at.element(i)) as usize).ok_or_else(damaged)?;
            *place = value(new.element(i));
        }
    }
    Ok(found)
}

/// The most elements that an accessor without bytes may have.
const MOST_ZEROS: usize = 1 << 24;

/// Equally spaced elements, all of them within their buffer.
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

impl<'a> Strided<'a> {
    fn new(buffers: Buffers<'a>, view: &View<'_>, offset: usize, count: usize, size: usize) -> Option<Self> {
        let all = bytes(buffers, view)?.get(offset..)?;
        let stride = view.stride().unwrap_or(size);
        let last = count.saturating_sub(1).checked_mul(stride)?.checked_add(size)?;
        (count == 0 || (stride > 0 && last <= all.len())).then_some(Self { bytes: all, stride, size })
    }

    fn element(&self, i: usize) -> &'a [u8] {
        &self.bytes[i * self.stride..][..self.size]
    }
}

/// The bytes of a view.
pub(super) fn bytes<'a>(buffers: Buffers<'a>, view: &View<'_>) -> Option<&'a [u8]> {
    let end = view.offset().checked_add(view.length())?;
    buffers.get(view.buffer().index())?.get(view.offset()..end)
}

fn as_u32(kind: DataType, bytes: &[u8]) -> u32 {
    match kind {
        DataType::U8 => u32::from(bytes[0]),
        DataType::U16 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        _ => u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]),
    }
}

fn as_f32(kind: DataType, fraction: bool, bytes: &[u8]) -> f32 {
    let (value, whole) = match kind {
        DataType::I8 => (f32::from(bytes[0] as i8), 127.0),
        DataType::U8 => (f32::from(bytes[0]), 255.0),
        DataType::I16 => (f32::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32_767.0),
        DataType::U16 => (f32::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65_535.0),
        DataType::U32 => (as_u32(kind, bytes) as f32, u32::MAX as f32),
        DataType::F32 => return f32::from_bits(as_u32(DataType::U32, bytes)),
    };
    if fraction { (value / whole).max(-1.0) } else { value }
}
