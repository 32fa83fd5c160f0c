#include "mimbre/generate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <set>

#include "dynamics/tangent_marks.h"
#include "integrate/rule.h"
#include "integrate/stepper.h"
#include "portable/code_parts.h"
#include "portable/constants.h"
#include "portable/record.h"
#include "portable/refusals.h"
#include "portable/texts.h"
#include "portable/write_tables.h"
#include "signals/blocks/delay.h"
#include "signals/once/sampled_chains.h"
#include "signals/values.h"
#include "simulation/start/start.h"
#include "simulation/step/event_step.h"
#include "simulation/step/mechanism.h"

namespace mimbre {
namespace portable {
namespace {

/// Everything that is written of one model.
class Generator {
 public:
  Generator(const Compiled& m, const Method& method, const std::map<std::string, double>& inputs,
            const std::string& name, bool varies)
      : m_(m), method_(method), name_(name), mechanism_(m, method) {
    options_.step = method.step;
    options_.rule = method.integrator;
    options_.rho = method.rho;
    options_.xi = method.xi;
    options_.tolerance = method.tolerance;
    options_.penalty = method.penalty;
    options_.max_iterations = method.max_iterations;
    rule_ = rule_coefficients(options_);
    const double h = method.step;
    scale_ = (1 - rule_.alpha_f) / (1 - rule_.alpha_m) * rule_.beta * h * h;
    rate_ = rule_.gamma / (rule_.beta * h);
    start(mechanism_, method, inputs, false);
    const double* alpha = mechanism_.observer.penalty();
    penalty_.assign(alpha, alpha + m.equations);
    const TangentMarks marks(m);
    for (std::size_t k = 0; k < m.elements.size(); ++k) small_.push_back(marks.small(k));
    recorded_ = record_model(m, {rate_ * scale_, scale_, method.penalty}, penalty_, h, small_, varies);
    out_.varies = varies && recorded_->without_variations.empty();
  }

  GeneratedCode write() {
    out_.name = name_;
    out_.step = method_.step;
    out_.left_out = recorded_->left_out;
    out_.events = static_cast<int>(std::ssize(m_.spec().events));
    name_variables(m_, mechanism_.state, *recorded_, out_);
    const PhaseCode phases = write_phases(recorded_->program, name_);
    kept_ = phases.kept;
    count_operations(phases);
    write_struct();
    write_header();
    out_.source = fmt::format(
        "/* {0}: steps of {1} s with a fixed cost, made by mimbre; see {2}.h. */\n#include "
        "\"{2}.h\"\n\n#include "
        "<float.h>\n#include <math.h>\n#include <string.h>\n\ntypedef char {2}_size[sizeof({2}) == {3}_BYTES "
        "? 1 : -1];\n\n",
        comment(title()), method_.step, name_, upper());
    write_constants();
    write_tables();
    out_.source += write_callees(recorded_->program.recording, name_);
    out_.source += phases.text;
    write_exchange();
    write_samples();
    out_.source += named(linear_text, name_) + named(finite_text, name_) + named(integrator_text, name_) +
                   named(interface_text, name_);
    if (out_.varies) out_.source += named(variations_text, name_);
    return std::move(out_);
  }

 private:
  std::string title() const { return m_.spec().title.empty() ? name_ : m_.spec().title; }
  std::string upper() const { return upper_case(name_); }

