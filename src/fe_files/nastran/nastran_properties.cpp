#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "fe_files/nastran/nastran_model.h"
#include "fe_files/text.h"

// MSC Nastran Quick Reference Guide, MAT and P cards.

namespace mimbre::fe {

namespace {

using MaterialKind = NastranMaterial::Kind;

template <class Map, class Value>
void add(Map& map, std::int64_t label, Value value, const NastranCard& card) {
  if (!map.emplace(label, std::move(value)).second) card.fail("is there already");
}

/// What all materials have, the density in a field; `read` gives the rest.
template <class Read>
void read_material(NastranModel& model, const NastranCard& card, MaterialKind kind, std::size_t density,
                   const Read& read) {
  NastranMaterial material;
  material.kind = kind;
  material.place = model.place(card.mark);
  material.density = card.real(density, "density");
  read(material);
  add(model.materials, card.label(0, "material"), material, card);
}

/// The upper triangle by rows from field 1.
template <class Matrix>
void read_symmetric(const NastranCard& card, Matrix& matrix) {
  std::size_t field = 1;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = i; j < matrix.cols(); ++j)
      matrix(i, j) = matrix(j, i) = card.real(field++, "elastic constant");
}

/// E, G, ν: two of them make the third.
void read_isotropic(NastranModel& model, const NastranCard& card) {
  read_material(model, card, MaterialKind::isotropic, 4, [&](NastranMaterial& material) {
    material.young = card.real(1, "Young's modulus");
    material.shear = card.real(2, "shear modulus");
    material.poisson = card.real(3, "Poisson's ratio");
    const bool E = !card.blank(1), G = !card.blank(2), nu = !card.blank(3);
    if (!E && !G) card.fail("has neither Young's modulus nor shear modulus");
    if (E && G && !nu && material.shear != 0)
      material.poisson = material.young / (2 * material.shear) - 1;
    else if (!E && nu)
      material.young = 2 * (1 + material.poisson) * material.shear;
    else if (E && !G)
      material.shear = material.young / (2 * (1 + material.poisson));
    else if (!E)
      material.young = 2 * material.shear;  // E alone is missing: nothing but shear is asked of it
  });
}

void read_sheet(NastranModel& model, const NastranCard& card) {
  read_material(model, card, MaterialKind::sheet, 7, [&](NastranMaterial& material) {
    read_symmetric(card, material.sheet);
    material.sheet_shear = material.sheet(2, 2) * Eigen::Matrix2d::Identity();
    // As MID3 it relates shear forces to shear strains: G11, G12, G22, and the others are blank.
    material.shear_alone = material.sheet.topLeftCorner<2, 2>();
    material.young = material.sheet(0, 0);
  });
}

void read_orthotropic_sheet(NastranModel& model, const NastranCard& card) {
  read_material(model, card, MaterialKind::sheet, 7, [&](NastranMaterial& material) {
    const double E1 = card.real(1, "Young's modulus"), E2 = card.real(2, "Young's modulus");
    const double nu12 = card.real(3, "Poisson's ratio"), G12 = card.real(4, "shear modulus");
    // Blank and 0: rigid in shear across; a shear modulus far above those in the plane stands for it.
    const double rigid = 1e3 * std::max({E1, E2, G12});
    const double G1z = card.real(5, "shear modulus"), G2z = card.real(6, "shear modulus");
    if (!(E1 > 0 && E2 > 0 && G12 > 0)) card.fail("E1, E2 and G12 must be positive");
    const double nu21 = nu12 * E2 / E1, divisor = 1 - nu12 * nu21;
    if (!(divisor > 0)) card.fail(fmt::format("Poisson's ratio {} is that of no material", nu12));
    material.sheet << E1, nu12 * E2, 0, nu12 * E2, E2, 0, 0, 0, G12 * divisor;
    material.sheet /= divisor;
    material.sheet_shear.diagonal() << (G1z > 0 ? G1z : rigid), (G2z > 0 ? G2z : rigid);
    material.shear_alone = material.sheet_shear;
    material.young = E1;
    material.poisson = nu12;
  });
}

void read_solid_matrix(NastranModel& model, const NastranCard& card) {
  read_material(model, card, MaterialKind::solid, 22, [&](NastranMaterial& material) {
    read_symmetric(card, material.elastic);
    material.young = material.elastic(0, 0);
  });
}

void read_orthotropic_solid(NastranModel& model, const NastranCard& card) {
  read_material(model, card, MaterialKind::solid, 10, [&](NastranMaterial& material) {
    const auto at = [&](std::size_t i) { return card.real(i, "elastic constant"); };
    const EngineeringConstants constants{at(1), at(2), at(3), at(4), at(5), at(6), at(7), at(8), at(9)};
    try {
      material.elastic = elastic_matrix(constants);
    } catch (const std::invalid_argument& error) {
      card.fail(error.what());
    }
    material.young = constants.E1;
    material.poisson = constants.nu12;
  });
}

void read_shell_property(NastranModel& model, const NastranCard& card) {
  NastranShellProperty property;
  property.place = model.place(card.mark);
  property.membrane = card.whole(1, "material", 0);
  property.thickness = card.real(2, "thickness");
  property.bending = card.whole(3, "material", 0);
  property.bending_ratio = card.real(4, "12 I/T**3", 1);
  property.shear = card.whole(5, "material", 0);
  property.shear_ratio = card.real(6, "TS/T", 5.0 / 6);
  property.mass = card.real(7, "mass by area");
  property.coupling = card.whole(10, "material", 0);
  if (property.membrane < 0 || property.bending < 0)
    card.fail("plane strain (MID2 = -1) is not the state of a body's shell");
  if (property.membrane == 0 && property.bending == 0) card.fail("has no material");
  if (!(property.bending_ratio > 0)) card.fail("12 I/T**3 must be positive");
  if (!(property.shear_ratio > 0)) property.shear_ratio = 5.0 / 6;
  add(model.shell_properties, card.label(0, "property"), std::move(property), card);
}

/// `first`: of the plies; `size`: fields of each, its material at `at`.
void read_laminate(NastranModel& model, const NastranCard& card, std::size_t size, std::size_t at) {
  NastranShellProperty property;
  property.place = model.place(card.mark);
  property.mass = card.real(2, "mass by area");
  const std::string lay = capitals(card.field(7));
  if (!lay.empty() && lay != "SYM" && lay != "BLANK")
    card.fail(fmt::format("LAM = {} is not read; there are SYM and blank", shown(lay)));
  NastranShellProperty::Ply ply;
  for (std::size_t i = 8; i < card.fields.size(); i += size) {
    bool any = false;
    for (std::size_t k = 0; k < size; ++k) any = any || !card.blank(i + k);
    if (!any) continue;
    // Of a blank material and thickness the ply before decides.
    ply.material = card.whole(i + at, "material", ply.material);
    ply.thickness = card.real(i + at + 1, "thickness", ply.thickness);
    ply.angle = card.real(i + at + 2, "angle", 0);
    if (ply.material <= 0 || !(ply.thickness > 0)) card.fail("a ply needs a material and a thickness");
    property.plies.push_back(ply);
  }
  if (property.plies.empty()) card.fail("has no plies");
  if (lay == "SYM")
    for (std::size_t k = property.plies.size(); k-- > 0;) property.plies.push_back(property.plies[k]);
  for (const auto& one : property.plies) property.thickness += one.thickness;
  property.bottom = card.real(1, "Z0", -property.thickness / 2);
  add(model.shell_properties, card.label(0, "property"), std::move(property), card);
}

void read_solid_property(NastranModel& model, const NastranCard& card) {
  NastranSolidProperty property;
  property.place = model.place(card.mark);
  property.material = card.label(1, "material");
  if (!card.blank(2)) property.system = card.whole(2, "coordinate system");
  if (const std::string kind = capitals(card.field(6)); kind.find("FLUID") != std::string::npos)
    card.fail(fmt::format("FCTN = {} is a fluid, which is no body", shown(kind)));
  add(model.solid_properties, card.label(0, "property"), property, card);
}

void read_bar_property(NastranModel& model, const NastranCard& card) {
  NastranBarProperty property;
  property.place = model.place(card.mark);
  property.material = card.label(1, "material");
  NastranSection& section = property.section;
  section.area = card.real(2, "area");
  section.I1 = card.real(3, "moment of area");
  section.I2 = card.real(4, "moment of area");
  section.J = card.real(5, "torsion constant");
  section.mass = card.real(6, "mass by length");
  for (std::size_t i = 8; i < 16; i += 2) {
    section.reach_y = std::max(section.reach_y, std::abs(card.real(i, "stress point")));
    section.reach_z = std::max(section.reach_z, std::abs(card.real(i + 1, "stress point")));
  }
  section.shear1 = card.real(16, "shear factor");
  section.shear2 = card.real(17, "shear factor");
  section.I12 = card.real(18, "moment of area");
  add(model.bar_properties, card.label(0, "property"), property, card);
}

NastranSection mean(const NastranSection& a, const NastranSection& b) {
  NastranSection result = a;
  for (auto member : {&NastranSection::area, &NastranSection::I1, &NastranSection::I2, &NastranSection::I12,
                      &NastranSection::J, &NastranSection::mass})
    result.*member = (a.*member + b.*member) / 2;
  result.centroid = (a.centroid + b.centroid) / 2;
  return result;
}

bool same_size(const NastranSection& a, const NastranSection& b) {
  for (auto member : {&NastranSection::area, &NastranSection::I1, &NastranSection::I2, &NastranSection::I12,
                      &NastranSection::J})
    if (std::abs(a.*member - b.*member) > 1e-6 * std::abs(a.*member)) return false;
  return true;
}

/// Keeps the stations where they differ, with both ends among them.
void set_stations(NastranBarProperty& property, const NastranSection& first, const NastranSection& last,
                  std::vector<NastranStation> inner) {
  property.section = mean(first, last);
  bool tapered = !same_size(first, last) || first.centroid != last.centroid;
  for (const NastranStation& one : inner) tapered = tapered || !same_size(first, one.section);
  if (!tapered) return;
  std::erase_if(inner, [](const NastranStation& one) { return !(one.along > 0 && one.along < 1); });
  std::stable_sort(inner.begin(), inner.end(),
                   [](const NastranStation& a, const NastranStation& b) { return a.along < b.along; });
  inner.insert(inner.begin(), {0, first});
  inner.push_back({1, last});
  property.stations = std::move(inner);
}

bool is_station(const NastranCard& card, std::size_t i) {
  const std::string word = capitals(card.field(i));
  return word == "YES" || word == "YESA" || word == "NO";
}

void read_beam(NastranModel& model, const NastranCard& card) {
  NastranBarProperty property;
  property.place = model.place(card.mark);
  property.material = card.label(1, "material");
  NastranSection& section = property.section;
  const auto at = [&](std::size_t first, const NastranSection& missing) {
    NastranSection one;
    one.area = card.real(first, "area", missing.area);
    one.I1 = card.real(first + 1, "moment of area", missing.I1);
    one.I2 = card.real(first + 2, "moment of area", missing.I2);
    one.I12 = card.real(first + 3, "moment of area", missing.I12);
    one.J = card.real(first + 4, "torsion constant", missing.J);
    one.mass = card.real(first + 5, "mass by length", missing.mass);
    return one;
  };
  section = at(2, {});
  std::size_t line = 8;
  if (!is_station(card, line)) {
    for (std::size_t i = line; i < line + 8; i += 2) {
      section.reach_y = std::max(section.reach_y, std::abs(card.real(i, "stress point")));
      section.reach_z = std::max(section.reach_z, std::abs(card.real(i + 1, "stress point")));
    }
    line += 8;
  }
  NastranSection end = section;
  std::vector<NastranStation> stations;
  while (is_station(card, line)) {
    const bool stress = capitals(card.field(line)) == "YES";
    const double along = card.real(line + 1, "place along the beam");
    const NastranSection here = at(line + 2, section);
    if (along == 1 || card.blank(line + 1)) end = here;
    stations.push_back({card.blank(line + 1) ? 1 : along, here});
    line += 8;
    if (stress && !is_station(card, line)) line += 8;
  }
  // Blank: 1.
  section.shear1 = card.real(line, "shear factor", 1);
  section.shear2 = card.real(line + 1, "shear factor", 1);
  const double nsi = card.real(line + 4, "moment of inertia");
  if (nsi != 0) model.warn("NSI", card.mark, "the moment of inertia by length (NSI) is left out");
  section.centroid = {card.real(line + 12, "neutral axis"), card.real(line + 13, "neutral axis")};
  end.centroid = {card.real(line + 14, "neutral axis", section.centroid[0]),
                  card.real(line + 15, "neutral axis", section.centroid[1])};
  const auto complete = [&](NastranSection& one) {
    one.shear1 = section.shear1;
    one.shear2 = section.shear2;
    one.reach_y = section.reach_y;
    one.reach_z = section.reach_z;
  };
  complete(end);
  for (NastranStation& one : stations) {
    complete(one.section);
    one.section.centroid = section.centroid + one.along * (end.centroid - section.centroid);
  }
  set_stations(property, NastranSection(section), end, std::move(stations));
  add(model.bar_properties, card.label(0, "property"), property, card);
}

void read_shape(NastranModel& model, const NastranCard& card) {
  NastranBarProperty property;
  property.place = model.place(card.mark);
  property.material = card.label(1, "material");
  const std::string shape = capitals(card.field(3));
  const bool beam = card.name == "PBEAML";
  try {
    const std::size_t count = nastran_shape_sizes(shape);
    std::vector<double> sizes, end;
    for (std::size_t i = 0; i < count; ++i) sizes.push_back(card.real(8 + i, "size of the section"));
    property.section = nastran_section(shape, sizes);
    property.section.mass = card.real(8 + count, "mass by length");
    // Nodes of a CBAR are at the centroid, those of a CBEAM at the shear centre.
    const auto centre = nastran_shear_centre(shape, sizes);
    if (beam && !centre)
      model.warn("shear centre of " + shape, card.mark,
                 fmt::format("the shear centre of the section {} is taken to be its centroid", shape));
    if (beam && centre)
      property.section.centroid -= *centre;
    else
      property.section.centroid.setZero();
    std::size_t next = 8 + count + 1;
    const NastranSection first = property.section;
    NastranSection last = first;
    std::vector<NastranStation> stations;
    // SO, X/XB, sizes and mass of further stations.
    while (beam && (is_station(card, next) || !card.blank(next + 1))) {
      end = sizes;
      const double along = card.real(next + 1, "place along the beam", 1);
      for (std::size_t i = 0; i < count; ++i)
        end[i] = card.real(next + 2 + i, "size of the section", sizes[i]);
      NastranSection here = nastran_section(shape, end);
      here.mass = card.real(next + 2 + count, "mass by length", property.section.mass);
      if (const auto there = nastran_shear_centre(shape, end))
        here.centroid -= *there;
      else
        here.centroid.setZero();
      if (along == 1) last = here;
      stations.push_back({along, here});
      next += count + 3;
    }
    set_stations(property, first, last, std::move(stations));
  } catch (const std::invalid_argument& error) {
    card.fail(error.what());
  }
  add(model.bar_properties, card.label(0, "property"), property, card);
}

void read_rod_property(NastranModel& model, const NastranCard& card) {
  NastranBarProperty property;
  property.place = model.place(card.mark);
  property.material = card.label(1, "material");
  if (card.name == "PROD") {
    property.section.area = card.real(2, "area");
    property.section.J = card.real(3, "torsion constant");
    property.section.mass = card.real(5, "mass by length");
  } else {
    const double outer = card.real(2, "outer diameter"), wall = card.real(3, "thickness", outer / 2);
    const double second = card.real(5, "outer diameter", outer);
    if (!(outer > 0 && second > 0 && wall > 0 && 2 * wall <= std::min(outer, second) * (1 + 1e-12)))
      card.fail("the diameters and the thickness are those of no tube");
    const auto tube = [&](double d) { return nastran_section("TUBE", {d / 2, std::max(0.0, d / 2 - wall)}); };
    property.section = mean(tube(outer), tube(second));
    property.section.mass = card.real(4, "mass by length");
  }
  add(model.bar_properties, card.label(0, "property"), property, card);
}

void read_panel_property(NastranModel& model, const NastranCard& card) {
  NastranPanelProperty property;
  property.place = model.place(card.mark);
  property.material = card.label(1, "material");
  property.thickness = card.real(2, "thickness");
  property.mass = card.real(3, "mass by area");
  if (!(property.thickness > 0)) card.fail("a thickness must be positive");
  for (std::size_t k = 0; k < 2; ++k) {
    property.rods[k] = card.real(4 + k, "factor of effectiveness");
    if (!(property.rods[k] >= 0)) card.fail("a factor of effectiveness must not be negative");
  }
  add(model.panel_properties, card.label(0, "property"), property, card);
}

void read_springs(NastranModel& model, const NastranCard& card) {
  for (const std::size_t first : {std::size_t{0}, std::size_t{4}}) {
    if (card.blank(first)) continue;
    add(model.spring_properties, card.label(first, "property"), card.real(first + 1, "stiffness"), card);
  }
}

void read_masses(NastranModel& model, const NastranCard& card) {
  for (std::size_t first = 0; first < 8; first += 2)
    if (!card.blank(first))
      add(model.mass_properties, card.label(first, "property"), card.real(first + 1, "mass"), card);
}

void read_bushing(NastranModel& model, const NastranCard& card) {
  std::array<double, 6> stiffness{};
  // Lines K, B, GE, RCV, M, each behind its flag.
  bool rigid = false;
  for (std::size_t i = 1; i < card.fields.size(); i += 8) {
    if (capitals(card.field(i)) != "K") continue;
    for (std::size_t k = 0; k < 6; ++k) {
      if (capitals(card.field(i + 1 + k)) == "RIGID")
        rigid = true;
      else
        stiffness[k] = card.real(i + 1 + k, "stiffness");
    }
  }
  if (rigid) card.fail("RIGID is not read; give a stiffness or use RBAR");
  add(model.bush_properties, card.label(0, "property"), stiffness, card);
}

}  // namespace

