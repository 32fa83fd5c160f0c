#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "mimbre/results.h"

namespace mimbre {

namespace {

/// A name with a comma, a quote or a line break stands in quotes (RFC 4180).
std::string cell(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string quoted = "\"";
  for (const char c : name) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace

/// Rows go to PATH.part, which takes the target's place when the file is finished or given up.
struct CsvWriter::Impl {
  std::string path, part, failure;
  std::size_t columns = 0;
  std::FILE* file = nullptr;
  fmt::memory_buffer line;

  [[noreturn]] void fail(int error) {
    failure = fmt::format("cannot write CSV file '{}': {}", path, std::strerror(error));
    if (file) std::fclose(file);
    file = nullptr;
    throw std::runtime_error(failure);
  }

  void write_line() {
    line.push_back('\n');
    if (std::fwrite(line.data(), 1, line.size(), file) != line.size()) fail(errno);
    line.clear();
  }

  void close() {
    // Closing writes the last of it, and may find the disk full.
    const bool good = std::fclose(std::exchange(file, nullptr)) == 0;
    if (!good) fail(errno);
    if (std::rename(part.c_str(), path.c_str()) != 0) fail(errno);
  }
};

CsvWriter::CsvWriter(const std::string& path, std::vector<std::string> columns)
    : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->part = path + ".part";
  impl_->columns = columns.size();
  impl_->file = std::fopen(impl_->part.c_str(), "w");
  if (!impl_->file) impl_->fail(errno);
  fmt::format_to(std::back_inserter(impl_->line), "t");
  for (const std::string& column : columns)
    fmt::format_to(std::back_inserter(impl_->line), ",{}", cell(column));
  impl_->write_line();
}

CsvWriter::~CsvWriter() {
  try {
    if (impl_->file) impl_->close();
  } catch (const std::exception&) {
    // A destructor has nobody to tell; PATH.part keeps what there was room for.
  }
}

void CsvWriter::add(double time, const Eigen::VectorXd& values) {
  if (!impl_->failure.empty()) throw std::runtime_error(impl_->failure);
  if (!impl_->file) throw std::logic_error("a finished CSV file takes no more rows");
  if (values.size() != static_cast<Eigen::Index>(impl_->columns))
    throw std::invalid_argument(
        fmt::format("a CSV row has {} values, not {}", impl_->columns, values.size()));
  fmt::format_to(std::back_inserter(impl_->line), "{}", time);
  for (const double value : values) fmt::format_to(std::back_inserter(impl_->line), ",{}", value);
  impl_->write_line();
}

void CsvWriter::finish() {
  if (!impl_->failure.empty()) throw std::runtime_error(impl_->failure);
  if (!impl_->file) throw std::logic_error("a CSV file can be finished once only");
  impl_->close();
}

}  // namespace mimbre
