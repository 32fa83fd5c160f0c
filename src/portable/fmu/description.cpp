#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "mimbre/build.h"
#include "mimbre/spec.h"
#include "portable/fmu/parts.h"
#include "portable/fmu/xml.h"

namespace mimbre {
namespace portable {
namespace {

using Role = FmuVariable::Role;

void set_true(pugi::xml_node node, std::initializer_list<const char*> names) {
  for (const char* name : names) set(node, name, std::string("true"));
}

class Description {
 public:
  Description(const FmuCode& fmu, const Model& model, bool with_sources)
      : fmu_(fmu), model_(model), with_sources_(with_sources) {}

  std::string text() {
    root_ = begin_xml(document_, "fmiModelDescription");
    set(root_, "fmiVersion", std::string(two() ? "2.0" : "3.0"));
    set(root_, "modelName", one_line(model_.spec().title.empty() ? fmu_.code.name : model_.spec().title));
    set(root_, two() ? "guid" : "instantiationToken", fmu_.token);
    set(root_, "description", one_line(model_.spec().title));
    set(root_, "generationTool", fmt::format("mimbre {}", build_info().version));
    set(root_, "variableNamingConvention", std::string("flat"));
    if (two() && exchange()) set(root_, "numberOfEventIndicators", fmt::format("{}", fmu_.code.indicators));
    interface();
    units();
    categories();
    pugi::xml_node experiment = root_.append_child("DefaultExperiment");
    set(experiment, "startTime", 0.0);
    set(experiment, "stopTime", model_.spec().simulation.end);
    if (exchange())
      set(experiment, "tolerance", 1e-8);
    else
      set(experiment, "stepSize", fmu_.code.step);
    pugi::xml_node variables = root_.append_child("ModelVariables");
    for (const FmuVariable& v : fmu_.variables)
      two() ? variable_of_2(variables, v) : variable_of_3(variables, v);
    structure();
    return text_of(document_);
  }

 private:
  bool two() const { return fmu_.version == 2; }
  bool exchange() const { return fmu_.kind == FmuOptions::Kind::model_exchange; }

  void interface() {
    pugi::xml_node kind = root_.append_child(exchange() ? "ModelExchange" : "CoSimulation");
    set(kind, "modelIdentifier", fmu_.code.name);
    if (exchange())
      set(kind, two() ? "completedIntegratorStepNotNeeded" : "needsCompletedIntegratorStep",
          std::string(two() ? "true" : "false"));
    if (!exchange()) set_true(kind, {"canHandleVariableCommunicationStepSize"});
    if (fmu_.code.varies)
      set_true(kind, {two() ? "providesDirectionalDerivative" : "providesDirectionalDerivatives"});
    if (!two()) {
      set_true(kind, {"canGetAndSetFMUState", "canSerializeFMUState"});
      if (!exchange()) set(kind, "fixedInternalStepSize", fmu_.code.step);
      if (fmu_.code.events > 0) set_true(kind, {"hasEventMode", "mightReturnEarlyFromDoStep"});
      return;
    }
    set_true(kind, {"canGetAndSetFMUstate", "canSerializeFMUstate"});
    if (!with_sources_) return;
    pugi::xml_node files = kind.append_child("SourceFiles");
    set(files.append_child("File"), "name", fmu_.code.name + ".c");
    set(files.append_child("File"), "name", fmu_wrapper_file(fmu_));
  }

  void units() {
    std::set<std::string> names;
    for (const FmuVariable& v : fmu_.variables)
      if (!v.unit.empty()) names.insert(v.unit);
    pugi::xml_node list = root_.append_child("UnitDefinitions");
    for (const std::string& name : names) {
      const SiUnit of = si_unit(name);
      pugi::xml_node unit = list.append_child("Unit");
      set(unit, "name", one_line(name));
      if (!of.known) continue;
      pugi::xml_node base = unit.append_child("BaseUnit");
      for (const auto& [word, exponent] :
           {std::pair("kg", of.kg), {"m", of.m}, {"s", of.s}, {"A", of.A}, {"rad", of.rad}})
        if (exponent != 0) base.append_attribute(word).set_value(exponent);
      if (of.factor != 1) set(base, "factor", of.factor);
      for (const auto& [other, factor] : of.others) {
        pugi::xml_node shown = unit.append_child("DisplayUnit");
        set(shown, "name", other);
        set(shown, "factor", factor);
      }
    }
  }

  void categories() {
    pugi::xml_node list = root_.append_child("LogCategories");
    for (const auto& [name, meaning] :
         {std::pair("logStatusWarning", "what is made, but not quite as it was asked for"),
          {"logStatusDiscard", "steps that the model cannot make"},
          {"logStatusError", "calls that are refused"}}) {
      pugi::xml_node category = list.append_child("Category");
      set(category, "name", std::string(name));
      set(category, "description", std::string(meaning));
    }
  }

