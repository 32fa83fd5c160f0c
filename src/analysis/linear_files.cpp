#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/hdf5.h"
#include "base/output_place.h"
#include "mimbre/linearise.h"
#include "mimbre/usage_error.h"

namespace mimbre {
namespace {

using Eigen::MatrixXd;
using Json = nlohmann::ordered_json;

struct NamedMatrix {
  const char* name;
  const MatrixXd* matrix;
};
std::vector<NamedMatrix> matrices_of(const LinearModel& m) {
  return {{"A", &m.A},
          {"B", &m.B},
          {"C", &m.C},
          {"D", &m.D},
          {"mass", &m.mass},
          {"damping", &m.damping},
          {"stiffness", &m.stiffness}};
}

struct NamedTexts {
  const char* name;
  std::vector<std::string> texts;
};
std::vector<NamedTexts> texts_of(const LinearModel& m) {
  std::vector<NamedTexts> out;
  const auto add = [&](const char* name, const char* unit, const std::vector<LinearName>& of) {
    NamedTexts names{name, {}}, units{unit, {}};
    for (const LinearName& n : of) {
      names.texts.push_back(n.name);
      units.texts.push_back(n.unit);
    }
    out.push_back(std::move(names));
    out.push_back(std::move(units));
  };
  add("state_names", "state_units", m.states);
  add("input_names", "input_units", m.inputs);
  add("output_names", "output_units", m.outputs);
  out.push_back({"point", {m.point}});
  return out;
}

/// Of all frequencies, outputs × inputs one after another by columns.
struct Responses {
  MatrixXd real, imaginary;  ///< outputs · inputs × frequencies
};
Responses responses_of(const LinearModel& m, const std::vector<double>& frequencies) {
  const Eigen::Index size = m.D.size(), count = std::ssize(frequencies);
  Responses out{MatrixXd(size, count), MatrixXd(size, count)};
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::MatrixXcd g =
        frequency_response(m, 2 * std::numbers::pi * frequencies[static_cast<std::size_t>(k)]);
    for (Eigen::Index i = 0; i < size; ++i) {
      out.real(i, k) = g.data()[i].real();
      out.imaginary(i, k) = g.data()[i].imag();
    }
  }
  return out;
}

Json rows(const MatrixXd& m) {
  Json all = Json::array();
  for (Eigen::Index r = 0; r < m.rows(); ++r) {
    Json row = Json::array();
    for (Eigen::Index c = 0; c < m.cols(); ++c) row.push_back(m(r, c));
    all.push_back(std::move(row));
  }
  return all;
}

// --- MAT files, version 5 (MathWorks, MAT-File Format: data elements of 8 bytes) ---------------------------

/// A data element: its tag, its data, filled up to 8 bytes.
std::string mat_element(std::uint32_t type, const std::string& data) {
  const auto size = static_cast<std::uint32_t>(data.size());
  std::string out(8, '\0');
  std::memcpy(out.data(), &type, 4);
  std::memcpy(out.data() + 4, &size, 4);
  out += data;
  out.append((8 - out.size() % 8) % 8, '\0');
  return out;
}
template <class T>
std::string bytes_of(const T* data, std::size_t count) {
  return {reinterpret_cast<const char*>(data), count * sizeof(T)};
}
/// An array: flags with its class, its size, its name, its values.
std::string mat_array(const std::string& name, std::uint32_t array_class, std::int32_t rows,
                      std::int32_t columns, const std::string& values) {
  constexpr std::uint32_t int8 = 1, int32 = 5, uint32 = 6, matrix = 14;
  const std::uint32_t flags[2] = {array_class, 0};
  const std::int32_t size[2] = {rows, columns};
  return mat_element(matrix, mat_element(uint32, bytes_of(flags, 2)) + mat_element(int32, bytes_of(size, 2)) +
                                 mat_element(int8, name) + values);
}
std::string mat_matrix(const std::string& name, const MatrixXd& m) {
  constexpr std::uint32_t double_class = 6, double_type = 9;
  return mat_array(name, double_class, static_cast<std::int32_t>(m.rows()),
                   static_cast<std::int32_t>(m.cols()),
                   mat_element(double_type, bytes_of(m.data(), static_cast<std::size_t>(m.size()))));
}
/// UTF-8 to UTF-16, which characters of MAT files are.
std::u16string utf16(const std::string& text) {
  std::u16string out;
  for (std::size_t k = 0; k < text.size();) {
    const auto byte = [&](std::size_t i) {
      return i < text.size() ? static_cast<unsigned char>(text[i]) : 0x80U;
    };
    const unsigned first = byte(k);
    const int more = first < 0x80 ? 0 : first < 0xe0 ? 1 : first < 0xf0 ? 2 : 3;
    unsigned code = more == 0 ? first : first & (0x3fU >> more);
    for (int i = 1; i <= more; ++i) code = code << 6 | (byte(k + static_cast<std::size_t>(i)) & 0x3fU);
    out.push_back(code < 0x10000 ? static_cast<char16_t>(code) : u'?');
    k += static_cast<std::size_t>(more) + 1;
  }
  return out;
}
/// One text a row, filled up with blanks.
std::string mat_texts(const std::string& name, const std::vector<std::string>& texts) {
  constexpr std::uint32_t char_class = 4, uint16 = 4;
  std::vector<std::u16string> all;
  std::size_t longest = 0;
  for (const std::string& text : texts) {
    all.push_back(utf16(text));
    longest = std::max(longest, all.back().size());
  }
  std::u16string values;
  for (std::size_t c = 0; c < longest; ++c)
    for (const std::u16string& text : all) values.push_back(c < text.size() ? text[c] : u' ');
  return mat_array(name, char_class, static_cast<std::int32_t>(all.size()),
                   static_cast<std::int32_t>(longest),
                   mat_element(uint16, bytes_of(values.data(), values.size())));
}

std::string mat_file(const LinearModel& m, const std::vector<double>& frequencies) {
  static_assert(std::endian::native == std::endian::little);
  std::string out = "MATLAB 5.0 MAT-file, a linear model by mimbre";
  out.resize(124, ' ');
  out += std::string("\x00\x01IM", 4);
  for (const NamedMatrix& n : matrices_of(m)) out += mat_matrix(n.name, *n.matrix);
  for (const NamedTexts& n : texts_of(m)) out += mat_texts(n.name, n.texts);
  out += mat_matrix("time", MatrixXd::Constant(1, 1, m.time));
  if (!frequencies.empty()) {
    const Responses r = responses_of(m, frequencies);
    out +=
        mat_matrix("frequencies", Eigen::Map<const MatrixXd>(frequencies.data(), 1, std::ssize(frequencies)));
    out += mat_matrix("response_real", r.real) + mat_matrix("response_imaginary", r.imaginary);
  }
  return out;
}

// --- HDF5 --------------------------------------------------------------------------------------------------

void require(bool good) {
  if (!good) throw std::runtime_error(hdf5::last_error());
}
/// By rows, as readers see it.
void put(hid_t file, const char* name, const MatrixXd& m) {
  const hsize_t size[2] = {static_cast<hsize_t>(m.rows()), static_cast<hsize_t>(m.cols())};
  const hdf5::Handle space(H5Screate_simple(2, size, nullptr));
  const hdf5::Handle data(
      H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  require(data.valid());
  if (m.size() == 0) return;
  const MatrixXd by_rows = m.transpose();
  require(H5Dwrite(data.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, by_rows.data()) >= 0);
}
void put(hid_t file, const char* name, const std::vector<std::string>& texts) {
  const hdf5::PackedTexts packed = hdf5::packed(texts);
  const hdf5::Handle type = hdf5::text_type(packed.length);
  const hsize_t size = texts.size();
  const hdf5::Handle space(H5Screate_simple(1, &size, nullptr));
  const hdf5::Handle data(
      H5Dcreate2(file, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  require(data.valid());
  if (size > 0)
    require(H5Dwrite(data.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, packed.bytes.data()) >= 0);
}
std::string hdf5_file(const LinearModel& m, const std::vector<double>& frequencies, const std::string& path) {
  const hdf5::Quiet quiet;
  const hdf5::Handle file = hdf5::create_in_memory(path, H5P_DEFAULT);
  require(file.valid());
  for (const NamedMatrix& n : matrices_of(m)) put(file.get(), n.name, *n.matrix);
  for (const NamedTexts& n : texts_of(m)) put(file.get(), n.name, n.texts);
  put(file.get(), "time", MatrixXd::Constant(1, 1, m.time));
  if (!frequencies.empty()) {
    const Responses r = responses_of(m, frequencies);
    put(file.get(), "frequencies",
        Eigen::Map<const MatrixXd>(frequencies.data(), 1, std::ssize(frequencies)));
    put(file.get(), "response_real", r.real);
    put(file.get(), "response_imaginary", r.imaginary);
  }
  return hdf5::image(file.get());
}

bool ends_with(const std::string& text, std::string_view end) {
  return text.size() > end.size() && std::string_view(text).substr(text.size() - end.size()) == end;
}

}  // namespace

std::string linear_model_json(const LinearModel& m, const std::vector<double>& frequencies) {
  Json json;
  json["command"] = "linearise";
  json["status"] = "ok";
  json["title"] = m.title;
  json["point"] = m.point;
  json["time"] = m.time;
  for (const auto& [name, of] :
       {std::pair("states", &m.states), std::pair("inputs", &m.inputs), std::pair("outputs", &m.outputs)}) {
    json[name] = Json::array();
    for (const LinearName& n : *of) json[name].push_back({{"name", n.name}, {"unit", n.unit}});
  }
  json["input_values"] = m.input_values;
  json["output_values"] = m.output_values;
  json["coordinates"] = m.coordinates;
  json["speeds"] = m.speeds;
  json["redundant"] = m.redundant;
  json["speed"] = m.speed;
  json["unsteady"] = m.unsteady;
  json["varies"] = m.varies;
  for (const NamedMatrix& n : matrices_of(m)) json[n.name] = rows(*n.matrix);
  if (!frequencies.empty()) {
    const Responses r = responses_of(m, frequencies);
    json["frequencies"] = frequencies;
    json["response_real"] = rows(r.real);
    json["response_imaginary"] = rows(r.imaginary);
  }
  json["notes"] = m.notes;
  json["warnings"] = m.warnings;
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

void write_linear_model(const LinearModel& model, const std::string& path,
                        const std::vector<double>& frequencies) {
  std::string bytes;
  if (ends_with(path, ".json"))
    bytes = linear_model_json(model, frequencies) + '\n';
  else if (ends_with(path, ".mat"))
    bytes = mat_file(model, frequencies);
  else if (ends_with(path, ".h5"))
    bytes = hdf5_file(model, frequencies, path);
  else
    throw UsageError(fmt::format("'{}' ends with no format that is known: .h5, .mat or .json", path));
  try {
    write_whole(path, bytes);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("cannot write {}: {}", path, error.what()));
  }
}

}  // namespace mimbre
