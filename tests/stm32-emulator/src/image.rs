//! ELF files of images: what is to be programmed, and the addresses of symbols.

use object::{Object, ObjectSymbol, SymbolKind};

/// An image.
#[derive(Clone, Debug)]
pub struct Image {
    /// Bytes by their address in flash.
    pub segments: Vec<(u32, Vec<u8>)>,
    symbols: Vec<Symbol>,
}

/// A symbol.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Symbol {
    name: String,
    address: u32,
    is_function: bool,
}

impl Image {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// Defect of the image, in words.
    pub fn parse(file: &[u8]) -> Result<Self, object::Error> {
        let file = object::read::elf::ElfFile32::<object::Endianness>::parse(file)?;
        let segments = file.elf_program_headers().iter().filter_map(|header| {
            use object::read::elf::ProgramHeader;
            let endian = file.endian();
            let data = header.data(endian, file.data()).ok()?;
            (header.p_type(endian) == object::elf::PT_LOAD && !data.is_empty())
                .then(|| (header.p_paddr(endian), data.to_vec()))
        });
        let segments = segments.collect();
        let mut symbols: Vec<Symbol> = file
            .symbols()
            .filter_map(|symbol| {
                Some(Symbol {
                    name: symbol.name().ok()?.to_owned(),
                    address: u32::try_from(symbol.address()).ok()? & !1,
                    is_function: symbol.kind() == SymbolKind::Text,
                })
            })
            .collect();
        symbols.sort_by_key(|symbol| symbol.address);
        Ok(Self { segments, symbols })
    }

    /// Address of the first function whose mangled name contains this.
    pub fn symbol_with(&self, part: &str) -> Option<u32> {
        let mut functions = self.symbols.iter().filter(|symbol| symbol.is_function);
        let found = functions.find(|symbol| symbol.name.contains(part));
        found.map(|symbol| symbol.address)
    }
}
