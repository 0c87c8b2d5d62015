//! The mark by which a drawing is known as this program's own: [`support::overwrite`].

use support::overwrite::MARK;

/// With a comment in front.
pub(super) fn svg(text: String) -> String {
    format!("<!-- {MARK} -->\n{text}")
}

/// Bytes of the signature and the header chunk, after which any other chunk may stand (PNG
/// specification, 5.6).
const BEHIND_HEADER: usize = 8 + 25;

/// With a text chunk (PNG specification, 11.3.4.3): keyword `Software`, a zero, the text.
pub(super) fn png(mut bytes: Vec<u8>) -> Vec<u8> {
    let mut content = b"tEXtSoftware\0".to_vec();
    content.extend_from_slice(MARK.as_bytes());
    let checksum = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&content);
    // The length is that of the data, without the chunk's type.
    let mut chunk = (content.len() as u32 - 4).to_be_bytes().to_vec();
    chunk.append(&mut content);
    chunk.extend_from_slice(&checksum.to_be_bytes());
    let place = BEHIND_HEADER.min(bytes.len());
    bytes.splice(place..place, chunk);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The header chunk of a picture of one pixel, and what ends it, as the specification has them.
    #[test]
    fn the_chunk_stands_behind_the_header() {
        let header = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\0\0\0\x01\x08\x02\0\0\0\x90\x77\x53\xde";
        let marked = png([&header[..], b"\0\0\0\0IEND\xae\x42\x60\x82"].concat());
        assert_eq!(&marked[..header.len()], header);
        assert_eq!(&marked[33..41], b"\0\0\0\x17tEXt");
        assert!(marked.ends_with(b"IEND\xae\x42\x60\x82"));
    }
}
