#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "fe_files/reduced_files.h"

namespace mimbre::fe {

OutputFile::OutputFile(const std::string& path)
    : path_(path), part_(path + ".part"), file_(std::fopen(part_.c_str(), "wb")) {
  if (!file_) fail();
}

OutputFile::~OutputFile() {
  if (!file_) return;
  std::fclose(file_);
  std::remove(part_.c_str());
}

void OutputFile::fail() const {
  throw std::runtime_error(fmt::format("cannot write '{}': {}", path_, std::strerror(errno)));
}

void OutputFile::write(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail();
}

void OutputFile::finish() {
  // Closing writes the last of it, and may find the disk full.
  const bool good = std::fclose(std::exchange(file_, nullptr)) == 0;
  if (!good || std::rename(part_.c_str(), path_.c_str()) != 0) fail();
}

}  // namespace mimbre::fe
