#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "joints/joint_kind.h"
#include "math/once/decompositions.h"
#include "mimbre/generate.h"
#include "portable/code_parts.h"
#include "portable/constants.h"
#include "portable/dependencies.h"
#include "portable/record.h"
#include "portable/refusals.h"
#include "portable/texts.h"
#include "portable/time_events.h"
#include "portable/write_tables.h"
#include "simulation/start/start.h"
#include "simulation/step/mechanism.h"

namespace mimbre {
namespace portable {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Equations that add less than this to others, as a share of the largest, are redundant.
constexpr double repeated = 1e-9;
/// A motion with less than this share of the largest inertia, along the scales, has none.
constexpr double no_inertia = 1e-13;

/// A velocity coordinate: its place among the positions (−1: of a rotation, which has a quaternion), its
/// weight in the choice of dependent coordinates (larger: chosen earlier), and its meaning.
struct CoordinateInfo {
  int position = -1;
  double weight = 1;
  bool angle = false, length = false;
  std::string meaning;
};

std::vector<CoordinateInfo> coordinate_infos(const Compiled& m) {
  // Stiff amplitudes are better independent. Rotations are better dependent: as states they need references.
  constexpr double rotation = 2, amplitude = 0.1;
  std::vector<CoordinateInfo> all(static_cast<std::size_t>(m.velocities));
  for (const BodyData& b : m.bodies) {
    const JointInfo& info = joint_info(b.joint);
    const std::string joint =
        b.joint_spec < 0 ? "" : m.spec().joints[static_cast<std::size_t>(b.joint_spec)].name;
    for (int k = 0; k < info.velocities; ++k) {
      CoordinateInfo& c = all[static_cast<std::size_t>(b.v + k)];
      const bool turns = info.quaternion >= 0 && k >= info.rotation;
      c.position = turns ? -1 : b.q + k;
      c.weight = turns ? rotation : 1;
      c.angle = turns || is_angle(b.joint, k);
      c.length = !c.angle;
      c.meaning = info.velocities > 1 ? fmt::format("coordinate {} of joint '{}'", k, joint)
                                      : fmt::format("joint '{}'", joint);
    }
    for (int k = 0; k < b.modes; ++k) {
      CoordinateInfo& c = all[static_cast<std::size_t>(b.v + b.joint_velocities + k)];
      c.position = b.q + b.joint_positions + k;
      c.weight = amplitude;
      c.meaning = fmt::format("amplitude {} of body '{}'", k + 1,
                              m.spec().bodies[static_cast<std::size_t>(b.spec)].name);
    }
  }
  return all;
}

/// Writes the code for the derivatives of one model.
class ExchangeGenerator {
 public:
  ExchangeGenerator(const Compiled& m, const Method& method, const std::map<std::string, double>& inputs,
                    const std::string& name)
      : m_(m),
        method_(method),
        name_(name),
        mechanism_(m, method),
        coordinates_(coordinate_infos(m)),
        events_(time_events(m)) {
    start(mechanism_, method, inputs, false);
    recorded_ = record_instant(m);
    refuse_unknown_rates();
    find_independent();
    if (!reasons_.empty()) throw InputError(std::move(reasons_));
  }

  GeneratedCode write() {
    out_.name = name_;
    out_.step = method_.step;
    out_.left_out = recorded_->left_out;
    out_.varies = recorded_->without_variations.empty();
    name_variables(m_, mechanism_.state, *recorded_, out_);
    name_states();
    const PhaseCode phases = write_phases(recorded_->program, name_);
    for (const long operations : phases.operations) out_.operations += operations;
    write_header(phases.kept);
    out_.source = fmt::format(
        "/* {0}: derivatives of the state by time, made by mimbre; see {1}.h. */\n#include "
        "\"{1}.h\"\n\n#include <float.h>\n#include <math.h>\n#include <string.h>\n\ntypedef char "
        "{1}_size[sizeof({1}) == {2}_BYTES ? 1 : -1];\n\n",
        comment(title()), name_, upper());
    write_constants();
    write_tables();
    out_.source += write_callees(recorded_->program.recording, name_);
    out_.source += phases.text + named(finite_text, name_) + named(exchange_text, name_);
    return std::move(out_);
  }