  void count_operations(const PhaseCode& phases) {
    const auto of = [&](std::string_view phase) {
      for (std::size_t k = 0; k < recorded_->program.phases.size(); ++k)
        if (recorded_->program.phases[k].name == phase) return phases.operations[k];
      return 0L;
    };
    long factor = 0, solve = 0;
    for (const linalg::Panel& p : m_.symbolic.panels()) {
      for (int j = 0; j < p.columns; ++j) factor += static_cast<long>(p.stride) * (2 * j + 2);
      solve += 4L * p.columns * p.stride;
      for (int u = p.first_update; u < p.last_update; ++u) {
        const linalg::PanelUpdate& t = m_.symbolic.updates()[static_cast<std::size_t>(u)];
        factor += 2L * t.rows * t.columns * p.columns;
      }
    }
    const long n = m_.velocities, j = static_cast<long>(recorded_->jacobian.size());
    const long sight = of("sense_step") + of("see_step") + most_signal_rounds * of("sense_round_step");
    const long evaluation = of("motion") + sight + of("forces_step");
    const long iteration = evaluation + of("retract") + of("compose") + of("assemble") + of("tangents") +
                           factor + solve + 4 * j + 30 * n;
    const long projection = 6 * (solve + 4 * j + 4 * n);
    const bool equations = m_.equations > 0;
    // Without blocks signals at rest are those of a step.
    const std::string rest = recorded_->blocks ? "rest" : "step";
    const long look = of("origin") + of("signals_" + rest) + of("motion") + of("sense_" + rest) +
                      of("see_" + rest) + most_signal_rounds * of("sense_round_" + rest);
    const long forces = of(recorded_->rests ? "forces_rest" : "forces_step");
    const long jumps =
        recorded_->blocks ? (relays() > 0 ? longest_chain : 1) * (look + of("keep_blocks_rest")) : 0;
    long samples = 0;
    for (std::size_t k = 0; k < recorded_->program.phases.size(); ++k)
      if (recorded_->program.phases[k].name.starts_with("sample_")) samples += phases.operations[k];
    if (samples > 0) samples += look + forces;
    // Before the step and at its end.
    const long events =
        m_.spec().events.empty() ? 0 : 2 * (1 + longest_chain) * (jumps + look + forces + of("events"));
    const long flights = recorded_->flights.empty()
                             ? 0
                             : look + of("flight_begin") + of("flight_rates") + 2 * of("flight_gain") +
                                   of("flight_end") + 4 * of("motion");
    out_.operations = samples + 2 * jumps + events + flights + of("origin") + of("signals_step") +
                      method_.max_iterations * iteration + of("retract") +
                      of("motion") * (equations ? 7 : 1) + (equations ? 7 * projection : 0) + sight +
                      of("commit") + 20 * n;
  }

  /// Continuous ones.
  std::ptrdiff_t relays() const {
    return std::count_if(m_.signals.blocks.begin(), m_.signals.blocks.end(), [](const SignalsData::Block& b) {
      return block_info(b.type).relay && !(b.every > 0);
    });
  }

  int size_of(Memory memory) const { return recorded_->program.sizes[static_cast<std::size_t>(memory)]; }

