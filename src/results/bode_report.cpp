#include <fmt/format.h>

#include <numbers>

#include "mimbre/diagnostics.h"
#include "mimbre/linear_report.h"
#include "mimbre/usage_error.h"
#include "results/report_json.h"
#include "results/report_page.h"

namespace mimbre {
namespace {

using results::Json;

Json names_json(const std::vector<LinearName>& names) {
  Json list = Json::array();
  for (const LinearName& n : names) list.push_back({{"name", n.name}, {"unit", n.unit}});
  return list;
}

void require_responses(const LinearModel& m, const std::vector<double>& frequencies) {
  const auto bad = [](const std::string& what) { throw InputError(Mark{}, "Bode plots: " + what); };
  if (m.inputs.empty())
    bad("the model has no inputs to which something could respond; `inputs` or tunable parameters add some");
  if (m.outputs.empty()) bad("the model has no outputs that could respond; `outputs` adds some");
  if (frequencies.size() < 2) bad("two frequencies or more are needed");
}

Json data_json(const LinearModel& m, const std::vector<double>& frequencies) {
  require_responses(m, frequencies);
  // Of the first input all outputs, of each its values at all frequencies; then the second input.
  const auto count = static_cast<Eigen::Index>(frequencies.size());
  Eigen::MatrixXd real(count, m.D.size()), imaginary(count, m.D.size());
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::VectorXcd response =
        frequency_response(m, 2 * std::numbers::pi * frequencies[static_cast<std::size_t>(k)]).reshaped();
    real.row(k) = response.real().transpose();
    imaginary.row(k) = response.imag().transpose();
  }
  const auto packed = [](const Eigen::MatrixXd& values) {
    const auto all = values.reshaped();
    return results::array_of(std::vector<double>(all.begin(), all.end()));
  };
  return {{"format", "mimbre-bode-1"},
          {"title", m.title},
          {"point", m.point},
          {"notes", m.notes},
          {"warnings", m.warnings},
          {"inputs", names_json(m.inputs)},
          {"outputs", names_json(m.outputs)},
          {"frequencies", results::array_of(frequencies)},
          {"real", packed(real)},
          {"imaginary", packed(imaginary)}};
}

}  // namespace

std::string bode_html(const LinearModel& model, const std::vector<double>& frequencies) {
  return results::page_with(data_json(model, frequencies));
}

void check_linear_path(const std::string& path, const std::vector<double>& frequencies) {
  const auto ends = [&](const char* ending) { return path.ends_with(ending); };
  if (!ends(".html") && !ends(".h5") && !ends(".mat") && !ends(".json"))
    throw UsageError(fmt::format("'{}' ends with no format that is known: .html, .h5, .mat or .json", path));
  if (ends(".html") && frequencies.size() < 2)
    throw UsageError(fmt::format("'{}': a page of Bode plots needs --frequencies, as 0.1:100:200", path));
}

void write_linear_file(const LinearModel& model, const std::string& path,
                       const std::vector<double>& frequencies) {
  check_linear_path(path, frequencies);
  if (!path.ends_with(".html")) return write_linear_model(model, path, frequencies);
  results::write_page(bode_html(model, frequencies), path);
}

}  // namespace mimbre