 private:
  std::string title() const { return m_.spec().title.empty() ? name_ : m_.spec().title; }
  std::string upper() const { return upper_case(name_); }
  const Scales& scales() const { return mechanism_.observer.scales(); }
  int size_of(Memory memory) const { return recorded_->program.sizes[static_cast<std::size_t>(memory)]; }

  /// For one list of all reasons; each reason once.
  void refuse(const std::string& text) {
    const auto same = [&](const Diagnostic& d) { return d.message == text; };
    if (std::none_of(reasons_.begin(), reasons_.end(), same))
      reasons_.push_back({{m_.spec().file, 0, 0}, text});
  }

  /// Importers provide no derivatives of inputs, and accelerations follow from forces.
  void refuse_unknown_rates() {
    for (const int equation : equations_of_inputs(*recorded_, m_.signals)) {
      const auto drive = std::find_if(m_.drives.begin(), m_.drives.end(),
                                      [&](const DriveData& d) { return d.equation == equation; });
      if (drive == m_.drives.end())
        refuse(
            "an equation depends on an input, whose rate and acceleration importers do not provide; write "
            "an FMU for co-simulation");
      else
        refuse(fmt::format(
            "the drive of joint '{}' follows an input, whose rate and acceleration importers do not "
            "provide: let an actuator's force follow it, or write an FMU for co-simulation",
            m_.spec().joints[static_cast<std::size_t>(drive->joint_spec)].name));
    }
    if (signals_see_accelerations(*recorded_, m_.signals))
      refuse(
          "a signal depends on accelerations, which follow from the forces that signals decide; write an "
          "FMU for co-simulation");
  }

  /// Finds how many coordinates depend on others, at the start, and motions that move no mass.
  void find_independent() {
    relative::RelativeSystem& system = mechanism_.observer;
    const State& s = mechanism_.state;
    const int n = m_.velocities, m = m_.equations;
    mechanism_.enter(0);
    system.begin_step(s.q.data());
    VectorXd r(n);
    system.residual(s.time, s.q.data(), s.v.data(), s.a.data(), s.multipliers.data(), 0, r.data());
    MatrixXd mass(n, n), jacobian = MatrixXd::Zero(n, m);
    system.dense_matrix(s.q.data(), {0, 0, 0}, mass.data());
    for (int k = 0; k < m; ++k) {
      VectorXd one = VectorXd::Zero(m);
      one[k] = 1 / scales().equations[static_cast<std::size_t>(k)];
      system.add_jacobian_transposed(one.data(), 1, jacobian.col(k).data());
    }
    const VectorXd scale = Eigen::Map<const VectorXd>(scales().coordinates.data(), n);
    const MatrixXd scaled = jacobian.transpose() * scale.asDiagonal();
    MatrixXd motions = MatrixXd::Identity(n, n);
    if (m > 0 && scaled.cwiseAbs().maxCoeff() > 0) {
      rank_ = order_columns(scaled, repeated).rank;
      motions = null_space(scaled, repeated);
    }
    free_ = n - rank_;
    if (free_ == 0) return;
    const MatrixXd projected = motions.transpose() * scale.asDiagonal() * mass * scale.asDiagonal() * motions;
    refuse_massless(motions, symmetric_eigen(MatrixXd(0.5 * (projected + projected.transpose()))));
  }

  /// Of the motions that the equations leave free, those whose inertia is zero, by coordinates that span
  /// them.
  void refuse_massless(const MatrixXd& motions, const EigenPairs& inertia) {
    Eigen::Index count = 0;
    while (count < inertia.values.size() &&
           !(inertia.values[count] > no_inertia * inertia.values[inertia.values.size() - 1]))
      ++count;
    if (inertia.ok && count == 0) return;
    const MatrixXd massless = motions * inertia.vectors.leftCols(std::max<Eigen::Index>(count, 1));
    const std::vector<int> coordinates = order_columns(massless.transpose()).order;
    for (Eigen::Index k = 0; k < massless.cols(); ++k)
      refuse(fmt::format(
          "{} moves no mass, so that it has no acceleration; give its body a mass, or write an "
          "FMU for co-simulation",
          coordinates_[static_cast<std::size_t>(coordinates[static_cast<std::size_t>(k)])].meaning));
  }

