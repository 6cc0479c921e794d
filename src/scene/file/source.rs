//! A file as a stream of bytes: decompressed where its ending says so, its progress told.

use super::SceneError;
use flate2::read::MultiGzDecoder;
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// How a file is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Packing {
    Gzip,
    Zstandard,
}

impl Packing {
    /// The packing of a path's last ending, if it is one.
    pub(super) fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?;
        let is = |ending: &str| extension.eq_ignore_ascii_case(ending);
        if is("gz") {
            Some(Self::Gzip)
        } else if is("zst") {
            Some(Self::Zstandard)
        } else {
            None
        }
    }
}

/// The most bytes that a compressed file may hold: a bomb ends as an error.
const MOST_UNPACKED: u64 = 1 << 36;

/// Is told how many bytes of the file have been read, and how many there are.
pub type LoadProgress<'a> = dyn FnMut(u64, u64) + 'a;

/// A file that can be read, more than once if need be.
pub(super) struct Source<'a> {
    pub(super) path: &'a Path,
    packing: Option<Packing>,
    size: u64,
    progress: &'a mut LoadProgress<'a>,
}

impl<'a> Source<'a> {
    pub(super) fn new(path: &'a Path, size: u64, progress: &'a mut LoadProgress<'a>) -> Self {
        Self { path, packing: Packing::of(path), size, progress }
    }

    /// The file's contents from their beginning.
    pub(super) fn reader(&mut self) -> Result<Box<dyn Read + '_>, SceneError> {
        let unreadable = |source: io::Error| SceneError::Unreadable { path: self.path.to_owned(), source };
        let file = File::open(self.path).map_err(unreadable)?;
        let told = Told { file, done: 0, size: self.size, progress: self.progress };
        Ok(match self.packing {
            None => Box::new(told),
            Some(Packing::Gzip) => Box::new(Limited::of(MultiGzDecoder::new(told))),
            Some(Packing::Zstandard) => Box::new(Limited::of(Frames::new(told))),
        })
    }

    /// All of the file's contents.
    pub(super) fn bytes(&mut self) -> Result<Vec<u8>, SceneError> {
        let path = self.path;
        let mut bytes = Vec::new();
        if self.packing.is_none() {
            // What is not there cannot be read: no header is trusted with this.
            bytes.reserve_exact(usize::try_from(self.size).unwrap_or(0) + 1);
        }
        let read = self.reader()?.read_to_end(&mut bytes);
        read.map_err(|source| SceneError::Unreadable { path: path.to_owned(), source })?;
        Ok(bytes)
    }
}

/// A file that tells how far it has been read.
struct Told<'a, 'p> {
    file: File,
    done: u64,
    size: u64,
    progress: &'a mut LoadProgress<'p>,
}

impl Read for Told<'_, '_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.file.read(buffer)?;
        self.done += n as u64;
        (self.progress)(self.done, self.size.max(self.done));
        Ok(n)
    }
}

/// Unpacked bytes, up to a limit.
struct Limited<R> {
    source: R,
    left: u64,
}

impl<R: Read> Limited<R> {
    fn of(source: R) -> Self {
        Self { source, left: MOST_UNPACKED }
    }
}

impl<R: Read> Read for Limited<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.source.read(buffer)?;
        self.left = self.left.checked_sub(n as u64).ok_or_else(|| {
            io::Error::new(io::ErrorKind::InvalidData, format!("it unpacks to more than {} GiB", MOST_UNPACKED >> 30))
        })?;
        Ok(n)
    }
}

/// The frames of a Zstandard file, one after the other.
struct Frames<R> {
    source: BufReader<R>,
    decoder: FrameDecoder,
    /// Whether a frame has begun that is not read to its end.
    inside: bool,
}

impl<R: Read> Frames<R> {
    fn new(source: R) -> Self {
        Self { source: BufReader::with_capacity(1 << 16, source), decoder: FrameDecoder::new(), inside: false }
    }

    /// Begins a frame, or passes over one that holds no data.
    fn begin(&mut self) -> io::Result<()> {
        match self.decoder.init(&mut self.source) {
            Ok(()) => self.inside = true,
            Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame { length, .. })) => {
                io::copy(&mut (&mut self.source).take(length.into()), &mut io::sink())?;
            }
            Err(error) => return Err(damaged(error)),
        }
        Ok(())
    }
}

impl<R: Read> Read for Frames<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            if !self.inside {
                if self.source.fill_buf()?.is_empty() {
                    return Ok(0);
                }
                self.begin()?;
                continue;
            }
            let decoder = &mut self.decoder;
            while decoder.can_collect() == 0 && !decoder.is_finished() {
                decoder.decode_blocks(&mut self.source, BlockDecodingStrategy::UptoBlocks(1)).map_err(damaged)?;
            }
            let n = decoder.read(buffer)?;
            if n > 0 || buffer.is_empty() {
                return Ok(n);
            }
            if decoder.get_checksum_from_data().is_some()
                && decoder.get_checksum_from_data() != decoder.get_calculated_checksum()
            {
                return Err(damaged("its checksum is another"));
            }
            self.inside = false;
        }
    }
}

fn damaged(error: impl std::fmt::Display) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("damaged Zstandard data: {error}"))
}
