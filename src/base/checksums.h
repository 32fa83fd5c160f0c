#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

#include "base/hdf5.h"

/// Checksums of what an HDF5 file holds, so that a bit that has flipped is noticed. Each dataset and each
/// group has one in its attribute `crc32`, a number of 32 bits: CRC-32 as in zlib and PNG
///   - of a dataset's values by rows, as little-endian 64-bit floating-point or signed numbers whatever the
///     file stores, texts with the zeros that fill them up;
///   - of a group's parts in the order of its attribute `crc32_of`, a text with their names: of an attribute
///     its name and its value, likewise, of what lies in the group /NAME. What is not listed may be added.
namespace mimbre::hdf5 {

/// Of bytes that come in pieces, beginning with 0.
std::uint32_t crc32(std::uint32_t before, const void* bytes, std::size_t size);

/// Gives a dataset or group the checksum of what it holds now, or the one given. Throws std::runtime_error.
void seal(hid_t object);
void seal(hid_t object, std::uint32_t checksum);
/// Those of all below a group, which itself has none yet. Throws std::runtime_error.
void seal_below(hid_t group);

/// The first object of an open file, itself included, whose checksum is not that of what it holds, as
/// "dataset 'channels'"; empty where there is none. What has no checksum is not looked at.
std::string first_damaged(hid_t file);

/// Its description.
std::string damage_message(const std::string& object);

/// Takes all checksums from a file, as they would have to be from one that is changed on purpose. Throws
/// std::runtime_error.
void remove_checksums(const std::string& path);

}  // namespace mimbre::hdf5