  void name_states() {
    const bool fixed = rank_ == 0;
    const auto position = [&](int k) {
      const CoordinateInfo& c = coordinates_[static_cast<std::size_t>(k)];
      return fixed ? c.meaning : fmt::format("independent position {}", k + 1);
    };
    const auto unit = [&](int k, const char* angle, const char* length) {
      const CoordinateInfo& c = coordinates_[static_cast<std::size_t>(k)];
      return std::string(!fixed ? "" : c.angle ? angle : c.length ? length : "");
    };
    for (int k = 0; k < free_; ++k)
      out_.states.push_back({position(k), unit(k, "rad", "m"), unit(k, "rad/s", "m/s")});
    for (int k = 0; k < free_; ++k)
      out_.states.push_back({"rate of " + position(k), unit(k, "rad/s", "m/s"), unit(k, "rad/s^2", "m/s^2")});
    for (const RememberedState& s : recorded_->states) out_.states.push_back({s.meaning, "", ""});
    out_.indicators = (rank_ > 0 && free_ > 0 ? 1 : 0) + static_cast<int>(rotations().size());
  }

  /// First velocity coordinate and first number of the quaternion.
  std::vector<std::pair<int, int>> rotations() const {
    std::vector<std::pair<int, int>> all;
    for (const BodyData& b : m_.bodies) {
      const JointInfo& info = joint_info(b.joint);
      if (info.quaternion >= 0) all.emplace_back(b.v + info.rotation, b.q + info.quaternion);
    }
    return all;
  }

  StructText state_struct() const {
    const long all = std::ssize(out_.states);
    StructText s;
    s.add("q", m_.positions, "positions from which x is counted");
    s.add("x", m_.velocities, "increments from there, of the last solution");
    s.add("c", all, "continuous states");
    s.add("at", all, "those of the last solution");
    s.add("z", std::ssize(m_.states), "states of force elements");
    s.add("u", std::ssize(m_.signals.start), "inputs, and states of signals");
    s.text += "  double time, at_time, last_event, next_event, quality;\n";
    s.doubles += 5;
    s.add_ints("independent", free_);
    s.add_ints("dependent", rank_);
    s.add_ints("row", rank_);
    s.text += "  int begun, closed, lost;\n";
    s.ints += 3;
    even(s);
    return s;
  }
  StructText work_struct(int kept) const {
    const long n = m_.velocities, m = m_.equations, f = free_, r = rank_;
    StructText s;
    for (const auto& [member, size] : {std::pair("origin", 3L),
                                       {"q", long{m_.positions}},
                                       {"moved", long{m_.positions}},
                                       {"v", n},
                                       {"a", n},
                                       {"x", n},
                                       {"good_x", n},
                                       {"x_rate", n},
                                       {"r", n},
                                       {"multipliers", m},
                                       {"phi", m},
                                       {"phi_dot", m},
                                       {"phi_ddot", m},
                                       {"dense", m * n},
                                       {"rows_of", r * n},
                                       {"lu", r * r},
                                       {"b", r},
                                       {"motions", n * f},
                                       {"momentum", n * f},
                                       {"projected", f * f},
                                       {"acceleration", f},
                                       {"derivative", long(std::ssize(out_.states))},
                                       {"now", 1L},
                                       {"next_z", long(std::ssize(m_.states))},
                                       {"next_u", long(std::ssize(m_.signals.start))},
                                       {"kept", long{kept}}})
      s.add(member, size);
    for (const Memory memory : {Memory::slot, Memory::rate, Memory::second, Memory::jacobian, Memory::mass,
                                Memory::state_rate, Memory::output})
      s.add(name_of(memory), size_of(memory));
    if (recorded_->without_variations.empty()) {
      for (const auto& [member, size] : {std::pair("d_q", long{m_.positions}),
                                         {"d_v", n},
                                         {"d_a", n},
                                         {"d_x", n},
                                         {"d_x_rate", n},
                                         {"d_r", n},
                                         {"d_multipliers", m},
                                         {"d_phi", m},
                                         {"d_phi_dot", m},
                                         {"d_phi_ddot", m},
                                         {"d_u", long(std::ssize(m_.signals.start))},
                                         {"d_z", long(std::ssize(m_.states))}})
        s.add(member, size);
      for (const Memory memory :
           {Memory::d_slot, Memory::d_rate, Memory::d_second, Memory::d_state_rate, Memory::d_output})
        s.add(name_of(memory), size_of(memory));
    }
    s.text += "  double quality;\n";
    ++s.doubles;
    s.add_ints("pivot", r);
    s.add_ints("used_row", m);
    s.add_ints("used_column", n);
    s.text += "  int ready, status, shown;\n";
    s.ints += 3;
    even(s);
    return s;
  }
  /// Avoids padding at the end of a struct.
  static void even(StructText& s) {
    if (s.ints % 2 != 0) s.add_ints("spare", 1);
  }

