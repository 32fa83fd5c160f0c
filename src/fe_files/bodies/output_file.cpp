#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "fe_files/bodies/reduced_files.h"

namespace mimbre::fe {

OutputFile::OutputFile(const std::string& path) try
    : path_(path), place_(path), file_(std::fopen(place_.path().c_str(), "wb")) {
  if (!file_) throw std::runtime_error(std::strerror(errno));
} catch (const std::runtime_error& error) {
  throw std::runtime_error(fmt::format("cannot write '{}': {}", path, error.what()));
}

OutputFile::~OutputFile() {
  if (file_) std::fclose(file_);
}

void OutputFile::fail(const std::string& why) const {
  throw std::runtime_error(fmt::format("cannot write '{}': {}", path_, why));
}

void OutputFile::write(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), file_) != text.size()) fail(std::strerror(errno));
}

void OutputFile::finish() {
  // Closing writes the last of it, and may find the disk full.
  if (std::fclose(std::exchange(file_, nullptr)) != 0) fail(std::strerror(errno));
  try {
    place_.commit();
  } catch (const std::runtime_error& error) {
    fail(error.what());
  }
}

}  // namespace mimbre::fe
