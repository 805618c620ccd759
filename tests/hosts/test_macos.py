"""The binary for macOS, which is made on other systems and is not run here: what macOS reads of it before it runs."""

import hashlib
import struct
import zipfile
from dataclasses import dataclass, field

import pytest
from conftest import ROOT

pytestmark = pytest.mark.all

PATH = ROOT / "target/fmu/platforms/NewtonsCradle.fmu"
# Of <mach-o/fat.h>, <mach/machine.h>, <mach-o/loader.h> and cs_blobs.h.
FAT_MAGIC, MH_MAGIC_64, MH_DYLIB = 0xCAFEBABE, 0xFEEDFACF, 6
INTEL, ARM = 0x01000007, 0x0100000C
LC_LOAD_DYLIB, LC_ID_DYLIB, LC_CODE_SIGNATURE, LC_BUILD_VERSION = 0xC, 0xD, 0x1D, 0x32
PLATFORM_MACOS = 1
SUPER_BLOB, CODE_DIRECTORY, AD_HOC, SHA256 = 0xFADE0CC0, 0xFADE0C02, 0x2, 2


@dataclass
class Slice:
    """A shared library for one processor."""

    data: bytes
    libraries: list = field(default_factory=list)
    signature: tuple[int, int] | None = None  # offset and length
    macos: tuple[int, int, int] | None = None  # platform, oldest version, version of the SDK

    def __post_init__(self):
        magic, *_, kind, count, _, _, _ = struct.unpack_from("<8I", self.data)
        assert (magic, kind) == (MH_MAGIC_64, MH_DYLIB)
        at = 32
        for _ in range(count):
            command, length = struct.unpack_from("<2I", self.data, at)
            if command == LC_LOAD_DYLIB:
                begin = at + struct.unpack_from("<I", self.data, at + 8)[0]
                self.libraries.append(self.data[begin : self.data.index(0, begin)].decode())
            elif command == LC_CODE_SIGNATURE:
                self.signature = struct.unpack_from("<2I", self.data, at + 8)
            elif command == LC_BUILD_VERSION:
                self.macos = struct.unpack_from("<3I", self.data, at + 8)
            at += length


@pytest.fixture(scope="module")
def slices() -> dict[int, Slice]:
    """The libraries of the universal binary by processor."""
    if not PATH.exists():
        pytest.skip(f"{PATH} is missing: cradle.py test --all makes it")
    with zipfile.ZipFile(PATH) as archive:
        name = "binaries/darwin64/NewtonsCradle.dylib"
        if name not in archive.namelist():
            pytest.skip("there is no binary for macOS: cargo-zigbuild or a Rust for it was missing")
        data = archive.read(name)
    magic, count = struct.unpack_from(">2I", data)
    assert magic == FAT_MAGIC
    found = {}
    for processor, _, begin, length, align in struct.iter_unpack(">5I", data[8 : 8 + 20 * count]):
        assert begin % (1 << align) == 0
        found[processor] = Slice(data[begin : begin + length])
    return found


def test_one_file_is_for_both_processors_and_needs_the_system_only(slices):
    assert set(slices) == {INTEL, ARM}
    for library in slices.values():
        assert library.libraries == ["/usr/lib/libSystem.B.dylib"]
        platform, oldest, _ = library.macos
        assert (platform, oldest) == (PLATFORM_MACOS, 11 << 16)


def test_what_is_for_arm_is_signed_ad_hoc_and_every_page_has_its_hash(slices):
    assert slices[ARM].signature
    for library in slices.values():
        if library.signature:
            check_signature(library)


def check_signature(library: Slice) -> None:
    """Computes the hash of each page, as macOS does when it loads the page."""
    begin, length = library.signature
    blob = library.data[begin : begin + length]
    magic, _, count = struct.unpack_from(">3I", blob)
    assert magic == SUPER_BLOB
    offsets = [offset for kind, offset in struct.iter_unpack(">2I", blob[12 : 12 + 8 * count]) if kind == 0]
    directory = blob[offsets[0] :]
    magic, _, _, flags, hashes, _, _, pages, limit = struct.unpack_from(">9I", directory)
    size, kind, _, bits = struct.unpack_from(">4B", directory, 36)
    assert (magic, kind, size) == (CODE_DIRECTORY, SHA256, 32)
    assert flags & AD_HOC
    assert limit == begin  # all but the signature itself
    assert pages == -(-limit >> bits) and pages > 10
    for page in range(pages):
        part = library.data[page << bits : min((page + 1) << bits, limit)]
        assert hashlib.sha256(part).digest() == directory[hashes + 32 * page : hashes + 32 * (page + 1)], page
