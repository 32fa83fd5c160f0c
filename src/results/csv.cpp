#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "base/flush_clock.h"
#include "base/output_place.h"
#include "mimbre/results.h"
#include "mimbre/text.h"
#include "results/superseded_parts.h"

namespace mimbre {

namespace {

/// A name with a comma, a quote or a line break stands in quotes (RFC 4180). One that spreadsheets would run
/// as a formula gets an apostrophe in front, which makes it a text to them; what is no text becomes one.
std::string cell(const std::string& given) {
  const std::string name =
      (!given.empty() && std::string_view("=+-@\t\r").find(given[0]) != std::string_view::npos ? "'" : "") +
      printable(given);
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string quoted = "\"";
  for (const char c : name) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace

struct CsvWriter::Impl {
  std::string path, failure;
  std::unique_ptr<OutputPlace> place;
  std::size_t columns = 0;
  std::int64_t rows = 0, rows_in_file = 0;  ///< the latter, and the bytes of them, as of the last flush
  std::uintmax_t bytes = 0, bytes_in_file = 0;
  std::FILE* file = nullptr;
  fmt::memory_buffer line;
  FlushClock clock;

  std::string cannot_write(const std::string& why) const {
    return fmt::format("cannot write CSV file '{}': {}", path, why);
  }

  [[noreturn]] void fail(const std::string& why) {
    if (file) std::fclose(std::exchange(file, nullptr));
    failure = cannot_write(why);
    // A full disk can cut a row in two: what is kept ends with the last one that is known to be whole.
    std::error_code error;
    if (rows_in_file > 0) std::filesystem::resize_file(place->path(), bytes_in_file, error);
    if (rows_in_file > 0 && !error)
      failure += fmt::format("; the first {} rows are kept in '{}'", rows_in_file, place->keep());
    throw std::runtime_error(failure);
  }

  void open() {
    try {
      place = std::make_unique<OutputPlace>(path);
    } catch (const std::runtime_error& error) {
      fail(error.what());
    }
    file = std::fopen(place->path().c_str(), "w");
    if (!file) fail(std::strerror(errno));
  }

  void write_line() {
    line.push_back('\n');
    if (std::fwrite(line.data(), 1, line.size(), file) != line.size()) fail(std::strerror(errno));
    bytes += line.size();
    line.clear();
  }

  void flush() {
    if (std::fflush(file) != 0) fail(std::strerror(errno));
    rows_in_file = rows;
    bytes_in_file = bytes;
    clock.reset();
  }

  /// Closing writes the last of it, and may find the disk full.
  void close() {
    if (std::fclose(std::exchange(file, nullptr)) != 0) fail(std::strerror(errno));
    rows_in_file = rows;
    bytes_in_file = bytes;
  }

  void require_open(const char* otherwise) const {
    if (!failure.empty()) throw std::runtime_error(failure);
    if (!file) throw std::logic_error(otherwise);
  }
};

CsvWriter::CsvWriter(const std::string& path, std::vector<std::string> columns,
                     const std::vector<std::string>& units)
    : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->columns = columns.size();
  impl_->open();
  fmt::format_to(std::back_inserter(impl_->line), "t");
  for (const std::string& column : columns)
    fmt::format_to(std::back_inserter(impl_->line), ",{}", cell(column));
  impl_->write_line();
  if (units.empty()) return;
  fmt::format_to(std::back_inserter(impl_->line), "s");
  for (const std::string& unit : units) fmt::format_to(std::back_inserter(impl_->line), ",{}", cell(unit));
  impl_->write_line();
}

CsvWriter::~CsvWriter() {
  try {
    if (impl_->file) keep();
  } catch (const std::exception&) {
    // A destructor cannot report; what there was room for is kept.
  }
}

void CsvWriter::add(double time, const Eigen::VectorXd& values) {
  impl_->require_open("a finished CSV file takes no more rows");
  if (values.size() != static_cast<Eigen::Index>(impl_->columns))
    throw std::invalid_argument(
        fmt::format("a CSV row has {} values, not {}", impl_->columns, values.size()));
  fmt::format_to(std::back_inserter(impl_->line), "{}", time);
  for (const double value : values) fmt::format_to(std::back_inserter(impl_->line), ",{}", value);
  impl_->write_line();
  ++impl_->rows;
  flush_if_due();
}

void CsvWriter::flush_if_due() {
  if (impl_->file && impl_->clock.due()) impl_->flush();
}

void CsvWriter::flush() {
  if (impl_->file) impl_->flush();
}

std::string CsvWriter::path() const { return impl_->place->path(); }

void CsvWriter::finish() {
  impl_->require_open("a CSV file can be finished once only");
  impl_->close();
  try {
    impl_->place->commit();
  } catch (const std::runtime_error& error) {
    impl_->failure = impl_->cannot_write(error.what());
    throw std::runtime_error(impl_->failure);
  }
  results::remove_superseded_tables(impl_->path);
}

std::string CsvWriter::keep() {
  impl_->require_open("a CSV file can be finished once only");
  impl_->close();
  return impl_->place->keep();
}

std::int64_t CsvWriter::rows() const { return impl_->rows; }

}  // namespace mimbre
