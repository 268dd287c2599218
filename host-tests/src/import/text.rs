//! Bytes of a file to text: gzip, UTF-8, the UTF-16 of spreadsheets, and Latin-1.

use std::io::Read;

use flate2::read::MultiGzDecoder;

/// The text that a file's bytes are; what is neither UTF-8 nor UTF-16 counts as Latin-1, whose only letters
/// here are the signs of degrees and of micro.
///
/// # Errors
/// A gzip stream that is damaged or ends early.
pub fn decoded(bytes: Vec<u8>) -> Result<String, String> {
    let bytes = unzipped(bytes)?;
    let utf16 = |word: fn([u8; 2]) -> u16| {
        let words: Vec<u16> = bytes[2..].chunks_exact(2).map(|pair| word([pair[0], pair[1]])).collect();
        String::from_utf16_lossy(&words)
    };
    Ok(match &bytes[..] {
        [0xff, 0xfe, ..] => utf16(u16::from_le_bytes),
        [0xfe, 0xff, ..] => utf16(u16::from_be_bytes),
        _ => match String::from_utf8(bytes) {
            Ok(text) => text.trim_start_matches('\u{feff}').to_owned(),
            Err(other) => other.into_bytes().into_iter().map(char::from).collect(),
        },
    })
}

/// The bytes themselves, or what they are the gzip of.
///
/// # Errors
/// A gzip stream that is damaged or ends early.
pub fn unzipped(bytes: Vec<u8>) -> Result<Vec<u8>, String> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(bytes);
    }
    let mut plain = Vec::new();
    match MultiGzDecoder::new(&bytes[..]).read_to_end(&mut plain) {
        Ok(_) => Ok(plain),
        Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => Err("the gzip file is truncated".into()),
        Err(error) => Err(format!("the gzip file is damaged: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_are_read_in_every_encoding() {
        let text = "gx (\u{b0}/s)";
        let utf16 = text.encode_utf16().flat_map(u16::to_le_bytes);
        for bytes in [
            text.as_bytes().to_vec(),
            text.chars().map(|c| c as u8).collect(),
            [0xff, 0xfe].into_iter().chain(utf16).collect(),
        ] {
            assert_eq!(decoded(bytes), Ok(text.to_owned()));
        }
    }
}