  void write_struct() {
    const int n = m_.velocities, m = m_.equations, q = m_.positions;
    const int marked = static_cast<int>(recorded_->marked.size());
    StructText state, work;
    state.add("q", q, "positions");
    state.add("v", n, "velocities");
    state.add("a", n, "accelerations");
    state.add("algorithmic", n);
    state.add("multipliers", m);
    state.add("z", static_cast<long>(m_.states.size()), "what force elements remember");
    state.add("u", static_cast<long>(m_.signals.start.size()), "inputs, and what signals remember");
    state.add("last", n);
    state.add("before", n);
    state.add("mark_kept", marked);
    const int events = static_cast<int>(std::ssize(m_.spec().events));
    if (events > 0) {
      state.add("event_side", events, "of zero on which an event's value is");
      state.add("happened", events, "how often, and when last");
      state.add("when", events);
      state.add("settled", 1, "what was set has made its events happen");
    }
    state_ = state.text + "  double time;\n  int known, order, started, begun;\n";
    std::set<std::string> there;
    for (std::size_t k = 0; k < memories; ++k) {
      const Memory memory = static_cast<Memory>(k);
      const std::string member = name_of(memory);
      if (member.starts_with("state.") || of_exchange(memory) || !there.insert(member).second) continue;
      long size = size_of(memory);
      if (memory == Memory::residual || memory == Memory::correction || memory == Memory::v ||
          memory == Memory::a || memory == Memory::algorithmic)
        size = n;
      if (memory == Memory::q || memory == Memory::moved) size = q;
      if (memory == Memory::matrix || memory == Memory::assembled)
        size =
            memory == Memory::assembled && marked == 0 ? 0 : m_.symbolic.value_count() + 2 * linalg::kLanes;
      if (memory == Memory::difference) size = 36;
      work.add(member, size);
    }
    int stride = 4, columns = 1;
    for (const linalg::Panel& p : m_.symbolic.panels()) {
      stride = std::max(stride, p.stride);
      columns = std::max(columns, p.columns);
    }
    work.add("kept", kept_);
    work.add("scaled", static_cast<long>(stride) * columns);
    work.add("inverse", n);
    work.add("column", stride);
    work.add("tangent_kept", size_of(Memory::tangent));
    for (const char* member : {"start_a", "start_algorithmic", "rest_r", "unprojected", "nearest_x", "own",
                               "error", "rest", "new_x", "new_d"})
      work.add(member, n);
    for (const char* member : {"start_multipliers", "stuck_multipliers", "g", "impulse", "force", "rates",
                               "violation", "nearest_multipliers", "multipliers_before"})
      work.add(member, m);
    // At the start loads of inertia are mixed with multipliers.
    const int along = recorded_->loads ? m + n : m;
    if (recorded_->loads) work.add("along", along);
    work.add("new_y", along);
    for (const auto& [member, size] :
         {std::pair("mix_x[5]", n), std::pair("mix_y[5]", along), std::pair("mix_d[5]", n)}) {
      work.add(member, size);
      work.doubles += 4L * std::max(size, 1);
    }
    if (out_.varies) {
      work.add(name_of(Memory::d_held), std::ssize(m_.signals.start));
      for (const Memory memory : {Memory::d_time, Memory::d_slot, Memory::d_rate, Memory::d_output})
        work.add(name_of(memory), size_of(memory));
    }
    work_ = work.text +
            "  int iterations, factorisations, unconverged; /* of the last step */\n  int replaced, mixed, "
            "shown;\n";
    out_.bytes = 8 * (state.doubles + work.doubles + 1) + 4 * (4 + 6);
  }

