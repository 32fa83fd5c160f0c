#include "fe_files/npz_writer.h"

#include <fmt/format.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace mimbre::fe {
namespace {

class NpzWriter {
 public:
  template <class Number>
  void add(const std::string& name, const std::string& kind, const std::string& shape,
           const std::vector<Number>& values) {
    std::string head = "{'descr': '" + kind + "', 'fortran_order': False, 'shape': (" + shape + "), }";
    head.resize((head.size() + 10 + 63) / 64 * 64 - 10, ' ');
    std::string bytes = "\x93NUMPY\x01";
    bytes += '\0';
    bytes += number(head.size(), 2) + head;
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number));
    members_.emplace_back(name + ".npy", std::move(bytes));
  }

  std::string bytes() const {
    std::string file, directory;
    for (const auto& [name, data] : members_) {
      const std::string head = number(0, 4) + number(0, 4) + number(checksum(data), 4) +
                               number(data.size(), 4) + number(data.size(), 4) + number(name.size(), 2) +
                               number(0, 2);
      directory += "PK\x01\x02" + number(20, 2) + number(20, 2) + head + number(0, 6) + number(0, 4) +
                   number(file.size(), 4) + name;
      file += "PK\x03\x04" + number(20, 2) + head + name + data;
    }
    return file + directory + "PK\x05\x06" + number(0, 4) + number(members_.size(), 2) +
           number(members_.size(), 2) + number(directory.size(), 4) + number(file.size(), 4) + number(0, 2);
  }

 private:
  std::vector<std::pair<std::string, std::string>> members_;

  static std::string number(std::uint64_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> 8 * i & 0xff);
    return text;
  }
  static std::uint32_t checksum(const std::string& data) {
    std::uint32_t crc = ~0u;
    for (const char c : data) {
      crc ^= static_cast<unsigned char>(c);
      for (int i = 0; i < 8; ++i) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
  }
};

}  // namespace

std::string npz_of(const Eigen::SparseMatrix<double>& matrix) {
  std::vector<std::int32_t> row, column;
  std::vector<double> data;
  for (int c = 0; c < matrix.outerSize(); ++c)
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, c); it; ++it) {
      row.push_back(static_cast<std::int32_t>(it.row()));
      column.push_back(c);
      data.push_back(it.value());
    }
  NpzWriter out;
  const std::string count = fmt::format("{},", data.size());
  out.add("row", "<i4", count, row);
  out.add("col", "<i4", count, column);
  out.add("format", "|S3", "", std::vector<char>{'c', 'o', 'o'});
  out.add("shape", "<i8", "2,", std::vector<std::int64_t>{matrix.rows(), matrix.cols()});
  out.add("data", "<f8", count, data);
  return out.bytes();
}

}  // namespace mimbre::fe
