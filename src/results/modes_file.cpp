#include <fmt/format.h>

#include <initializer_list>
#include <stdexcept>

#include "base/hdf5.h"
#include "base/output_place.h"
#include "mimbre/build.h"
#include "mimbre/linear_report.h"
#include "mimbre/usage_error.h"
#include "results/modes_parts.h"
#include "results/report_page.h"

namespace mimbre {
namespace {

using hdf5::Handle;

void require(bool good) {
  if (!good) throw std::runtime_error(hdf5::last_error());
}

void put_attribute(hid_t file, const char* name, const std::string& text) {
  const std::string fitting = text.empty() ? std::string(1, '\0') : text.substr(0, 60'000);
  const Handle type = hdf5::text_type(fitting.size()), space(H5Screate(H5S_SCALAR));
  const Handle attribute(H5Acreate2(file, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT));
  require(attribute.valid() && H5Awrite(attribute.get(), type.get(), fitting.data()) >= 0);
}

void put_attribute(hid_t file, const char* name, double value) {
  const Handle space(H5Screate(H5S_SCALAR));
  const Handle attribute(H5Acreate2(file, name, H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT));
  require(attribute.valid() && H5Awrite(attribute.get(), H5T_NATIVE_DOUBLE, &value) >= 0);
}

Handle made_array(hid_t file, const char* name, hid_t type, const std::vector<hsize_t>& shape) {
  const Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr));
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE));
  H5Pset_obj_track_times(properties.get(), false);
  Handle data(H5Dcreate2(file, name, type, space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT));
  require(data.valid());
  return data;
}

