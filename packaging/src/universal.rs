//! Universal binaries of macOS: one file with a shared library for each processor, from which the system takes its own.

use std::error::Error;

use object::macho::{FAT_MAGIC, FatArch32, MachHeader64};
use object::read::FileKind;
use object::read::macho::{FatArch, MachHeader, MachOFatFile32};

/// Pages of Apple's processors have 16 KiB (2^14 bytes), those of Intel's 4 KiB: each library begins with one.
const ALIGNMENT: u32 = 14;

/// The libraries in a universal binary, or just the binary itself if it is not one.
pub fn slices(binary: &[u8]) -> object::Result<Vec<&[u8]>> {
    match FileKind::parse(binary) {
        Ok(FileKind::MachOFat32) => {
            MachOFatFile32::parse(binary)?.arches().iter().map(|arch| arch.data(binary)).collect()
        }
        _ => Ok(vec![binary]),
    }
}

/// One universal binary with the libraries of both. Refuses files that are not of macOS, and two for one processor.
pub fn join(first: &[u8], second: &[u8]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut libraries = Vec::new();
    for binary in [first, second] {
        for library in slices(binary)? {
            let header = MachHeader64::<object::Endianness>::parse(library, 0)?;
            let endian = header.endian()?;
            libraries.push((header.cputype(endian), header.cpusubtype(endian), library));
        }
    }
    libraries.sort_by_key(|(processor, ..)| *processor);
    if libraries.windows(2).any(|pair| pair[0].0 == pair[1].0) {
        return Err("both are made for the same processor".into());
    }
    let number = |number: usize| u32::try_from(number).map_err(|_| "it would have more than 4 GB");
    // The numbers of a `FatHeader` and, for each library, of a `FatArch32`.
    let mut joined = [FAT_MAGIC, number(libraries.len())?].map(u32::to_be_bytes).concat();
    let mut body = Vec::new();
    let beginning = joined.len() + libraries.len() * size_of::<FatArch32>();
    for (processor, variant, library) in libraries {
        let offset = (beginning + body.len()).next_multiple_of(1 << ALIGNMENT);
        let arch = [processor, variant, number(offset)?, number(library.len())?, ALIGNMENT];
        joined.extend(arch.map(u32::to_be_bytes).as_flattened());
        body.resize(offset - beginning, 0);
        body.extend(library);
    }
    joined.extend(body);
    Ok(joined)
}

#[cfg(test)]
mod tests {
    use object::macho::{CPU_TYPE_ARM64, CPU_TYPE_X86_64, MH_MAGIC_64};

    use super::*;

    /// The header of a library without contents, and some bytes.
    fn library(processor: u32, text: &[u8]) -> Vec<u8> {
        let header = [MH_MAGIC_64, processor, 0, 6, 0, 0, 0, 0].map(u32::to_le_bytes);
        [header.as_flattened(), text].concat()
    }

    #[test]
    fn universal_binary_gives_back_what_was_joined() {
        let (intel, arm) = (library(CPU_TYPE_X86_64, b"intel"), library(CPU_TYPE_ARM64, b"arm"));
        let joined = join(&arm, &intel).unwrap();
        assert_eq!(joined, join(&intel, &arm).unwrap());
        assert_eq!(slices(&joined).unwrap(), [&intel[..], &arm[..]]);
        assert!(joined[1 << ALIGNMENT..].starts_with(&intel));
        assert_eq!(slices(&arm).unwrap(), [&arm[..]]);
        assert!(join(&arm, &arm).unwrap_err().to_string().contains("same processor"));
        assert!(join(&arm, &joined).is_err() && join(&arm, b"\x7fELF").is_err());
        let announces_nine = [0xca, 0xfe, 0xba, 0xbe, 0, 0, 0, 9];
        assert!(slices(&[announces_nine, [0; 8]].concat()).is_err());
    }
}