  void write_header(int kept) {
    const StructText state = state_struct(), work = work_struct(kept);
    out_.bytes = 8 * (state.doubles + work.doubles) + 4 * (state.ints + work.ints);
    std::string& h = out_.header;
    h = fmt::format(
        "/* {0}\n *\n * Derivatives of the state by time, for solvers of ordinary differential equations, "
        "made by "
        "mimbre from {1}.\n * Needs the functions of <math.h>, memcmp, memcpy and memset; allocates nothing, "
        "opens "
        "nothing, and keeps\n * its data in one struct of the caller's.\n",
        comment(title()), comment(std::filesystem::path(m_.spec().file).filename().string()));
    if (!out_.left_out.empty()) {
      h += " *\n * Outputs of the model that the code does not have:\n";
      for (const std::string& name : out_.left_out) h += fmt::format(" *   {}\n", comment(name));
    }
    h += fmt::format(" */\n#ifndef {0}_H\n#define {0}_H\n\n#ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n",
                     upper());
    h += fmt::format(
        "#define {0}_BYTES {1} /* of the struct */\n#define {0}_INPUTS {2}\n#define {0}_OUTPUTS {3}\n",
        upper(), out_.bytes, out_.inputs.size(), out_.outputs.size());
    h += fmt::format("#define {0}_STATES {1} /* continuous ones */\n#define {0}_INDICATORS {2}\n\n", upper(),
                     out_.states.size(), out_.indicators);
    h += variable_names(out_);
    h += state_names();
    h += fmt::format(
        "\n/* Results of functions. */\nenum {{\n  {0}_OK = 0,\n  {0}_NOT_FINITE = 2,\n  {0}_SINGULAR = 3,\n"
        "  {0}_DRIFTED = 4, /* equations that were not chosen are violated */\n"
        "  {0}_NOT_CONVERGED = 5, /* no positions of these states are found */\n"
        "  {0}_NO_SUCH = 6 /* no such input, or no number for it */\n}};\n\n",
        upper());
    h += fmt::format(
        "/* Everything that later calls depend on. */\ntypedef struct {{\n{0}}} {1}_state;\n\n/* With the "
        "place in "
        "which "
        "motions are found. */\ntypedef struct {{\n  {1}_state state;\n{2}}} {1};\n\n",
        state.text, name_, work.text);
    h += named(exchange_header_text, name_);
    if (out_.varies) h += named(variations_header_text, name_);
    h += "\n";
    h += "#ifdef __cplusplus\n}\n#endif\n\n#endif\n";
  }

  /// A list of the continuous states, as a comment.
  std::string state_names() const {
    std::string h = "\n/* Continuous states.\n";
    for (std::size_t k = 0; k < out_.states.size(); ++k)
      h += fmt::format(" * {}: {}{}\n", k, comment(out_.states[k].meaning),
                       out_.states[k].unit.empty() ? "" : ", " + out_.states[k].unit);
    return h + " */\n";
  }

  void write_constants() {
    const Constants define(out_.source, name_);
    define.of_header(name_, {"OK", "NOT_FINITE", "SINGULAR", "DRIFTED", "NOT_CONVERGED", "NO_SUCH", "INPUTS",
                             "OUTPUTS", "INDICATORS"});
    define("N", long{m_.velocities});
    define("M", long{m_.equations});
    define("Q", long{m_.positions});
    define("J", long{std::ssize(recorded_->jacobian)});
    define("R", long{rank_});
    define("F", long{free_});
    define("W", long{std::ssize(recorded_->states)});
    define("C", long{std::ssize(out_.states)});
    define("MASS", long{std::ssize(recorded_->mass)});
    define("ROTATIONS", long{std::ssize(rotations())});
    define("TURNS", long{std::ssize(turns())});
    define("EVENTS", long{std::ssize(events_)});
    define("VARIES", long{recorded_->without_variations.empty()});
    define("SENSES", long{recorded_->senses});
    define("BLOCKS", long{recorded_->blocks});
    define("START_TIME", mechanism_.state.time);
    const double pace = scales().acceleration > 0 ? std::sqrt(scales().acceleration) : 1;
    define("PACE", pace);
  }

