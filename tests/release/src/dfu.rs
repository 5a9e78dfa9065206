//! DFU files, by which the ROM loader of an STM32 programs its flash over USB.
//!
//! The container is ST's `DfuSe` (UM0391): prefix, one target, one element, and the suffix of
//! USB's DFU specification 1.1. Numbers are little-endian.
//!
//! | bytes | part    | contents                                                            |
//! |-------|---------|---------------------------------------------------------------------|
//! | 11    | prefix  | `DfuSe`, version 1, length without suffix, number of targets         |
//! | 274   | target  | `Target`, alternate setting 0, is named, name, length, number of elements |
//! | 8     | element | address, length                                                     |
//! | n     |         | the image                                                           |
//! | 16    | suffix  | device, product, vendor, version of DFU, `UFD`, length, CRC         |

use armbridge_client::flash_image::FlashImage;
use armbridge_link::crc32::checksum;

/// Vendor of the ROM loader: ST.
const VENDOR: u16 = 0x0483;
/// The ROM loader.
const PRODUCT: u16 = 0xDF11;
/// Any version of it.
const DEVICE: u16 = 0xFFFF;
/// Version of DFU, with ST's extensions.
const DFU: u16 = 0x011A;
const NAME_LEN: usize = 255;
const PREFIX_LEN: usize = 11;
const TARGET_LEN: usize = 274;
const ELEMENT_LEN: usize = 8;
const SUFFIX_LEN: u8 = 16;

/// The DFU file of an image. `name` names the target, in at most 255 bytes.
pub(crate) fn file(image: &FlashImage, name: &str) -> Vec<u8> {
    let image_len = image.bytes.len() as u32;
    let element_len = ELEMENT_LEN as u32 + image_len;
    let len = (PREFIX_LEN + TARGET_LEN) as u32 + element_len;
    let mut padded_name = name.as_bytes().to_vec();
    padded_name.resize(NAME_LEN, 0);
    let mut file = [
        // Prefix.
        b"DfuSe\x01".as_slice(),
        &len.to_le_bytes(),
        &[1],
        // Target.
        b"Target\x00",
        &1_u32.to_le_bytes(),
        &padded_name,
        &element_len.to_le_bytes(),
        &1_u32.to_le_bytes(),
        // Element.
        &image.address.to_le_bytes(),
        &image_len.to_le_bytes(),
        &image.bytes,
        // Suffix.
        &DEVICE.to_le_bytes(),
        &PRODUCT.to_le_bytes(),
        &VENDOR.to_le_bytes(),
        &DFU.to_le_bytes(),
        b"UFD",
        &[SUFFIX_LEN],
    ]
    .concat();
    // Of the whole file so far, and not inverted at the end as CRC-32 otherwise is.
    let crc = !checksum(&file);
    file.extend(crc.to_le_bytes());
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image() -> FlashImage {
        FlashImage {
            address: 0x0800_0000,
            bytes: (0..1_000).map(|at| at as u8).collect(),
        }
    }

    #[test]
    fn parts_are_at_their_places_with_the_lengths_of_what_follows() {
        let file = file(&image(), "feather-f405");
        let word = |at: usize| u32::from_le_bytes(*file[at..].first_chunk().unwrap());
        let suffix = PREFIX_LEN + TARGET_LEN + ELEMENT_LEN + 1_000;
        assert_eq!(file.len(), suffix + usize::from(SUFFIX_LEN));
        assert_eq!(
            (&file[..6], word(6), file[10]),
            (&b"DfuSe\x01"[..], suffix as u32, 1)
        );
        assert_eq!((&file[11..18], word(18)), (&b"Target\x00"[..], 1));
        assert_eq!(&file[22..35], b"feather-f405\0");
        assert_eq!((word(277), word(281)), (1_008, 1));
        assert_eq!((word(285), word(289)), (0x0800_0000, 1_000));
        assert_eq!(file[293..suffix], image().bytes);
        let expected = b"\xFF\xFF\x11\xDF\x83\x04\x1A\x01UFD\x10";
        assert_eq!(&file[suffix..suffix + 12], expected);
        // The remainder of a message with its own checksum behind it does not depend on it.
        assert_eq!(!checksum(&file), 0);
    }
}
