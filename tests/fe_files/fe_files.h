#pragma once
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "fe_files/text_file.h"
#include "mimbre/diagnostics.h"

namespace mimbre::fe {

std::string data_file(const std::string& name);

/// What the reader of a text says is wrong with it; empty when it is content.
std::string complaint(const std::function<void()>& read);

/// A folder of the test's own, empty, removed afterwards.
class Folder {
 public:
  Folder();
  ~Folder();
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::string path(const std::string& name) const;
  std::string write(const std::string& name, const std::string& text) const;

 private:
  std::filesystem::path path_;
};

}  // namespace mimbre::fe
