#include <fmt/format.h>

#include <cmath>

#include "mimbre/build.h"
#include "mimbre/model.h"
#include "mimbre/spec.h"
#include "portable/fmu/parts.h"

namespace mimbre::portable {
namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '&'   ? "&amp;"
           : c == '<' ? "&lt;"
           : c == '>' ? "&gt;"
           : c == '"' ? "&quot;"
                      : std::string(1, c);
  return out;
}

std::string range(const FmuVariable& v) {
  const auto end = [](double x) { return std::isfinite(x) ? fmt::format("{}", x) : std::string("…"); };
  return std::isfinite(v.min) || std::isfinite(v.max) ? end(v.min) + " to " + end(v.max) : std::string();
}

const char* kind(FmuVariable::Role role) {
  using Role = FmuVariable::Role;
  switch (role) {
    case Role::time:
      return "";
    case Role::input:
      return "input";
    case Role::fixed:
      return "fixed parameter";
    case Role::derived:
      return "parameter that follows from others";
    case Role::parameter:
      return "tunable parameter";
    case Role::state:
      return "state: ";
    case Role::derivative:
      return "derivative";
    case Role::indicator:
      return "event indicator: ";
    default:
      return "output: ";
  }
}

std::string text_of_steps(const FmuCode& fmu) {
  return fmt::format(
      "<p>Communication steps may have any positive length. At whole multiples of {0} s outputs are those of "
      "the model, "
      "exactly. Elsewhere the model has gone on to the end of its step: outputs are on the straight line "
      "between the "
      "last two of its instants, off by {1:.3g} s² times their second derivative at most, and inputs count "
      "from the end "
      "of that step on.</p>\n",
      fmu.code.step, fmu.code.step * fmu.code.step / 8);
}

std::string text_of_exchange() {
  return "<p>The importer's solver makes the steps. States are independent coordinates, their rates, and the "
         "states of controllers and force elements. Where an event indicator becomes negative, an event "
         "chooses other coordinates. Functions of time announce their jumps and kinks.</p>\n";
}

}  // namespace

std::string fmu_page(const FmuCode& fmu, const Model& model, const std::string& method) {
  using Role = FmuVariable::Role;
  const bool exchange = fmu.kind == FmuOptions::Kind::model_exchange;
  const std::string title = escaped(model.spec().title.empty() ? fmu.code.name : model.spec().title);
  std::string page = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta "
      "charset=\"utf-8\"><title>{0}</title>\n<style>body{{font-family:"
      "sans-serif;max-width:60rem;margin:2rem auto;padding:0 "
      "1rem}}table{{border-collapse:collapse}}td,th{{padding:"
      ".2rem .8rem;border-bottom:1px solid #ccc;text-align:left}}</style></head>\n<body><h1>{0}</h1>\n"
      "<p>FMI {1}.0, {2}. Made by mimbre {3} {6}{4}; {5} bytes {7}.</p>\n",
      title, fmu.version, exchange ? "model exchange" : "co-simulation", escaped(build_info().version),
      exchange           ? std::string()
      : fmu.with_library ? fmt::format(": {}. Steps of {} s", escaped(method), fmu.code.step)
                         : fmt::format(": {}. Steps of {} s with a fixed cost, {} operations at most",
                                       escaped(method), fmu.code.step, fmu.code.operations),
      fmu.code.bytes, fmu.with_library ? "with its library inside" : "as C99",
      fmu.with_library ? "a state" : "an instance");
  page += exchange ? text_of_exchange() : text_of_steps(fmu);
  page += "<table><tr><th>variable</th><th>unit</th><th>meaning</th><th>start</th><th>range</th></tr>\n";
  for (const FmuVariable& v : fmu.variables) {
    const bool starts = v.role == Role::input || v.role == Role::parameter || v.role == Role::fixed;
    page += fmt::format("<tr><td>{}</td><td>{}</td><td>{}{}</td><td>{}</td><td>{}</td></tr>\n",
                        escaped(v.name) + (v.outputs.size() > 1 ? fmt::format("[{}]", v.outputs.size()) : ""),
                        escaped(v.unit), kind(v.role),
                        v.role == Role::input || v.role == Role::parameter ? "" : escaped(v.meaning),
                        starts ? fmt::format("{}", v.start) : "", range(v));
  }
  page += "</table>\n";
  if (!fmu.code.left_out.empty()) {
    page += "<p>Outputs of the model that the FMU does not have:</p><ul>\n";
    for (const std::string& name : fmu.code.left_out) page += fmt::format("<li>{}</li>\n", escaped(name));
    page += "</ul>\n";
  }
  return page + "</body></html>\n";
}

}  // namespace mimbre::portable