  void write_header() {
    std::string& h = out_.header;
    h = fmt::format(
        "/* {0}\n *\n * Steps of {1} s with a fixed cost of {2} iterations at most, made by mimbre from "
        "{3}.\n"
        " * {4} operations in a step at most. Needs the functions of <math.h>, memcpy and memset; allocates "
        "nothing,\n"
        " * opens nothing, and keeps what it knows in one struct of the caller's.\n",
        comment(title()), method_.step, method_.max_iterations,
        comment(std::filesystem::path(m_.spec().file).filename().string()), out_.operations);
    if (!out_.left_out.empty()) {
      h += " *\n * Outputs of the model that are not here:\n";
      for (const std::string& name : out_.left_out) h += fmt::format(" *   {}\n", comment(name));
    }
    h += fmt::format(" */\n#ifndef {0}_H\n#define {0}_H\n\n#ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n",
                     upper());
    h += fmt::format("#define {}_STEP {} /* s */\n", upper(), literal(method_.step));
    h += fmt::format("#define {}_BYTES {} /* of the struct */\n", upper(), out_.bytes);
    h += fmt::format("#define {}_OPERATIONS {}L /* in a step at most */\n", upper(), out_.operations);
    h += fmt::format("#define {}_INPUTS {}\n#define {}_OUTPUTS {}\n\n", upper(), out_.inputs.size(), upper(),
                     out_.outputs.size());
    h += variable_names(out_) + variable_lists(out_);
    h += fmt::format(
        "\n/* What a step returns. Up to {0}_UNCONVERGED it was made. {0}_ENDED: an event of the model ends "
        "the run; the\n * step was made, unless the event happened before it. Others: it was not made, and "
        "the state is as before. */\n"
        "enum {{\n  {0}_OK = 0,\n  {0}_UNCONVERGED = 1, /* taken before the iterations had converged */\n"
        "  {0}_NOT_FINITE = 2,\n  {0}_SINGULAR = 3,\n  {0}_DRIFTED = 4, /* the loops have come apart */\n"
        "  {0}_NOT_CONVERGED = 5,\n  {0}_NO_SUCH = 6, /* no such input, or no number for it */\n"
        "  {0}_ENDED = 7\n}};\n\n",
        upper());
    h += fmt::format(
        "/* All that the next step depends on: may be copied, kept and given to another instance. "
        "*/\ntypedef struct "
        "{{\n{0}}} {1}_state;\n\n/* With the place in which a step is made. */\ntypedef struct {{\n  "
        "{1}_state "
        "state;\n{2}}} {1};\n\n",
        state_, name_, work_);
    h += named(
        "/* The model where it starts. */\nvoid @_init(@ *s);\n"
        "/* An input or a parameter from now on; kept within its range. */\nint @_set_input(@ *s, int input, "
        "double value);\n"
        "double @_get_input(const @ *s, int input);\n"
        "/* One step. */\nint @_step(@ *s);\n"
        "/* Of the state of now; not a number: there is no such output. */\ndouble @_get_output(@ *s, int "
        "output);\n"
        "double @_time(const @ *s);\n"
        "/* Events count crossings from the values of now on: of the start, after its inputs were set. */\n"
        "void @_start_events(@ *s);\n"
        "/* How many events of the model have happened. */\ndouble @_event_count(const @ *s);\n"
        "void @_save(const @ *s, @_state *state);\nvoid @_restore(@ *s, const @_state *state);\n\n",
        name_);
    if (out_.varies) h += named(variations_at_rest_header_text, name_);
    h += "#ifdef __cplusplus\n}\n#endif\n\n#endif\n";
  }

  void write_constants() {
    const RecordedModel& r = *recorded_;
    const Scales& scales = mechanism_.observer.scales();
    const Constants define(out_.source, name_);
    define.of_header(name_, {"OK", "UNCONVERGED", "NOT_FINITE", "SINGULAR", "DRIFTED", "NOT_CONVERGED",
                             "NO_SUCH", "ENDED", "INPUTS", "OUTPUTS"});
    define("N", static_cast<long>(m_.velocities));
    define("M", static_cast<long>(m_.equations));
    define("Q", static_cast<long>(m_.positions));
    define("PANELS", static_cast<long>(m_.symbolic.panels().size()));
    define("MARKED", static_cast<long>(r.marked.size()));
    define("SENSES", static_cast<long>(r.senses));
    define("STICKS", static_cast<long>(r.sticks));
    define("BLOCKS", static_cast<long>(r.blocks));
    define("CLOCK", static_cast<long>(m_.signals.clock));
    define("RESTS", static_cast<long>(r.rests));
    define("JUMPS", static_cast<long>(r.jumps && r.rests));
    define("REMEMBERS", static_cast<long>(r.remembers));
    define("STATES", static_cast<long>(m_.states.size()));
    define("HOLDS", static_cast<long>(r.blocks || !m_.signals.integrals.empty()));
    define("ITERATIONS", static_cast<long>(method_.max_iterations));
    define("LOADS", static_cast<long>(r.loads));
    define("START_ROUNDS", r.loads ? 40L : 8L);
    define("BROKEN_ROUNDS", 12L);
    define("SAMPLED", std::ssize(m_.signals.sampled));
    define("DELAYS", std::ssize(r.delays));
    define("EVENTS", std::ssize(m_.spec().events));
    define("EVENT_ROUNDS", static_cast<long>(longest_chain));
    define("RELAYS", static_cast<long>(relays()));
    define("FLIGHT_NUMBERS", static_cast<long>(flight_moved));
    define("FLIGHTS", std::ssize(r.flights));
    define("FLIGHT_TURNS", static_cast<long>(std::any_of(r.flights.begin(), r.flights.end(),
                                                         [](const RecordedFlight& f) { return !f.rigid; })));
    define("CIRCLE", static_cast<long>(r.circle.size()));
    define("SIGNAL_ROUNDS", static_cast<long>(most_signal_rounds));
    define("DEPTH", 5L);
    define("NEWMARK", static_cast<long>(method_.integrator == spec::Simulation::Integrator::newmark));
    define("H", method_.step);
    define("START_TIME", mechanism_.state.time);
    define("ALPHA_M", rule_.alpha_m);
    define("ALPHA_F", rule_.alpha_f);
    define("BETA", rule_.beta);
    define("GAMMA", rule_.gamma);
    define("SCALE", scale_);
    define("RATE", rate_);
    define("PENALTY", method_.penalty);
    define("TOLERANCE", method_.tolerance);
    define("POSITION_TOLERANCE", options_.position_tolerance);
    define("VELOCITY_TOLERANCE", options_.velocity_tolerance);
    define("ACCELERATION_TOLERANCE", options_.acceleration_tolerance);
    define("DRIFT_LIMIT", options_.drift_limit);
    define("ROUND_OFF", scales.round_off);
    define("ACCELERATION", scales.acceleration);
    out_.source += "\n";
  }

