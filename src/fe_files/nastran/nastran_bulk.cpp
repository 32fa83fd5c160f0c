#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "fe_files/nastran/nastran_model.h"
#include "fe_files/text.h"

// MSC Nastran Quick Reference Guide, "Case Control" and "Bulk Data".

namespace mimbre::fe {

namespace {

constexpr std::size_t kMostErrors = 1000;
constexpr std::size_t kLongestStatement = std::size_t{1} << 20;

bool one_of(std::string_view name, std::initializer_list<std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool begins_with_one_of(std::string_view name, std::initializer_list<std::string_view> heads) {
  return std::any_of(heads.begin(), heads.end(),
                     [&](std::string_view head) { return name.starts_with(head); });
}

void read_grid(NastranModel& model, const NastranCard& card) {
  NastranGrid grid;
  grid.label = card.label(0, "node number");
  grid.position_system = card.blank(1) ? -1 : card.whole(1, "coordinate system");
  grid.coordinates = card.vector(2, "coordinate");
  grid.displacement_system = card.blank(5) ? -2 : card.whole(5, "coordinate system");
  if (grid.displacement_system == -1)
    card.fail("displacements in system -1 are those of a fluid, which is no body");
  grid.place = model.place(card.mark);
  if (!card.blank(6) && card.components(6) != 0) {
    model.sets["GRID:PS"].push_back({grid.label, grid.label});
    model.warn("PS", card.mark,
               "constraints of GRID (PS) are left out: a body is free; the nodes are the set GRID:PS");
  }
  model.grids.push_back(grid);
}

void read_grid_defaults(NastranModel& model, const NastranCard& card) {
  if (model.grid_defaults) card.fail("GRDSET is there twice");
  model.grid_defaults = {card.whole(1, "coordinate system", 0), card.whole(5, "coordinate system", 0)};
}

/// Fields of labels with THRU between the first and the last of a range.
void read_labels(const NastranCard& card, std::size_t first, std::vector<NastranRange>& ranges) {
  for (std::size_t i = first; i < card.fields.size(); ++i) {
    if (card.blank(i)) continue;
    const std::string word = capitals(card.field(i));
    if (word == "THRU" || word == "BY" || word == "EXCEPT") {
      if (word != "THRU" || ranges.empty() || i == first) continue;  // no list of nodes
      ranges.back()[1] = std::max<std::int64_t>(ranges.back()[0], card.label(++i, "last node"));
      continue;
    }
    if (word == "ALL" || word == "SKIN") continue;
    const auto label = to_integer(word);
    if (label && *label > 0) ranges.push_back({*label, *label});
  }
}

/// Cards that only name nodes: what they do with them is left out, the names stay.
bool read_set(NastranModel& model, const NastranCard& card) {
  const auto set = [&](std::string_view name, std::size_t field) -> std::vector<NastranRange>& {
    return model.sets[fmt::format("{}:{}", name, card.label(field, "set number"))];
  };
  const std::string& name = card.name;
  if (name == "SPC1") {
    read_labels(card, 2, set("SPC", 0));
  } else if (name == "SPC") {
    for (std::size_t i = 1; i < card.fields.size(); i += 3)
      if (!card.blank(i)) {
        const std::int64_t label = card.label(i, "node");
        set("SPC", 0).push_back({label, label});
      }
  } else if (name == "SET1") {
    read_labels(card, 1, set("SET1", 0));
  } else if (one_of(name, {"ASET1", "BSET1", "CSET1", "SUPORT1"})) {
    read_labels(card, 1, model.sets[name.substr(0, name.size() - 1)]);
  } else if (one_of(name, {"ASET", "BSET", "CSET", "SUPORT"})) {
    for (std::size_t i = 0; i < card.fields.size(); i += 2)
      if (!card.blank(i)) {
        const std::int64_t label = card.label(i, "node");
        model.sets[name].push_back({label, label});
      }
  } else {
    return false;
  }
  if (name == "SPC" || name == "SPC1")
    model.warn("SPC", card.mark,
               name + " is left out: a body is free, and its interfaces hold it; its nodes are a set");
  return true;
}

void read_parameter(NastranModel& model, const NastranCard& card) {
  const std::string name = capitals(card.field(0));
  if (name == "WTMASS") {
    model.mass_factor = card.real(1, "factor of mass", 1);
    if (!(model.mass_factor > 0)) card.fail("the factor of mass must be positive");
  }
}

void read_scalar_points(NastranModel& model, const NastranCard& card) {
  read_labels(card, 0, model.scalar_points);
}

/// Nothing of the body's mass and stiffness: loads, steps, output, temperatures, aerodynamics, optimization.
bool is_silent_card(std::string_view name) {
  return begins_with_one_of(
             name, {"FORCE",   "MOMENT",  "PLOAD",   "TEMP",    "EIG",     "FREQ",   "TSTEP",   "TLOAD",
                    "RLOAD",   "TABLE",   "DESVAR",  "DRESP",   "DVPREL",  "DVMREL", "DVCREL",  "DCONSTR",
                    "DEQATN",  "DOPTPRM", "DLINK",   "AERO",    "CAERO",   "PAERO",  "SPLINE",  "MKAERO",
                    "FLUTTER", "FLFACT",  "TRIM",    "AELINK",  "AESTAT",  "AESURF", "AELIST",  "AECOMP",
                    "AEPARM",  "AEFACT",  "AEFORCE", "AEPRESS", "CSSCHD",  "GUST",   "MONPNT",  "MONDSP",
                    "MONSUM",  "SPCADD",  "SPCD",    "SPCAX",   "DAREA",   "DLOAD",  "DPHASE",  "DELAY",
                    "LSEQ",    "RAND",    "NLPARM",  "SUPAX",   "DIVERG",  "PLOTEL", "PARAM",   "SET",
                    "OMIT",    "QSET",    "USET",    "SESET",   "SEB",     "SEC",    "SEQ",     "RELEASE",
                    "SENQSET", "SELABEL", "MDLPRM",  "ECHO",    "ACMODL",  "MATT",   "MATS",    "PSET",
                    "OUTPUT",  "POINT",   "GMCURV",  "FEEDGE",  "VIEW",    "RADSET", "RADM",    "RADBC",
                    "RADLST",  "RADMTX",  "QBDY",    "QVECT",   "QVOL",    "QHBDY",  "CHBDY",   "CONV",
                    "PCONV",   "PHBDY",   "BDYOR",   "NOLIN",   "TIC",     "TF",     "DTI",     "DMI",
                    "ROTOR",   "RGYRO",   "RSPIN",   "UNBAL",   "MONCNCM", "GRAV",   "RFORCE",  "ACCEL",
                    "LOAD",    "CLOAD",   "SLOAD",   "DEFORM",  "SWLDPRM", "DYNRED", "MODTRAK", "DSCREEN",
                    "TOPVAR",  "DSHAPE",  "BNDFR",   "BNDFIX",  "BNDGRID", "BFRIC",  "BOUTPUT", "STRN",
                    "PANEL",   "WETSURF", "WETLOAD"}) ||
         one_of(name, {"EXTRN",    "CBARAO",  "DVGRID", "DVBSHAP", "DVSHAP",  "SNORM",  "CYJOIN", "CYSYM",
                       "CYAX",     "CYSUP",   "AEGRID", "AEQUAD4", "AETRIA3", "UXVEC",  "MAT4",   "MAT5",
                       "IPSTRAIN", "ISTRESS", "VARIAN", "EPOINT",  "GEOM",    "CAABSF", "PAABSF"});
}

struct LeftOut {
  std::string_view head, why;
};
/// What has to do with the body and is left out all the same.
constexpr LeftOut kLeftOut[] = {
    {"CDAMP", "dampers are left out: a body's damping is that of the reduction (--damping)"},
    {"PDAMP", ""},
    {"CVISC", "dampers are left out: a body's damping is that of the reduction (--damping)"},
    {"PVISC", ""},
    {"CGAP", "gaps are left out: a body is linear"},
    {"PGAP", ""},
    {"BCTABLE", "contact is left out: a body is linear"},
    {"BCTSET", "contact is left out: a body is linear"},
    {"BCTADD", "contact is left out: a body is linear"},
    {"BSURF", ""},
    {"BCPROP", ""},
    {"BCTPARM", ""},
    {"BCPARA", ""},
    {"BCBODY", ""},
    {"BCONP", "contact is left out: a body is linear"},
    {"BLSEG", ""},
    {"BWIDTH", ""},
    {"BCRPARA", ""},
    {"BOLT", "the force in a bolt is left out: a body is without initial stress"},
    {"SEBULK", "superelements are left out: the residual structure alone is the body"},
    {"DMIG", ""},
    {"DMIJ", ""},
    {"DMIK", ""},
    {"DMIA", ""},
    {"PDAMPT", ""},
    {"PBUSHT", "how a bushing depends on frequency or force is left out"},
    {"PELAST", "how a spring depends on frequency or force is left out"},
    {"PFAST", ""},
    {"PWELD", ""},
};

void read_matrix_head(NastranModel& model, const NastranCard& card) {
  if (card.field(1) != "0") return;
  const std::string name = capitals(card.field(0));
  if (std::find(model.matrices.begin(), model.matrices.end(), name) == model.matrices.end())
    model.matrices.push_back(name);
}

void read_other(NastranModel& model, const NastranCard& card) {
  const std::string& name = card.name;
  if (name == "DMIG") read_matrix_head(model, card);
  for (const LeftOut& one : kLeftOut)
    if (name.starts_with(one.head)) {
      if (!one.why.empty()) model.warn(std::string(one.head), card.mark, std::string(one.why));
      return;
    }
  if (is_silent_card(name)) return;
  if (name.starts_with('=') || name.empty())
    card.fail("cards made by replication (=) are not read; write them out");
  // Elements and ties, which the body would lack.
  if (begins_with_one_of(
          name, {"C", "RBE", "RBAR", "RTRPLT", "RSPLINE", "RSSCON", "RJOINT", "GENEL", "SPCR", "NSM"}))
    card.fail("is not read, and the body would lack it");
  model.warn("card " + name, card.mark, shown(name) + " is not read");
}

std::string described(const NastranCard& card) {
  return card.blank(0) || card.name.size() > 8 ? shown(card.name)
                                               : fmt::format("{} {}", shown(card.name), shown(card.field(0)));
}

}  // namespace

NastranPlace NastranModel::place(const Mark& at) {
  if (files.empty() || files.back() != at.file) {
    const auto found = std::find(files.begin(), files.end(), at.file);
    if (found != files.end()) return {static_cast<int>(found - files.begin()), at.line};
    files.push_back(at.file);
  }
  return {static_cast<int>(files.size()) - 1, at.line};
}

Mark NastranModel::mark(const NastranPlace& at) const {
  return {at.file < static_cast<int>(files.size()) ? files[static_cast<std::size_t>(at.file)] : std::string(),
          at.line, 1};
}

void NastranModel::error(const Mark& at, std::string message) {
  if (errors.size() < kMostErrors)
    errors.push_back({at, std::move(message)});
  else
    ++more_errors;
}

void NastranModel::warn(const std::string& key, const Mark& at, std::string message) {
  if (left_out[key]++ == 0) warnings.push_back({at, std::move(message)});
}

bool NastranModel::is_scalar_point(std::int64_t label) const {
  return std::any_of(scalar_points.begin(), scalar_points.end(),
                     [&](const NastranRange& range) { return range[0] <= label && label <= range[1]; });
}

void read_nastran_bulk(NastranLines& lines, NastranModel& model) {
  NastranCards cards(lines);
  NastranCard card;
  bool any = false;
  while (cards.next(card)) {
    if (card.name.starts_with("BEGIN")) {
      // BEGIN BULK twice in a row
      if (!any && card.name == "BEGIN BU" && capitals(card.field(0)) == "LK") continue;
      model.error(
          card.mark,
          "parts with bulk data of their own (BEGIN SUPER) are not read; give each as a deck of its own");
      return;
    }
    any = true;
    try {
      if (card.name == "GRID")
        read_grid(model, card);
      else if (card.name == "GRDSET")
        read_grid_defaults(model, card);
      else if (card.name == "PARAM")
        read_parameter(model, card);
      else if (card.name == "SPOINT")
        read_scalar_points(model, card);
      else if (model.grids_only && card.name != "DMIG")
        model.systems.read(card);
      else if (!read_nastran_element(model, card) && !read_nastran_property(model, card) &&
               !read_nastran_tie(model, card) && !model.systems.read(card) && !read_set(model, card))
        read_other(model, card);
    } catch (const InputError& error) {
      for (const Diagnostic& one : error.diagnostics())
        model.error(one.mark, fmt::format("{}: {}", described(card), one.message));
    }
  }
}

namespace {

/// One statement of the case control with what goes on behind a comma.
void read_statement(std::string statement, const Mark& mark, NastranModel& model) {
  const std::size_t equals = statement.find('=');
  if (equals == std::string::npos) return;
  std::string_view head = trimmed(std::string_view(statement).substr(0, equals));
  head = head.substr(0, head.find('('));
  std::string_view value = trimmed(std::string_view(statement).substr(equals + 1));
  const std::string name = capitals(trimmed(head));
  if (name == "MPC") {
    if (const auto set = to_integer(value)) model.equation_sets.push_back(*set);
  } else if (name == "K2GG" || name == "M2GG") {
    model.warn(name, mark,
               fmt::format("{} is left out: matrices beside elements are not added to them", name));
  } else if (name.starts_with("SET ") || name.starts_with("SET\t")) {
    const auto number = to_integer(trimmed(std::string_view(name).substr(4)));
    if (!number) return;
    std::vector<NastranRange>& ranges = model.sets[fmt::format("SET:{}", *number)];
    while (!value.empty()) {
      std::string_view field = next_field(value);
      const auto first = to_integer(next_word(field));
      if (!first) return;  // ALL, EXCEPT, names: not a list of nodes
      std::int64_t last = *first;
      if (const std::string_view thru = next_word(field); !thru.empty()) {
        const auto end = to_integer(next_word(field));
        if (capitals(thru) != "THRU" || !end) return;
        last = *end;
      }
      ranges.push_back({*first, last});
    }
  }
}

}  // namespace

bool read_nastran_control(NastranLines& lines, NastranModel& model) {
  std::string_view line;
  std::string statement;
  Mark mark;
  while (lines.next(line)) {
    line = trimmed(line.substr(0, line.find('$')));
    if (line.size() >= 5 && lower(line.substr(0, 5)) == "begin") {
      std::string_view rest = trimmed(line.substr(5));
      if (rest.empty() || lower(rest.substr(0, 4)) == "bulk" || lower(rest.substr(0, 5)) == "super")
        return true;
    }
    if (line.empty()) continue;
    if (statement.empty()) mark = lines.mark();
    if (statement.size() < kLongestStatement) statement += line;
    if (line.ends_with(',')) continue;
    read_statement(std::move(statement), mark, model);
    statement.clear();
  }
  return false;
}

}  // namespace mimbre::fe
