#include "base/zip_file.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <limits>

#include "mimbre/diagnostics.h"

// Format: PKWARE, .ZIP File Format Specification (APPNOTE.TXT), 4.3 and 4.5.3.

namespace mimbre {

namespace {

constexpr std::uint64_t kEndSize = 22, kHeaderSize = 46, kLocalSize = 30;
constexpr std::uint64_t kIn64 = 0xFFFFFFFF;  // the number is in the ZIP64 field
/// Deflate makes nothing smaller than this.
constexpr std::uint64_t kLargestRatio = 1032;

}  // namespace

void ZipFile::fail(const std::string& message) const { throw InputError({name_, 0, 0}, message); }

std::uint64_t ZipFile::number(std::uint64_t offset, int bytes) const {
  if (offset > bytes_.size() || bytes_.size() - offset < static_cast<std::uint64_t>(bytes))
    fail("is damaged: the archive ends too early");
  std::uint64_t value = 0;
  for (int i = bytes - 1; i >= 0; --i)
    value = value << 8 | static_cast<unsigned char>(bytes_[offset + static_cast<std::uint64_t>(i)]);
  return value;
}

ZipFile::ZipFile(std::string bytes, std::string name) : bytes_(std::move(bytes)), name_(std::move(name)) {
  // The end record stands last, before a comment of at most 65535 bytes.
  if (bytes_.size() < kEndSize) fail("is no ZIP archive");
  std::uint64_t end = bytes_.size() - kEndSize;
  const std::uint64_t lowest = end > 65535 ? end - 65535 : 0;
  while (number(end, 4) != 0x06054b50) {
    if (end == lowest) fail("is no ZIP archive, or not a whole one");
    --end;
  }
  count_ = number(end + 10, 2);
  directory_ = number(end + 16, 4);
  if (end >= 20 && number(end - 20, 4) == 0x07064b50) {
    const std::uint64_t end64 = number(end - 20 + 8, 8);
    if (number(end64, 4) != 0x06064b50) fail("is damaged: the end of the archive is not where it should be");
    count_ = number(end64 + 32, 8);
    directory_ = number(end64 + 48, 8);
  }
}

bool ZipFile::find(std::string_view member, Entry& entry) const {
  std::uint64_t at = directory_;
  for (std::uint64_t i = 0; i < count_; ++i) {
    if (number(at, 4) != 0x02014b50) fail("is damaged: its directory is not whole");
    const std::uint64_t name_length = number(at + 28, 2), extra_length = number(at + 30, 2);
    number(at + kHeaderSize + name_length + extra_length, 0);
    entry.name = std::string_view(bytes_).substr(at + kHeaderSize, name_length);
    if (entry.name == member) {
      if (number(at + 8, 2) & 1) fail("is encrypted");
      entry.method = static_cast<int>(number(at + 10, 2));
      entry.checksum = static_cast<std::uint32_t>(number(at + 16, 4));
      entry.compressed = number(at + 20, 4);
      entry.size = number(at + 24, 4);
      entry.offset = number(at + 42, 4);
      std::uint64_t extra = at + kHeaderSize + name_length;
      const std::uint64_t extra_end = extra + extra_length;
      while (extra + 4 <= extra_end) {
        const std::uint64_t id = number(extra, 2), length = number(extra + 2, 2);
        std::uint64_t field = extra + 4;
        if (id == 1)
          for (std::uint64_t* value : {&entry.size, &entry.compressed, &entry.offset})
            if (*value == kIn64) {
              *value = number(field, 8);
              field += 8;
            }
        extra += 4 + length;
      }
      return true;
    }
    at += kHeaderSize + name_length + extra_length + number(at + 32, 2);
  }
  return false;
}

std::vector<std::string> ZipFile::members() const {
  std::vector<std::string> names;
  std::uint64_t at = directory_;
  for (std::uint64_t i = 0; i < count_; ++i) {
    if (number(at, 4) != 0x02014b50) fail("is damaged: its directory is not whole");
    const std::uint64_t name_length = number(at + 28, 2), extra_length = number(at + 30, 2);
    number(at + kHeaderSize + name_length + extra_length, 0);
    names.push_back(bytes_.substr(at + kHeaderSize, name_length));
    at += kHeaderSize + name_length + extra_length + number(at + 32, 2);
  }
  return names;
}

bool ZipFile::has(std::string_view member) const {
  Entry entry;
  return find(member, entry);
}

std::string ZipFile::read(std::string_view member) const {
  Entry entry;
  if (!find(member, entry)) fail(fmt::format("has no member '{}'", member));
  if (number(entry.offset, 4) != 0x04034b50)
    fail(fmt::format("is damaged: '{}' is not where it should be", member));
  const std::uint64_t data =
      entry.offset + kLocalSize + number(entry.offset + 26, 2) + number(entry.offset + 28, 2);
  if (data > bytes_.size() || bytes_.size() - data < entry.compressed)
    fail(fmt::format("is damaged: '{}' is not whole", member));
  std::string result;
  if (entry.method == 0) {
    if (entry.size != entry.compressed) fail(fmt::format("is damaged: '{}' has two sizes", member));
    result = bytes_.substr(data, entry.size);
  } else if (entry.method == 8) {
    if (entry.size / kLargestRatio > entry.compressed)
      fail(fmt::format("is damaged: '{}' cannot have {} bytes", member, entry.size));
    result.resize(entry.size);
    z_stream stream{};
    if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) fail("cannot be decompressed");
    std::uint64_t in = 0, out = 0;
    int status = Z_OK;
    constexpr std::uint64_t most = std::numeric_limits<uInt>::max();
    while (status == Z_OK) {
      // zlib's counters have 32 bits.
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes_.data() + data + in));
      stream.avail_in = static_cast<uInt>(std::min(most, entry.compressed - in));
      stream.next_out = reinterpret_cast<Bytef*>(result.data() + out);
      stream.avail_out = static_cast<uInt>(std::min(most, entry.size - out));
      const uInt in_before = stream.avail_in, out_before = stream.avail_out;
      status = inflate(&stream, Z_NO_FLUSH);
      in += in_before - stream.avail_in;
      out += out_before - stream.avail_out;
      if (status == Z_OK && in_before == stream.avail_in && out_before == stream.avail_out) break;
    }
    inflateEnd(&stream);
    if (status != Z_STREAM_END || out != entry.size)
      fail(fmt::format("is damaged: '{}' cannot be decompressed", member));
  } else {
    fail(fmt::format("'{}' is compressed by method {}; only stored and deflated members are read", member,
                     entry.method));
  }
  uLong checksum = crc32_z(0, reinterpret_cast<const Bytef*>(result.data()), result.size());
  if (checksum != entry.checksum) fail(fmt::format("is damaged: the check sum of '{}' is wrong", member));
  return result;
}

}  // namespace mimbre
