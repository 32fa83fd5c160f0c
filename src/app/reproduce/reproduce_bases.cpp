#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "app/commands/interfaces.h"
#include "app/reproduce/reproduce_rows.h"
#include "app/terminal/interrupts.h"
#include "mimbre/fe_import.h"
#include "mimbre/fe_reduce.h"
#include "mimbre/mode_selection.h"
#include "mimbre/model_file.h"
#include "mimbre/simulation.h"

/// Bases that chapter 1 of the thesis surveys, compared on the solid arm: alone in its suspension, and as all
/// four arms of the vehicle. The thesis has no numbers for them.
namespace mimbre::app {
namespace {

using Reduction = fe::ModelReduction;

/// A mechanism in which the arm bends, and the output that is compared.
struct ArmModel {
  std::string file, body_file, body, output;
  double step = 0;
  std::string more = {};  ///< of the model file
};

/// The four interfaces need a joint at the rear eye, as in the suspension.
std::string rear_eyes() {
  std::string joints = "joints:\n";
  for (const char* corner : {"front_left", "front_right", "rear_left", "rear_right"})
    joints += fmt::format(
        "  {0}_rear_eye: {{type: cylindrical, between: [chassis, {0}.arm.rear], axis: [1, 0, 0], cut: "
        "always}}\n",
        corner);
  return joints;
}

const ArmModel suspension{"solid-arm/suspension.yaml", "solid-arm/arm.h5", "front_left.arm", "arm.deflection",
                          0.002};
const ArmModel vehicle{
    "iltis/vehicle.yaml", "solid-arm/arm-held.h5", "front_left.arm", "arm.front_left.deflection", 0.01,
    rear_eyes()};

fe::FeCompanions steel() {
  fe::FeCompanions companions;
  companions.materials = {{"", {2.1e11, 0.3, 7850}}};
  return companions;
}

/// Reduces the arm and runs a mechanism with it.
class ArmLab {
 public:
  ArmLab(const ExampleFolder& examples, const ArmModel& model)
      : model_(model),
        body_path_(examples.path(model.body_file)),
        mesh_(fe::read_model(examples.path("solid-arm/arm.msh"), steel(), {1e-3, 1e3, 1})) {
    const std::vector<std::string> names{"front", "rear", "ball", "shock"};
    InterfaceOptions options;
    for (const std::string& name : names)
      options.interfaces.push_back(name + "=group:" + (name == "shock" ? "seat" : name));
    options.points = {"front=108,0,0", "rear=-108,0,0", "ball=0,321.4603,0", "shock=75,248.6166,-4.6668"};
    reduction_.interfaces = read_interfaces(options, mesh_.mesh, mesh_.matrices.dofs, 1e-3);
    reduction_.free_modes = 0;
    reduction_.stiffness_damping = 0.01;
    path_ = examples.path(model.file);
    if (model.more.empty()) return;
    const std::string included = path_;
    path_ = examples.path("bases.yaml");
    std::ofstream(path_) << "mimbre: 1\ninclude: [\"" << included << "\"]\n" << model.more;
  }

  ReducedBody reduced(Reduction::Basis basis, int modes) {
    reduction_.basis = basis;
    reduction_.dynamic_modes = modes;
    return fe::reduce(mesh_.mesh, mesh_.matrices, reduction_).body;
  }

  /// Combinations of the body's modes that a run of the mechanism needs for an error of its deflections.
  ReducedBody selected(const ReducedBody& body, double error) {
    const spec::Model spec = with(body);
    ModeSelectionOptions options;
    options.error = error;
    options.run.step = model_.step;
    const auto found = std::find_if(spec.bodies.begin(), spec.bodies.end(),
                                    [&](const spec::Body& b) { return b.name == model_.body; });
    return select_mechanism_modes(spec, static_cast<int>(found - spec.bodies.begin()), options).body;
  }