  template <class Values>
  void numbers(const char* name, const Values& values) {
    out_.source +=
        table(fmt::format("{}_{}", name_, name), std::vector<double>(values.begin(), values.end()));
  }
  void integers(const char* name, const std::vector<int>& values) {
    out_.source += table(fmt::format("{}_{}", name_, name), values);
  }

  void write_tables() {
    const RecordedModel& r = *recorded_;
    const Scales& scales = mechanism_.observer.scales();
    numbers("penalty", penalty_);
    numbers("equation_scale", scales.equations);
    numbers("coordinate_scale", scales.coordinates);
    std::vector<double> temper(static_cast<std::size_t>(m_.velocities), 1.0);
    mechanism_.observer.temper_prediction(method_.step, temper.data());
    for (double& x : temper) x = 1 / x;
    numbers("temper", temper);
    write_jacobian();
    write_panels();
    write_marked();
    if (!r.circle.empty()) integers("circle_slot", r.circle);
    write_delays();
    write_events();
    if (!r.flights.empty()) {
      std::vector<int> q, v;
      for (const RecordedFlight& f : r.flights) {
        q.push_back(f.q);
        v.push_back(f.v);
      }
      integers("flight_q", q);
      integers("flight_v", v);
    }
    out_.source += held_inputs(m_, out_);
    const State& state = mechanism_.state;
    numbers("start_q", state.q);
    numbers("start_v", state.v);
    numbers("start_a", state.a);
    numbers("start_multipliers", state.multipliers);
    numbers("start_z", state.z);
    numbers("start_u", state.u);
    out_.source += "\n";
  }

  /// Where the entries of the Jacobian are, row by row.
  void write_jacobian() {
    std::vector<int> rows, first, columns;
    for (const JacobianEntry& e : recorded_->jacobian) {
      if (rows.empty() || rows.back() != e.equation) {
        rows.push_back(e.equation);
        first.push_back(static_cast<int>(columns.size()));
      }
      columns.push_back(e.coordinate);
    }
    first.push_back(static_cast<int>(columns.size()));
    Constants(out_.source, name_)("ROWS", std::ssize(rows));
    integers("j_row", rows);
    integers("j_first", first);
    integers("j_column", columns);
  }

  /// Elements whose tangents are exchanged in the matrix.
  void write_marked() {
    if (recorded_->marked.empty()) return;
    std::string& s = out_.source;
    std::vector<double> small;
    s += named(
        "typedef struct {\n  int size, tangent, contact;\n} @_marked;\nstatic const @_marked "
        "@_marked_elements[] = {\n",
        name_);
    for (const MarkedElement& e : recorded_->marked) {
      s += fmt::format("  {{{}, {}, {}}},\n", e.size, e.tangent, e.contact ? 1 : 0);
      small.push_back(e.small);
    }
    s += "};\n";
    numbers("mark_small", small);
  }