  static const char* causality(Role role) {
    switch (role) {
      case Role::time:
        return "independent";
      case Role::input:
        return "input";
      case Role::parameter:
      case Role::fixed:
        return "parameter";
      case Role::derived:
        return "calculatedParameter";
      case Role::state:
      case Role::derivative:
      case Role::indicator:
        return "local";
      default:
        return "output";
    }
  }
  static const char* variability(Role role) {
    switch (role) {
      case Role::parameter:
        return "tunable";
      case Role::fixed:
      case Role::derived:
        return "fixed";
      case Role::count:
        return "discrete";
      default:
        return "continuous";
    }
  }
  static const char* initial(Role role) {
    if (role == Role::parameter || role == Role::fixed) return "exact";
    return role == Role::time || role == Role::input ? "" : "calculated";
  }
  static bool starts(Role role) {
    return role == Role::input || role == Role::parameter || role == Role::fixed;
  }

  void common(pugi::xml_node node, const FmuVariable& v) {
    set(node, "name", one_line(v.name));
    node.append_attribute("valueReference").set_value(v.reference);
    if (!v.meaning.empty()) set(node, "description", one_line(v.meaning));
    set(node, "causality", std::string(causality(v.role)));
    set(node, "variability", std::string(variability(v.role)));
    if (*initial(v.role)) set(node, "initial", std::string(initial(v.role)));
  }
  void value(pugi::xml_node node, const FmuVariable& v) {
    if (!v.unit.empty()) set(node, "unit", one_line(v.unit));
    if (v.unit == "rad") set(node, "displayUnit", std::string("deg"));
    if (v.role == Role::derivative) set(node, "derivative", listed({v.state}));
    if (!starts(v.role)) return;
    const auto number = [&](const char* name, double value) {
      v.integer ? set(node, name, fmt::format("{:.0f}", value)) : set(node, name, value);
    };
    if (std::isfinite(v.min)) number("min", v.min);
    if (std::isfinite(v.max)) number("max", v.max);
    number("start", v.start);
  }
  void variable_of_2(pugi::xml_node list, const FmuVariable& v) {
    pugi::xml_node node = list.append_child("ScalarVariable");
    common(node, v);
    value(node.append_child(v.integer ? "Integer" : "Real"), v);
  }
  void variable_of_3(pugi::xml_node list, const FmuVariable& v) {
    pugi::xml_node node = list.append_child(v.integer ? "Int32" : "Float64");
    common(node, v);
    value(node, v);
    if (v.outputs.size() > 1)
      node.append_child("Dimension")
          .append_attribute("start")
          .set_value(static_cast<unsigned>(v.outputs.size()));
  }

  /// FMI 2 counts variables from 1 in their order, FMI 3 has their references.
  std::string listed(const std::vector<unsigned>& references) const {
    std::string text;
    for (const unsigned r : references)
      text += fmt::format("{}{}", text.empty() ? "" : " ", two() ? r + 1 : r);
    return text;
  }
  void unknown(pugi::xml_node node, const FmuVariable& v, bool with_dependencies) {
    if (two())
      node.append_attribute("index").set_value(v.reference + 1);
    else
      node.append_attribute("valueReference").set_value(v.reference);
    if (with_dependencies && !v.depends_on_all) set(node, "dependencies", listed(v.dependencies));
  }
  /// `group`: in FMI 2 the unknowns are in such an element, which must not be empty; in FMI 3 they are called
  /// `name`.
  void unknowns(pugi::xml_node all, const char* group, const char* name, bool with_dependencies,
                std::initializer_list<Role> roles) {
    pugi::xml_node list = two() ? pugi::xml_node() : all;
    for (const FmuVariable& v : fmu_.variables) {
      if (std::find(roles.begin(), roles.end(), v.role) == roles.end()) continue;
      if (!list) list = all.append_child(group);
      unknown(list.append_child(two() ? "Unknown" : name), v, with_dependencies);
    }
  }
  void structure() {
    pugi::xml_node all = root_.append_child("ModelStructure");
    unknowns(all, "Outputs", "Output", true, {Role::output, Role::count});
    unknowns(all, "Derivatives", "ContinuousStateDerivative", true, {Role::derivative});
    unknowns(all, "InitialUnknowns", "InitialUnknown", false,
             {Role::output, Role::derived, Role::count, Role::state, Role::derivative});
    if (!two()) unknowns(all, "", "EventIndicator", true, {Role::indicator});
  }

  const FmuCode& fmu_;
  const Model& model_;
  const bool with_sources_;
  pugi::xml_document document_;
  pugi::xml_node root_;
};

}  // namespace

std::string fmu_build_description(const FmuCode& fmu) {
  pugi::xml_document document;
  pugi::xml_node root = begin_xml(document, "fmiBuildDescription");
  set(root, "fmiVersion", std::string("3.0"));
  pugi::xml_node build = root.append_child("BuildConfiguration");
  set(build, "modelIdentifier", fmu.code.name);
  pugi::xml_node sources = build.append_child("SourceFileSet");
  set(sources, "language", std::string("C99"));
  set(sources.append_child("SourceFile"), "name", fmu.code.name + ".c");
  set(sources.append_child("SourceFile"), "name", fmu_wrapper_file(fmu));
  return text_of(document);
}

}  // namespace portable

std::string fmu_description(const FmuCode& fmu, const Model& model, bool with_sources) {
  return portable::Description(fmu, model, with_sources).text();
}

}  // namespace mimbre
