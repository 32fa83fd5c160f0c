#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

#include "fe_files/text_file.h"
#include "mimbre/diagnostics.h"

/// Any bytes either are read or give an InputError.
template <class Read>
int read_or_refuse(const std::uint8_t* data, std::size_t size, Read&& read) {
  try {
    read(std::string(reinterpret_cast<const char*>(data), size));
  } catch (const mimbre::InputError&) {
  }
  return 0;
}

/// The same for readers of text.
template <class Read>
int read_text_or_refuse(const std::uint8_t* data, std::size_t size, Read&& read) {
  return read_or_refuse(data, size, [&](std::string bytes) {
    mimbre::fe::TextFile file(std::move(bytes), "fuzz");
    read(file);
  });
}