  /// States that count the turns of elements.
  std::vector<int> turns() const {
    std::vector<int> all;
    for (const ElementData& e : m_.elements)
      for (int k = 0; k < e.own_states; ++k) all.push_back(e.states + k);
    return all;
  }

  void write_tables() {
    std::string& s = out_.source;
    const auto numbers = [&](const char* name, const auto& values) {
      s += table(fmt::format("{}_{}", name_, name), std::vector<double>(values.begin(), values.end()));
    };
    const auto integers = [&](const char* name, const std::vector<int>& values) {
      s += table(fmt::format("{}_{}", name_, name), values);
    };
    s += "\n";
    std::vector<int> position, first, quaternion, rows, columns, mass_rows, mass_columns;
    std::vector<double> weight;
    for (std::size_t k = 0; k < coordinates_.size(); ++k) {
      position.push_back(coordinates_[k].position);
      weight.push_back(coordinates_[k].weight * scales().coordinates[k]);
    }
    for (const auto& [v, q] : rotations()) {
      first.push_back(v);
      quaternion.push_back(q);
    }
    for (const JacobianEntry& e : recorded_->jacobian) {
      rows.push_back(e.equation);
      columns.push_back(e.coordinate);
    }
    for (const JacobianEntry& e : recorded_->mass) {
      mass_rows.push_back(e.equation);
      mass_columns.push_back(e.coordinate);
    }
    integers("position_of", position);
    integers("rotation", first);
    integers("quaternion", quaternion);
    integers("j_row", rows);
    integers("j_column", columns);
    integers("mass_row", mass_rows);
    integers("mass_column", mass_columns);
    integers("turn", turns());
    numbers("equation_scale", scales().equations);
    numbers("coordinate_scale", scales().coordinates);
    numbers("weight", weight);
    s += named(
        "typedef struct {\n  int held, at, integral;\n} @_remembered_state;\nstatic const @_remembered_state "
        "@_remembered[] = {\n",
        name_);
    for (const RememberedState& r : recorded_->states) {
      const auto& integrals = m_.signals.integrals;
      const bool integral = r.held && std::any_of(integrals.begin(), integrals.end(),
                                                  [&](const auto& i) { return i.held == r.at; });
      s += fmt::format("  {{{}, {}, {}}},\n", r.held ? 1 : 0, r.at, integral ? 1 : 0);
    }
    if (recorded_->states.empty()) s += "  {0, 0, 0}\n";
    s += named(
        "};\n/* Where functions of time jump or have kinks; repeated with the period, where there is one. "
        "*/\n"
        "typedef struct {\n  double time, period;\n} @_event;\nstatic const @_event @_events[] = {\n",
        name_);
    for (const TimeEvent& e : events_)
      s += fmt::format("  {{{}, {}}},\n", literal(e.time), literal(e.period));
    if (events_.empty()) s += "  {0, 0}\n";
    s += "};\n";
    s += held_inputs(m_, out_);
    const State& state = mechanism_.state;
    numbers("start_q", state.q);
    numbers("start_v", state.v);
    numbers("start_z", state.z);
    numbers("start_u", state.u);
    s += "\n";
  }

  const Compiled& m_;
  const Method& method_;
  const std::string name_;
  Mechanism mechanism_;
  const std::vector<CoordinateInfo> coordinates_;
  const std::vector<TimeEvent> events_;
  std::unique_ptr<RecordedModel> recorded_;
  int rank_ = 0, free_ = 0;
  std::vector<Diagnostic> reasons_;  ///< why there is no code
  GeneratedCode out_;
};

}  // namespace
}  // namespace portable

GeneratedCode generate_exchange_code(const std::shared_ptr<const Model>& model, const RunOptions& options,
                                     const std::string& name) {
  portable::check_type_name(name);
  const Compiled& m = model->compiled();
  const Method method = resolve_method(m.spec().simulation, options);
  std::vector<Diagnostic> reasons = portable::exchange_refusals(m, method);
  if (!reasons.empty()) throw InputError(std::move(reasons));
  try {
    return portable::ExchangeGenerator(m, method, options.inputs, name).write();
  } catch (const NotRecordable& reason) {
    throw InputError({m.spec().file, 0, 0},
                     fmt::format("code cannot be made of this model: it {}", reason.what()));
  }
}

}  // namespace mimbre