bool read_nastran_property(NastranModel& model, const NastranCard& card) {
  const std::string& name = card.name;
  if (name == "MAT1") {
    read_isotropic(model, card);
  } else if (name == "MAT2") {
    read_sheet(model, card);
  } else if (name == "MAT8") {
    read_orthotropic_sheet(model, card);
  } else if (name == "MAT9") {
    read_solid_matrix(model, card);
  } else if (name == "MAT11") {
    read_orthotropic_solid(model, card);
  } else if (name == "MAT3" || name == "MAT10" || name.starts_with("MATH") || name == "MATDIGI") {
    model.other_materials[card.label(0, "material")] = name;
  } else if (name == "PSHELL") {
    read_shell_property(model, card);
  } else if (name == "PCOMP") {
    read_laminate(model, card, 4, 0);
  } else if (name == "PCOMPG") {
    read_laminate(model, card, 8, 1);
  } else if (name == "PSOLID") {
    read_solid_property(model, card);
  } else if (name == "PBAR") {
    read_bar_property(model, card);
  } else if (name == "PBEAM") {
    read_beam(model, card);
  } else if (name == "PBARL" || name == "PBEAML") {
    read_shape(model, card);
  } else if (name == "PROD" || name == "PTUBE") {
    read_rod_property(model, card);
  } else if (name == "PSHEAR") {
    read_panel_property(model, card);
  } else if (name == "PELAS") {
    read_springs(model, card);
  } else if (name == "PMASS") {
    read_masses(model, card);
  } else if (name == "PBUSH") {
    read_bushing(model, card);
  } else if (name == "PLSOLID" || name == "PLPLANE" || name == "PCOMPS" || name == "PCOMPLS" ||
             name == "PBCOMP" || name == "PBMSECT" || name == "PBRSECT" || name == "PBEND" ||
             name == "PSHLN1" || name == "PSHLN2" || name == "PSLDN1" || name == "PBEAM3" ||
             name == "PBUSH1D" || name == "PBUSH2D") {
    model.other_properties[card.label(0, "property")] = name;
  } else {
    return false;
  }
  return true;
}

}  // namespace mimbre::fe