/// `values`: the last index runs fastest.
void put(hid_t file, const char* name, std::initializer_list<std::size_t> shape,
         const std::vector<double>& values) {
  const Handle data = made_array(file, name, H5T_IEEE_F64LE, {shape.begin(), shape.end()});
  if (!values.empty())
    require(H5Dwrite(data.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0);
}

void put(hid_t file, const char* name, const std::vector<std::string>& texts) {
  const hdf5::PackedTexts packed = hdf5::packed(texts);
  const Handle type = hdf5::text_type(packed.length);
  const Handle data = made_array(file, name, type.get(), {texts.size()});
  if (!texts.empty())
    require(H5Dwrite(data.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, packed.bytes.data()) >= 0);
}

/// The same number of each mode; `of` returns it.
void put_numbers(hid_t file, const char* name, const LinearisedModes& found, const auto& of) {
  std::vector<double> values;
  for (const Mode& mode : found.modes) values.push_back(of(mode));
  put(file, name, {values.size()}, values);
}

/// A complex array of each mode as NAME_real and NAME_imaginary; `of` returns it for a number of a mode.
void put_complex(hid_t file, const std::string& name, std::size_t modes,
                 std::initializer_list<std::size_t> shape, const auto& of) {
  std::vector<double> real, imaginary;
  for (std::size_t m = 0; m < modes; ++m)
    for (const std::complex<double>& x : of(m).reshaped()) {
      real.push_back(x.real());
      imaginary.push_back(x.imag());
    }
  put(file, (name + "_real").c_str(), shape, real);
  put(file, (name + "_imaginary").c_str(), shape, imaginary);
}

void put_modes(hid_t file, const LinearisedModes& found) {
  const std::size_t count = found.modes.size();
  std::vector<std::string> kinds, texts, names, units;
  for (const Mode& mode : found.modes) {
    kinds.emplace_back(results::kind_name(mode));
    texts.push_back(mode.text);
  }
  for (const LinearName& name : found.coordinates) {
    names.push_back(name.name);
    units.push_back(name.unit);
  }
  put(file, "kinds", kinds);
  put(file, "texts", texts);
  const auto number = [&](const char* name, const auto& of) { put_numbers(file, name, found, of); };
  number("frequency", [](const Mode& m) { return m.frequency; });
  number("damped_frequency", [](const Mode& m) { return m.damped; });
  number("damping_ratio", [](const Mode& m) { return m.damping; });
  number("grows", [](const Mode& m) { return m.grows ? 1. : 0.; });
  number("whirl", [](const Mode& m) { return m.whirl; });
  const auto value = [&](const char* name, const auto& of) {
    put_complex(file, name, count, {count},
                [&](std::size_t m) { return Eigen::VectorXcd::Constant(1, of(found.modes[m])); });
  };
  value("value", [](const Mode& m) { return m.value; });
  value("from_ground", [](const Mode& m) { return m.fixed; });
  value("multiplier", [](const Mode& m) { return m.multiplier; });
  put(file, "coordinate_names", names);
  put(file, "coordinate_units", units);
  put_complex(file, "shape", count, {count, names.size()},
              [&](std::size_t m) -> const Eigen::VectorXcd& { return found.modes[m].motion; });
}

void put_bodies(hid_t file, const MechanismShapes& shapes) {
  const std::size_t modes = shapes.modes.size(), bodies = shapes.header.bodies.size();
  std::vector<std::string> names;
  std::vector<double> owners, positions, quaternions;
  for (std::size_t b = 0; b < bodies; ++b) {
    const BodyDrawing& body = shapes.header.bodies[b];
    names.push_back(body.name);
    owners.insert(owners.end(), static_cast<std::size_t>(body.modes), static_cast<double>(b));
    const auto pose = shapes.at.poses.col(static_cast<Eigen::Index>(b));
    positions.insert(positions.end(), pose.begin(), pose.begin() + 3);
    quaternions.insert(quaternions.end(), pose.begin() + 3, pose.end());
  }
  put(file, "body_names", names);
  put(file, "positions", {bodies, 3}, positions);
  put(file, "quaternions", {bodies, 4}, quaternions);
  const auto& at = shapes.at.modes;
  const auto amplitudes = static_cast<std::size_t>(at.size());
  put(file, "amplitude_body", {amplitudes}, owners);
  put(file, "amplitudes", {amplitudes}, {at.begin(), at.end()});
  put_complex(file, "displacement", modes, {modes, bodies, 3},
              [&](std::size_t m) -> const Eigen::Matrix3Xcd& { return shapes.modes[m].displacement; });
  put_complex(file, "turn", modes, {modes, bodies, 3},
              [&](std::size_t m) -> const Eigen::Matrix3Xcd& { return shapes.modes[m].turn; });
  put_complex(file, "mode_amplitudes", modes, {modes, amplitudes},
              [&](std::size_t m) -> const Eigen::VectorXcd& { return shapes.modes[m].amplitudes; });
}

std::string hdf5_file(const LinearisedModes& found, const std::string& path) {
  const MechanismShapes& shapes = results::shapes_of(found);
  const hdf5::Quiet quiet;
  const Handle creation(H5Pcreate(H5P_FILE_CREATE));
  H5Pset_obj_track_times(creation.get(), false);
  const Handle file = hdf5::create_in_memory(path, creation.get());
  require(file.valid());
  put_attribute(file.get(), "format", "mimbre-mechanism-modes-1");
  put_attribute(file.get(), "mimbre_version", build_info().version);
  put_attribute(file.get(), "title", shapes.header.title);
  put_attribute(file.get(), "point", found.model.point);
  put_attribute(file.get(), "time", found.model.time);
  put_attribute(file.get(), "turning", found.turning);
  put_attribute(file.get(), "period", found.period);
  put_attribute(file.get(), "size", shapes.size);
  put(file.get(), "axis", {2, 3},
      {shapes.place[0], shapes.place[1], shapes.place[2], shapes.axis[0], shapes.axis[1], shapes.axis[2]});
  put(file.get(), "notes", found.model.notes);
  put(file.get(), "warnings", found.model.warnings);
  put_modes(file.get(), found);
  put_bodies(file.get(), shapes);
  return hdf5::image(file.get());
}

}  // namespace

void check_modes_path(const std::string& path) {
  if (!path.ends_with(".html") && !path.ends_with(".h5"))
    throw UsageError(fmt::format("'{}' ends with no format that is known: .html or .h5", path));
}

void write_modes(const LinearisedModes& modes, const std::string& path) {
  check_modes_path(path);
  if (path.ends_with(".html")) return results::write_page(mode_shapes_html(modes), path);
  const std::string bytes = hdf5_file(modes, path);
  try {
    write_whole(path, bytes);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("cannot write '{}': {}", path, error.what()));
  }
}

}  // namespace mimbre