  void write_delays() {
    if (recorded_->delays.empty()) return;
    std::string& s = out_.source;
    s += named(
        "typedef struct {\n  int held, inputs, room, sampled;\n  double time;\n} @_delay;\nstatic const "
        "@_delay "
        "@_all_delays[] = {\n",
        name_);
    for (const int k : recorded_->delays) {
      const SignalsData::Block& b = m_.signals.blocks[static_cast<std::size_t>(k)];
      s += fmt::format(
          "  {{{}, {}, {}, {}, {}}},\n", b.held, b.inputs, blocks::delay::room(b.states), b.every > 0 ? 1 : 0,
          literal(m_.signals.numbers[static_cast<std::size_t>(b.numbers + blocks::delay::time)]));
    }
    s += "};\n";
  }

  void write_events() {
    if (m_.spec().events.empty()) return;
    using Direction = spec::Event::Direction;
    std::string& s = out_.source;
    s += named(
        "typedef struct {\n  int direction, stops, first_set, last_set;\n} @_event;\nstatic const @_event "
        "@_all_events[] = {\n",
        name_);
    std::vector<int> inputs;
    for (const spec::Event& e : m_.spec().events) {
      const std::size_t first = inputs.size();
      for (const spec::Event::Set& set : e.sets) inputs.push_back(set.input);
      s += fmt::format("  {{{}, {}, {}, {}}},\n",
                       e.direction == Direction::either   ? 0
                       : e.direction == Direction::rising ? 1
                                                          : -1,
                       e.stop ? 1 : 0, first, inputs.size());
    }
    s += "};\n";
    if (inputs.empty()) inputs.push_back(0);
    s += table(name_ + "_event_inputs", inputs);
  }

  void write_panels() {
    std::string& s = out_.source;
    const linalg::BlockSymbolic& b = m_.symbolic;
    s += named(
        "typedef struct {\n  long offset;\n  int columns, stride, below, first, first_row, first_update, "
        "last_update;\n} @_panel;\nstatic const @_panel @_panels[] = {\n",
        name_);
    for (const linalg::Panel& p : b.panels())
      s += fmt::format("  {{{}, {}, {}, {}, {}, {}, {}, {}}},\n", p.offset, p.columns, p.stride, p.below,
                       p.first, p.first_row, p.first_update, p.last_update);
    s += named(
        "};\ntypedef struct {\n  long target;\n  int target_stride, row, column, rows, columns;\n} "
        "@_update;\nstatic const @_update @_updates[] = {\n",
        name_);
    for (const linalg::PanelUpdate& u : b.updates())
      s += fmt::format("  {{{}, {}, {}, {}, {}, {}}},\n", u.target, u.target_stride, u.row, u.column, u.rows,
                       u.columns);
    if (b.updates().empty()) s += "  {0, 0, 0, 0, 0, 0}\n";
    s += "};\n";
    s += table(name_ + "_unknown", std::vector<int>(b.unknowns().begin(), b.unknowns().end()));
    s += table(name_ + "_row", std::vector<int>(b.rows().begin(), b.rows().end()));
  }