  /// The largest difference of the output from that with the reference's modes, by its range.
  double error(const ReducedBody& body) {
    if (exact_.empty()) exact_ = run(reduced(Reduction::Basis::modal_truncation, reference_modes));
    const std::vector<double> found = run(body);
    double worst = 0;
    for (std::size_t k = 0; k < exact_.size(); ++k) worst = std::max(worst, std::abs(found[k] - exact_[k]));
    const auto [least, most] = std::minmax_element(exact_.begin(), exact_.end());
    return worst / (*most - *least);
  }

 private:
  static constexpr int reference_modes = 40;

  spec::Model with(ReducedBody body) {
    body.name = "arm";
    save(body, body_path_);
    return load_model(path_, model_.more.empty() ? Settings{} : Settings{{"arms", "reduced"}});
  }

  std::vector<double> run(const ReducedBody& body) {
    RunOptions options;
    options.step = model_.step;
    Simulation simulation(Model::compile(with(body)), options);
    const auto& channels = simulation.channels();
    const auto channel = std::find_if(channels.begin(), channels.end(),
                                      [&](const ChannelInfo& c) { return c.name == model_.output; }) -
                         channels.begin();
    const auto steps = std::lround(simulation.model().spec().simulation.end / model_.step);
    std::vector<double> values;
    ResultsRow row;
    for (long k = 0; k < steps; ++k) {
      const StepReport report = simulation.step();
      if (interrupted()) throw Failure("interrupted");
      if (!report.ok()) throw std::runtime_error(simulation.explain(report));
      simulation.sample(row);
      values.push_back(row.channels[channel]);
    }
    return values;
  }

  ArmModel model_;
  std::string body_path_, path_;
  fe::FeModel mesh_;
  Reduction reduction_;
  std::vector<double> exact_;
};

struct BasisSeries {
  std::string name;
  Reduction::Basis basis;
  std::array<int, 4> counts;  ///< of modes beyond those that the basis has in any case
};

const std::vector<BasisSeries>& surveyed() {
  using Basis = Reduction::Basis;
  static const std::vector<BasisSeries> all{
      {"Craig–Bampton", Basis::craig_bampton, {0, 2, 5, 10}},
      {"free interface", Basis::free_interface, {0, 2, 5, 10}},
      {"eigenmodes with attachment modes", Basis::attachment, {0, 2, 5, 10}},
      {"modal truncation augmentation", Basis::modal_truncation, {0, 2, 5, 10}},
      {"Krylov", Basis::krylov, {6, 12, 18, 24}}};
  return all;
}

constexpr std::array sizes{"smallest", "small", "medium", "large"};

PublishedTable bases(const std::string& name, const std::string& title, const ArmModel& model) {
  return {name, title, [=](Lab& lab, const Report& report) {
            ArmLab arms(lab.examples(), model);
            Rows rows(report);
            const auto add = [&](const std::string& series, std::size_t k, const ReducedBody& body) {
              rows.add({series + ", modes", sizes[k], "1", {}, {}, {}},
                       [&](ReproducedRow&) { return static_cast<double>(body.modes); });
              rows.add({series + ", error", sizes[k], "%", {}, {}, {}},
                       [&](ReproducedRow&) { return 100 * arms.error(body); });
            };
            for (const BasisSeries& series : surveyed())
              for (std::size_t k = 0; k < sizes.size(); ++k)
                add(series.name, k, arms.reduced(series.basis, series.counts[k]));
            const ReducedBody candidates = arms.reduced(Reduction::Basis::craig_bampton, 10);
            constexpr std::array errors{0.2, 0.02, 0.005, 0.0005};
            for (std::size_t k = 0; k < sizes.size(); ++k)
              add("proper orthogonal", k, arms.selected(candidates, errors[k]));
            return rows.take();
          }};
}

}  // namespace

std::vector<PublishedTable> basis_tables() {
  return {bases("bases-solid-arm",
                "Solid arm in its suspension: error of its deflection by basis and number of modes (1; not "
                "published)",
                suspension),
          bases("bases-vehicle",
                "Vehicle with solid arms: error of an arm's deflection by basis and number of modes (1; not "
                "published)",
                vehicle)};
}

}  // namespace mimbre::app
