#include <minizip/zip.h>

#include <stdexcept>

#include "portable/fmu/parts.h"

namespace mimbre::portable {
namespace {

/// Of no hour in particular, so that the same files give the same archive: 1980, where ZIP's calendar begins.
zip_fileinfo no_date() {
  zip_fileinfo info{};
  info.tmz_date.tm_mday = 1;
  info.tmz_date.tm_year = 1980;
  // A plain file, to be read by all.
  info.external_fa = 0100644ul << 16;
  return info;
}

bool add(zipFile archive, const std::string& name, const std::string& bytes) {
  const zip_fileinfo info = no_date();
  constexpr int on_unix = 3 << 8, level = 9;
  if (zipOpenNewFileInZip4_64(archive, name.c_str(), &info, nullptr, 0, nullptr, 0, nullptr, Z_DEFLATED,
                              level, 0, -MAX_WBITS, MAX_MEM_LEVEL, Z_DEFAULT_STRATEGY, nullptr, 0,
                              on_unix | 20, 0, bytes.size() > 0xFFFFFFF0u) != ZIP_OK)
    return false;
  constexpr std::size_t most = 1u << 30;
  bool written = true;
  for (std::size_t at = 0; at < bytes.size() && written; at += most)
    written = zipWriteInFileInZip(archive, bytes.data() + at,
                                  static_cast<unsigned>(std::min(most, bytes.size() - at))) == ZIP_OK;
  return zipCloseFileInZip(archive) == ZIP_OK && written;
}

}  // namespace

void write_archive(const std::string& path, const ArchiveFiles& files) {
  zipFile archive = zipOpen64(path.c_str(), APPEND_STATUS_CREATE);
  if (!archive) throw std::runtime_error("the archive cannot be made");
  bool written = true;
  for (const auto& [name, bytes] : files) written = written && add(archive, name, bytes);
  if (zipClose(archive, nullptr) != ZIP_OK || !written)
    throw std::runtime_error("the archive cannot be written; is the disk full?");
}

}  // namespace mimbre::portable