  /// What is evaluated at instants: where its values are held, and of a block what it remembers.
  void write_samples() {
    const SignalsData& d = m_.signals;
    if (d.sampled.empty()) return;
    std::string& s = out_.source;
    s += named(
        "typedef struct {\n  int held, values, block, memory, delay, chained;\n  double every;\n} "
        "@_sampled;\nstatic const @_sampled @_all_sampled[] = {\n",
        name_);
    const std::vector<char> chained = takes_sampled(d);
    for (std::size_t k = 0; k < d.sampled.size(); ++k) {
      const SignalsData::Sampled& of = d.sampled[k];
      const SignalsData::Block* b = of.block < 0 ? nullptr : &d.blocks[static_cast<std::size_t>(of.block)];
      const auto delay = std::find(recorded_->delays.begin(), recorded_->delays.end(), of.block);
      const bool delays = b && delay != recorded_->delays.end();
      s += fmt::format("  {{{}, {}, {}, {}, {}, {}, {}}},\n", of.held, of.values, b ? b->held : -1,
                       delays ? 1 + b->inputs
                       : b    ? b->memory()
                              : 0,
                       delays ? delay - recorded_->delays.begin() : -1, static_cast<int>(chained[k]),
                       literal(of.every));
    }
    s += named("};\nstatic void @_evaluate_sampled(@ *s, int k, int begun) {\n  switch (k) {\n", name_);
    for (std::size_t k = 0; k < d.sampled.size(); ++k) {
      s += fmt::format("    case {}:\n", k);
      if (d.sampled[k].block >= 0)
        s += fmt::format("      if (!begun) {0}_sample_{1}_first(s);\n      if (begun)\n  ", name_, k);
      s += fmt::format("      {}_sample_{}_next(s);\n      break;\n", name_, k);
    }
    s += "    default:\n      break;\n  }\n  (void)begun;\n}\n\n";
  }

  void write_exchange() {
    if (recorded_->marked.empty()) return;
    std::string& s = out_.source;
    s += named("static void @_exchange(@ *s, int element, int fresh) {\n  switch (element) {\n", name_);
    for (std::size_t k = 0; k < recorded_->marked.size(); ++k) {
      s += fmt::format("    case {}:\n", k);
      if (recorded_->marked[k].contact) s += fmt::format("      if (fresh) {}_rows_{}(s);\n", name_, k);
      s += fmt::format("      {}_exchange_{}(s);\n      break;\n", name_, k);
    }
    s += "    default:\n      break;\n  }\n  (void)fresh;\n}\n\n";
  }

  const Compiled& m_;
  const Method& method_;
  const std::string name_;
  Mechanism mechanism_;
  IntegratorOptions options_;
  RuleCoefficients rule_;
  double scale_ = 0, rate_ = 0;
  std::vector<double> penalty_, small_;
  std::unique_ptr<RecordedModel> recorded_;
  std::string state_, work_;
  int kept_ = 0;
  GeneratedCode out_;
};

}  // namespace
}  // namespace portable

std::string identifier_of(const std::string& file) {
  return portable::identifier(std::filesystem::path(file).stem().string());
}

GeneratedCode portable::generate_steps(const std::shared_ptr<const Model>& model, const RunOptions& options,
                                       const std::string& name, bool varies) {
  portable::check_type_name(name);
  const Compiled& m = model->compiled();
  // As the model and the user have it: a fixed cost may not go with what is refused.
  std::vector<Diagnostic> reasons = portable::refusals(m, resolve_method(m.spec().simulation, options));
  if (!reasons.empty()) throw InputError(std::move(reasons));
  RunOptions fixed = options;
  fixed.fixed_cost = true;
  const Method method = resolve_method(m.spec().simulation, fixed);
  try {
    return portable::Generator(m, method, options.inputs, name, varies).write();
  } catch (const NotRecordable& reason) {
    throw InputError({m.spec().file, 0, 0},
                     fmt::format("code cannot be made of this model: it {}", reason.what()));
  }
}

GeneratedCode generate_code(const std::shared_ptr<const Model>& model, const RunOptions& options,
                            const std::string& name) {
  return portable::generate_steps(model, options, name, false);
}

void write_code(const GeneratedCode& code, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(Mark{}, fmt::format("cannot write into '{}': {}", folder, error.message()));
  for (const auto& [end, text] : {std::pair(".h", &code.header), std::pair(".c", &code.source)}) {
    const std::filesystem::path path = std::filesystem::path(folder) / (code.name + end);
    std::ofstream file(path, std::ios::binary);
    file << *text;
    file.close();
    if (!file)
      throw InputError(Mark{}, fmt::format("cannot write '{}': {}", path.string(), std::strerror(errno)));
  }
}

}  // namespace mimbre
