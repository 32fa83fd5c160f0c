#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "fe/elements/elastic_matrix.h"
#include "fe_files/inp/inp_model.h"
#include "fe_files/text.h"
#include "math/once/decompositions.h"

namespace mimbre::fe {
namespace {

NamedMaterial& current_material(InpModel& model, const InpKeyword& keyword) {
  if (model.materials.empty())
    throw InputError(keyword.mark, fmt::format("*{} stands before every *MATERIAL", keyword.name));
  return model.materials.back();
}

/// D1111, D1122, D2222, … as Abaqus and CalculiX list them: the upper triangle by columns, in their order of
/// components 11 22 33 12 13 23.
ElasticMatrix from_columns(const std::vector<double>& values) {
  constexpr int place[] = {0, 1, 2, 3, 5, 4};  // in xx yy zz xy yz zx
  ElasticMatrix elastic = ElasticMatrix::Zero();
  std::size_t k = 0;
  for (int c = 0; c < 6; ++c)
    for (int r = 0; r <= c; ++r, ++k) elastic(place[r], place[c]) = elastic(place[c], place[r]) = values[k];
  return elastic;
}

/// The nine of *ELASTIC, TYPE=ORTHO among the twenty-one.
std::vector<double> orthotropic(const std::vector<double>& d) {
  std::vector<double> all(21, 0);
  for (std::size_t k = 0; k < 6; ++k) all[k] = d[k];
  all[9] = d[6];   // 1212
  all[14] = d[7];  // 1313
  all[20] = d[8];  // 2323
  return all;
}

void read_elastic(InpModel& model, const InpKeyword& keyword) {
  NamedMaterial& named = current_material(model, keyword);
  const std::string* given = keyword.find("TYPE");
  const std::string type = given ? lower(*given) : "iso";
  const auto numbers = [&](int count, const char* what) { return inp_numbers(model, keyword, count, what); };
  const auto checked = [&](const auto& make) {
    try {
      named.elastic = make();
      check_elastic_matrix(*named.elastic);
    } catch (const std::invalid_argument& error) {
      throw InputError(keyword.mark, fmt::format("material {}: {}", shown(named.name), error.what()));
    }
    // What an isotropic material would have, for checks and where only that counts (beams).
    const ElasticMatrix compliance = inverse(*named.elastic);
    named.material.young = 1 / compliance(0, 0);
    named.material.poisson = std::min(0.49, std::max(-0.9, -compliance(1, 0) / compliance(0, 0)));
  };
  if (type.starts_with("iso")) {
    const std::vector<double> values = numbers(2, "Young's modulus and Poisson's ratio");
    if (!(values[0] > 0)) model.lines.file().fail("Young's modulus must be positive");
    if (!(values[1] > -1 && values[1] < 0.5))
      model.lines.file().fail(fmt::format("Poisson's ratio {} is not between -1 and 0.5", values[1]));
    named.material.young = values[0];
    named.material.poisson = values[1];
  } else if (type == "engineering constants" || type == "engineeringconstants") {
    const auto v = numbers(9, "nine constants: E1, E2, E3, nu12, nu13, nu23, G12, G13, G23");
    checked([&] { return elastic_matrix({v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8]}); });
  } else if (type == "lamina") {
    const auto v = numbers(6, "six constants: E1, E2, nu12, G12, G13, G23");
    checked([&] { return elastic_matrix({v[0], v[1], v[1], v[2], 0, 0, v[3], v[4], v[5]}); });
  } else if (type.starts_with("ortho")) {
    const auto v =
        numbers(9, "nine constants: D1111, D1122, D2222, D1133, D2233, D3333, D1212, D1313, D2323");
    checked([&] { return from_columns(orthotropic(v)); });
  } else if (type.starts_with("aniso")) {
    const auto v = numbers(21, "twenty-one constants: D1111, D1122, D2222, ..., D2323");
    checked([&] { return from_columns(v); });
  } else {
    throw InputError(
        keyword.mark,
        fmt::format("*ELASTIC, TYPE={} is not read; there are ISO, ENGINEERING CONSTANTS, ORTHO, "
                    "ANISO and LAMINA",
                    shown(*given)));
  }
  std::string_view line;
  if (model.lines.next_data(line))
    model.warn("elastic", model.lines.file().mark(), "only the first temperature of *ELASTIC counts");
}

Eigen::Vector3d unit(const InpKeyword& keyword, const Eigen::Vector3d& v) {
  if (!(v.norm() > 0) || !v.allFinite())
    throw InputError(keyword.mark, "*ORIENTATION: its points a and b must give two directions");
  return v.normalized();
}

void read_orientation(InpModel& model, const InpKeyword& keyword) {
  InpOrientation named{needed(keyword, "NAME"), {}};
  const std::string* system = keyword.find("SYSTEM");
  const std::string kind = system ? lower(*system) : "rectangular";
  const bool cylindrical = kind.starts_with("c");
  if (!cylindrical && !kind.starts_with("r"))
    throw InputError(keyword.mark,
                     fmt::format("*ORIENTATION, SYSTEM={} is not read; there are RECTANGULAR and "
                                 "CYLINDRICAL",
                                 shown(*system)));
  if (const std::string* definition = keyword.find("DEFINITION");
      definition && lower(*definition) != "coordinates")
    throw InputError(keyword.mark, "*ORIENTATION is read with the coordinates of two points alone");
  const auto v = inp_numbers(model, keyword, 6, "the coordinates of two points a and b");
  const Eigen::Vector3d a(v[0], v[1], v[2]), b(v[3], v[4], v[5]);
  Orientation& o = named.orientation;
  if (cylindrical) {
    o.kind = Orientation::Kind::cylindrical;
    o.origin = a;
    o.axes.col(2) = unit(keyword, b - a);
    o.axes.col(0) = o.axes.col(2).unitOrthogonal();
  } else {
    o.axes.col(0) = unit(keyword, a);
    o.axes.col(2) = unit(keyword, a.cross(b));
  }
  o.axes.col(1) = o.axes.col(2).cross(o.axes.col(0));
  std::string_view line;
  if (model.lines.next_data(line)) {
    const auto axis = to_integer(next_field(line));
    const auto angle = to_real(next_field(line));
    if (!axis || *axis < 1 || *axis > 3)
      model.lines.file().fail("the second line of *ORIENTATION needs an axis (1 to 3) and an angle");
    if (angle.value_or(0) != 0) {
      if (cylindrical)
        model.lines.file().fail("a cylindrical *ORIENTATION with a further rotation is not read");
      o.axes = (o.axes * Eigen::AngleAxisd(*angle * std::numbers::pi / 180,
                                           Eigen::Vector3d(Eigen::Vector3d::Unit(*axis - 1)))
                             .toRotationMatrix())
                   .eval();
    }
  }
  model.orientations.push_back(std::move(named));
}

}  // namespace

bool read_inp_material(InpModel& model, const InpKeyword& keyword) {
  if (keyword.name == "MATERIAL") {
    model.materials.push_back({needed(keyword, "NAME"), {}});
  } else if (keyword.name == "DENSITY") {
    Material& material = current_material(model, keyword).material;
    material.density = inp_numbers(model, keyword, 1, "the density")[0];
    if (!(material.density > 0)) model.lines.file().fail("a density must be positive");
  } else if (keyword.name == "ELASTIC") {
    read_elastic(model, keyword);
  } else if (keyword.name == "ORIENTATION") {
    read_orientation(model, keyword);
  } else {
    return false;
  }
  return true;
}

}  // namespace mimbre::fe
